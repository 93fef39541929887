#include "progress.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>

namespace gustlab {

namespace {

constexpr std::chrono::milliseconds between_rewrites{100};
constexpr std::chrono::seconds between_lines{30};

}  // namespace

Progress::Progress()
    : visible_(spdlog::should_log(spdlog::level::info)), terminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()) {}

void Progress::end() {
  if (shown_ && terminal_) std::fputs("\n", stderr);
  shown_ = false;
}

void Progress::begin(double done) {
  if (time_left_) return;
  start_ = Clock::now();
  time_left_.emplace(done);
}

std::string Progress::left(double done) const {
  const auto seconds = time_left_->seconds(done, std::chrono::duration<double>(last_ - start_).count());
  return seconds ? fmt::format(", {:.0f} s left", *seconds) : "";
}

bool Progress::due(bool last_one) {
  if (!visible_) return false;
  const Clock::time_point now = Clock::now();
  const bool waited = terminal_ ? !shown_ || last_one || now - last_ >= between_rewrites
                                : now - (shown_ ? last_ : start_) >= between_lines;
  if (waited) last_ = now;
  return waited;
}

void Progress::print(const std::string& text) const {
  // carriage return, then clear what the line had more
  if (terminal_) fmt::print(stderr, "\r{}\033[K", text);
  else fmt::print(stderr, "{}\n", text);
  std::fflush(stderr);
}

void Progress::show(std::size_t done, std::size_t all, std::string_view what) {
  const double share = static_cast<double>(done) / static_cast<double>(all);
  begin(share);
  if (!due(done == all)) return;
  shown_ = true;
  print(fmt::format("{}/{} {}{}", done, all, what, left(share)));
}

void Progress::show(std::string_view stage, double done) {
  begin(done);
  // a stage is said as it begins
  if (!due(terminal_)) return;
  shown_ = true;
  print(fmt::format("{:.0f} %, {}{}", 100.0 * done, stage, left(done)));
}

ProgressReport Progress::report() {
  return [this](std::string_view stage, double done) { show(stage, done); };
}

}  // namespace gustlab
