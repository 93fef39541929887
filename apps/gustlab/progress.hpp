// A line on stderr that says how far a sweep is, on a terminal only and not with --quiet.
#pragma once

#include <chrono>
#include <cstddef>

namespace gustlab {

class Progress {
 public:
  Progress();
  ~Progress() { end(); }
  // Runs that are done, of all.
  void show(std::size_t done, std::size_t all);
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  bool visible_;
  bool shown_ = false;
  std::size_t first_ = 0;  // done before this program began
  Clock::time_point start_, last_;
};

}  // namespace gustlab
