// A line on stderr that says how far long work is and how long it still takes, on a terminal only and not with --quiet.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "util/progress.hpp"

namespace gustlab {

class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  // Runs that are done, of all.
  void show(std::size_t done, std::size_t all);
  // A stage and the share of all that is done.
  void show(std::string_view stage, double done);
  ProgressReport report();
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  // ", 12 s left"; empty while nothing tells
  std::string left(double done) const;
  void print(const std::string& text);

  bool visible_;
  bool shown_ = false;
  double first_ = 0.0;  // share that was done before this program began
  Clock::time_point start_, last_;
};

}  // namespace gustlab
