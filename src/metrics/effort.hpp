// What a controller asks of the rotors: how far their speeds swing about their own means, and how fast they change.
#pragma once

#include <span>

#include "gustlab/types.hpp"

namespace gustlab {

// Root mean squares over rotors and samples; NaN when fewer than two samples counted.
struct EffortFigures {
  double speed_sd_radps;       // about each rotor's mean of the run
  double acceleration_radps2;  // between samples
};

class Effort {
 public:
  // Samples before settle_s do not count. interval_s: between two samples.
  Effort(double settle_s, double interval_s) : settle_s_(settle_s), interval_s_(interval_s) {}

  void add(double time_s, std::span<const double> speed_radps);
  EffortFigures figures() const;

 private:
  double settle_s_, interval_s_;
  std::size_t samples_ = 0, rotors_ = 0;
  RotorArray first_{}, before_{}, sum_{}, squares_{};  // sums of what is beyond the first sample
  double changes_ = 0.0;
};

}  // namespace gustlab
