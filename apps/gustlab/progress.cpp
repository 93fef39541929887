#include "progress.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "messages.hpp"

namespace gustlab {

Progress::Progress()
    : visible_(spdlog::should_log(spdlog::level::info)),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      line_(terminal_) {}

double Progress::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::print(const std::string& text) {
  // carriage return, then clear what the line had more
  say_on_stderr(terminal_ ? fmt::format("\r{}\033[K", text) : text + "\n");
  shown_ = true;
}

void Progress::keep_up_to_date() {
  constexpr std::chrono::milliseconds between_looks{250};
  std::unique_lock lock(mutex_);
  while (!ended_.wait_for(lock, between_looks, [this] { return !running_; }))
    if (const auto text = line_.due(now_s())) print(*text);
}

void Progress::report(std::string what, std::optional<double> share) {
  if (!visible_) return;
  const std::lock_guard lock(mutex_);
  line_.report(std::move(what), share, now_s());
  if (running_) return;
  running_ = true;
  timer_ = std::thread([this] { keep_up_to_date(); });
}

void Progress::end() {
  {
    const std::lock_guard lock(mutex_);
    running_ = false;
  }
  ended_.notify_all();
  if (timer_.joinable()) timer_.join();
  if (shown_ && terminal_) {
    print(line_.text(now_s()));
    say_on_stderr("\n");
  }
  shown_ = false;
}

void Progress::show(std::size_t done, std::size_t all, std::string_view what) {
  report(fmt::format("{}/{} {}", done, all, what), static_cast<double>(done) / static_cast<double>(all));
}

void Progress::show(std::string_view stage, std::optional<double> done) {
  report(done ? fmt::format("{:.0f} %, {}", 100.0 * *done, stage) : std::string(stage), done);
}

ProgressReport Progress::report() {
  return [this](std::string_view stage, std::optional<double> done) { show(stage, done); };
}

}  // namespace gustlab
