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

std::string Progress::left(double done) const {
  if (done <= first_ || done >= 1.0) return {};
  const double elapsed_s = std::chrono::duration<double>(last_ - start_).count();
  return fmt::format(", {:.0f} s left", elapsed_s * (1.0 - done) / (done - first_));
}

void Progress::print(const std::string& text) {
  // carriage return, then clear what the line had more
  fmt::print(stderr, "\r{}\033[K", text);
  std::fflush(stderr);
}

void Progress::show(std::size_t done, std::size_t all) {
  if (!visible_) return;
  const Clock::time_point now = Clock::now();
  const double share = static_cast<double>(done) / static_cast<double>(all);
  if (!shown_) first_ = share, start_ = now;
  else if (done < all && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  shown_ = true;
  print(fmt::format("{}/{} runs{}", done, all, left(share)));
}

void Progress::show(std::string_view stage, double done) {
  if (!visible_) return;
  last_ = Clock::now();
  if (!shown_) first_ = done, start_ = last_;
  shown_ = true;
  print(fmt::format("{:.0f} %, {}{}", 100.0 * done, stage, left(done)));
}

ProgressReport Progress::report() {
  return [this](std::string_view stage, double done) { show(stage, done); };
}

}  // namespace gustlab
