// A line on stderr that says how far long work is: kept up to date on a terminal, a new one every half a minute elsewhere (a log of a
// cluster), none with --quiet.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "util/progress.hpp"
#include "util/progress_line.hpp"

namespace gustlab {

class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  // What is done, of all.
  void show(std::size_t done, std::size_t all, std::string_view what = "runs");
  // A stage, and the share of all that is done where it is known.
  void show(std::string_view stage, std::optional<double> done);
  ProgressReport report();
  // Nothing is printed after this, until something is shown again.
  void end();

 private:
  void report(std::string what, std::optional<double> share);
  // Prints what is due again and again until `end`: work may be silent for minutes.
  void keep_up_to_date();
  double now_s() const;
  void print(const std::string& text);

  bool visible_, terminal_;
  std::chrono::steady_clock::time_point start_;
  std::mutex mutex_;  // of all below
  std::condition_variable ended_;
  ProgressLine line_;
  bool running_ = false, shown_ = false;
  std::thread timer_;  // joined by `end`
};

}  // namespace gustlab
