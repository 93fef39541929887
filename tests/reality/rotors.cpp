#include "rotors.hpp"

#include <algorithm>
#include <cmath>

namespace reality {

RotorChain::RotorChain(const Truth& truth, const PerRotor& start_radps)
    : up_s_(truth.lag_up_s),
      down_s_(truth.lag_down_s),
      delay_s_(truth.delay_s),
      max_radps_(truth.max_speed_radps),
      stick_radps_(truth.outside.esc_stick_radps),
      now_s_(-1e9),
      speed_(start_radps),
      target_(start_radps) {}

void RotorChain::relax(double until_s) {
  const double span_s = until_s - now_s_;
  for (int i = 0; i < kRotors; ++i) {
    const double lag_s = target_[i] > speed_[i] ? up_s_ : down_s_;
    speed_[i] = target_[i] + (speed_[i] - target_[i]) * (lag_s > 1e-6 ? std::exp(-span_s / lag_s) : 0.0);
  }
  now_s_ = until_s;
}

void RotorChain::take(const PerRotor& command_radps) {
  for (int i = 0; i < kRotors; ++i) {
    const double wanted = std::clamp(command_radps[i], 0.0, max_radps_);
    if (std::abs(wanted - target_[i]) >= stick_radps_) target_[i] = wanted;
  }
}

const PerRotor& RotorChain::at(double time_s, const CommandTape& tape) {
  while (next_ < tape.time_s.size() && tape.time_s[next_] + delay_s_ <= time_s + 1e-10) {
    const double change_s = tape.time_s[next_] + delay_s_;
    if (change_s > now_s_) relax(change_s);
    take(tape.speed_radps[next_++]);
  }
  if (time_s > now_s_) relax(time_s);
  return speed_;
}

}  // namespace reality
