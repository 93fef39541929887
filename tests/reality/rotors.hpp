// from held commands to rotor speeds, event by event
#pragma once

#include <vector>

#include "truth.hpp"

namespace reality {

/// Commands as they leave the autopilot: each is held from its time on. Times ascend [s], speeds in rad/s.
struct CommandTape {
  std::vector<double> time_s;
  std::vector<PerRotor> speed_radps;
};

/// Rotor speeds under a tape of commands. Between two changes of the (delayed) command a first-order lag has a closed
/// solution, so the chain jumps from change to change and is exact at any step.
class RotorChain {
 public:
  RotorChain(const Truth& truth, const PerRotor& start_radps);
  /// speeds at `time_s`, which may not go back [rad/s]
  const PerRotor& at(double time_s, const CommandTape& tape);

 private:
  void relax(double until_s);
  void take(const PerRotor& command_radps);
  double up_s_, down_s_, delay_s_, max_radps_, stick_radps_;
  double now_s_;
  std::size_t next_ = 0;
  PerRotor speed_, target_;
};

}  // namespace reality
