#include "progress.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>

namespace gustlab {

Progress::Progress() : visible_(spdlog::should_log(spdlog::level::info) && isatty(STDERR_FILENO) != 0) {}

void Progress::end() {
  if (shown_) std::fputs("\n", stderr);
  shown_ = false;
}

void Progress::show(std::size_t done, std::size_t all) {
  if (!visible_) return;
  const Clock::time_point now = Clock::now();
  if (!shown_) {
    first_ = done;
    start_ = now;
  } else if (done < all && now - last_ < std::chrono::milliseconds(100)) {
    return;
  }
  last_ = now;
  shown_ = true;
  std::string eta;
  if (done > first_ && done < all) {
    const double elapsed_s = std::chrono::duration<double>(now - start_).count();
    eta = fmt::format(", {:.0f} s left", elapsed_s * static_cast<double>(all - done) / static_cast<double>(done - first_));
  }
  // carriage return, then clear what the line had more
  fmt::print(stderr, "\r{}/{} runs{}\033[K", done, all, eta);
  std::fflush(stderr);
}

}  // namespace gustlab
