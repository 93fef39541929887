#include "util/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "support/temporary_folder.hpp"

namespace gustlab {
namespace parallel_test {

class ParallelFor : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Jobs, ParallelFor, ::testing::Values(1, 2, 3, 8));

TEST_P(ParallelFor, CallsEveryNumberOnce) {
  for (const int count : {0, 1, 7, 1000}) {
    std::vector<int> calls(static_cast<std::size_t>(count), 0);
    parallel_for(count, GetParam(), [&](std::int64_t i) { ++calls[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(calls, std::vector<int>(static_cast<std::size_t>(count), 1));
  }
}

TEST_P(ParallelFor, NeverRunsMoreThanItsJobs) {
  std::atomic<int> running{0};
  std::atomic<int> most{0};
  parallel_for(200, GetParam(), [&](std::int64_t) {
    const int now = ++running;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::yield();
    --running;
  });
  EXPECT_GE(most, 1);
  EXPECT_LE(most, GetParam());
}

TEST_P(ParallelFor, ThrowsWhatABodyThrows) {
  const auto body = [](std::int64_t i) {
    if (i == 5) throw std::runtime_error("the sixth");
  };
  EXPECT_NO_THROW(parallel_for(5, GetParam(), body));
  EXPECT_THROW(parallel_for(6, GetParam(), body), std::runtime_error);
  EXPECT_THROW(parallel_for(1000, GetParam(), body), std::runtime_error);
}

TEST(DefaultJobs, IsAtLeastOne) { EXPECT_GE(default_jobs(), 1); }

TEST(DefaultJobs, KeepsToTheLeastQuotaOfItsControlGroups) {
  const TemporaryFolder folder;
  const std::string mounted = folder.path().string();
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(cpu_quota(folder.file("missing"), mounted), none);
  const std::string second = folder.write("list2", "0::/job/step\n");
  folder.write("job/step/cpu.max", "max 100000\n");
  EXPECT_EQ(cpu_quota(second, mounted), none);
  folder.write("job/cpu.max", "250000 100000\n");
  EXPECT_EQ(cpu_quota(second, mounted), 2.5);
  folder.write("cpu.max", "400000 100000\n");
  EXPECT_EQ(cpu_quota(second, mounted), 2.5);
  const std::string first = folder.write("list1", "5:memory:/job\n4:cpu,cpuacct:/job\n");
  folder.write("cpu/job/cpu.cfs_quota_us", "-1\n");
  folder.write("cpu/job/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(cpu_quota(first, mounted), none);
  folder.write("cpu/job/cpu.cfs_quota_us", "50000\n");
  EXPECT_EQ(cpu_quota(first, mounted), 0.5);
}

}  // namespace parallel_test
}  // namespace gustlab
