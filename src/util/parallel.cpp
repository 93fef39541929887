#include "util/parallel.hpp"

#include <tbb/info.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "util/interrupt.hpp"

#if defined(__SANITIZE_THREAD__)  // GCC
#define GUSTLAB_THREAD_SANITIZER
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)  // clang
#define GUSTLAB_THREAD_SANITIZER
#endif
#endif

#ifdef GUSTLAB_THREAD_SANITIZER
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>
#else
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace gustlab {

#ifdef GUSTLAB_THREAD_SANITIZER

// Debian's oneTBB is not instrumented, so the thread sanitizer sees no order between its tasks and calls everything a
// race; plain threads let it judge the bodies. Each has numbers of its own: to take the next of a common counter would put
// bodies of different threads in an order, and one thread may take all that are short.
void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body) {
  assert(jobs >= 1);
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&](std::int64_t first) {
    for (std::int64_t i = first; i < count && !stop.load(std::memory_order_relaxed); i += jobs) {
      try {
        throw_if_interrupted();
        body(i);
      } catch (...) {
        stop.store(true, std::memory_order_relaxed);
        const std::lock_guard lock(mutex);
        if (!thrown) thrown = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int k = 1; k < std::min<std::int64_t>(jobs, count); ++k) threads.emplace_back(work, k);
    work(0);
  }
  if (thrown) std::rethrow_exception(thrown);
}

#else

void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body) {
  assert(jobs >= 1);
  const auto careful = [&](std::int64_t i) {
    throw_if_interrupted();
    body(i);
  };
  // one job or one call needs no arena, and its order is that of the numbers
  if (jobs == 1 || count == 1) {
    for (std::int64_t i = 0; i < count; ++i) careful(i);
    return;
  }
  // as many as were asked for, also on fewer cores; without this TBB warns and takes fewer
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(std::int64_t{0}, count, careful, tbb::simple_partitioner()); });
}

#endif

double cpu_quota(const std::string& cgroup_list, const std::string& mounted_at) {
  namespace fs = std::filesystem;
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](std::istream& file) {
    // "max 100000" where there is no limit
    double quota_us = 0.0, period_us = 0.0;
    if (file >> quota_us >> period_us && quota_us > 0.0 && period_us > 0.0)
      least = std::min(least, quota_us / period_us);
  };
  std::ifstream list(cgroup_list);
  for (std::string line; std::getline(list, line);) {
    // 0::/path of version 2, 4:cpu,cpuacct:/path of version 1; a parent's limit holds for all below it
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && controllers.find("cpu") != 0) continue;
    const fs::path root = fs::path(mounted_at) / (controllers.empty() ? "" : "cpu");
    for (fs::path group = line.substr(second + 1);; group = group.parent_path()) {
      const fs::path folder = root / group.relative_path();
      std::ifstream both(folder / "cpu.max");
      take(both);
      std::ifstream quota(folder / "cpu.cfs_quota_us"), period(folder / "cpu.cfs_period_us");
      std::stringstream pair;
      pair << quota.rdbuf() << ' ' << period.rdbuf();
      take(pair);
      if (!group.has_relative_path()) break;
    }
  }
  return least;
}

int default_jobs() {
  // TBB counts the CPUs of the process's affinity
  const double quota = cpu_quota("/proc/self/cgroup", "/sys/fs/cgroup");
  return std::max(1, static_cast<int>(std::min<double>(tbb::info::default_concurrency(), std::ceil(quota))));
}

}  // namespace gustlab
