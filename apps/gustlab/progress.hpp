// A line on stderr that says how far long work is and how long it still takes: rewritten on a terminal, a new one every half a minute
// elsewhere (a log of a cluster), none with --quiet.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "util/progress.hpp"
#include "util/time_left.hpp"

namespace gustlab {

class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  // What is done, of all.
  void show(std::size_t done, std::size_t all, std::string_view what = "runs");
  // A stage and the share of all that is done.
  void show(std::string_view stage, double done);
  ProgressReport report();
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  // Takes the first report for the state at the start.
  void begin(double done);
  // ", 12 s left"; empty while nothing tells
  std::string left(double done) const;
  // Whether it is time for a line; counts the line as printed.
  bool due(bool last_one);
  void print(const std::string& text) const;

  bool visible_, terminal_;
  bool shown_ = false;
  std::optional<TimeLeft> time_left_;  // from the first report on
  Clock::time_point start_, last_;
};

}  // namespace gustlab
