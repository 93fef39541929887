#include "util/parallel.hpp"

#include <tbb/info.h>

#include <cassert>

#ifdef __SANITIZE_THREAD__
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

#ifdef __SANITIZE_THREAD__

// Debian's oneTBB is not instrumented, so the thread sanitizer sees no order between its tasks and calls everything a
// race; plain threads let it judge the bodies
void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body) {
  assert(jobs >= 1);
  std::atomic<std::int64_t> next{0};
  std::mutex mutex;
  std::exception_ptr thrown;
  const auto work = [&] {
    for (std::int64_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        next = count;
        const std::lock_guard lock(mutex);
        if (!thrown) thrown = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int k = 1; k < jobs; ++k) threads.emplace_back(work);
    work();
  }
  if (thrown) std::rethrow_exception(thrown);
}

#else

void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body) {
  assert(jobs >= 1);
  // one job needs no arena, and its order is that of the numbers
  if (jobs == 1) {
    for (std::int64_t i = 0; i < count; ++i) body(i);
    return;
  }
  // as many as were asked for, also on fewer cores; without this TBB warns and takes fewer
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(jobs));
  tbb::task_arena arena(jobs);
  arena.execute([&] { tbb::parallel_for(std::int64_t{0}, count, body, tbb::simple_partitioner()); });
}

#endif

int default_jobs() { return tbb::info::default_concurrency(); }

}  // namespace gustlab
