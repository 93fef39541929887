#include "metrics/effort.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gustlab {

void Effort::add(double time_s, std::span<const double> speed_radps) {
  if (time_s < settle_s_) return;
  rotors_ = speed_radps.size();
  if (samples_ == 0) {
    std::copy(speed_radps.begin(), speed_radps.end(), first_.begin());
    before_ = first_;
  }
  ++samples_;
  for (std::size_t i = 0; i < rotors_; ++i) {
    const double beyond = speed_radps[i] - first_[i], change = speed_radps[i] - before_[i];
    sum_[i] += beyond;
    squares_[i] += beyond * beyond;
    changes_ += change * change;
    before_[i] = speed_radps[i];
  }
}

EffortFigures Effort::figures() const {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (samples_ < 2) return {nan, nan};
  const auto n = static_cast<double>(samples_), rotors = static_cast<double>(rotors_);
  double variance = 0.0;
  for (std::size_t i = 0; i < rotors_; ++i)
    variance += std::max(0.0, squares_[i] / n - sum_[i] * sum_[i] / (n * n)) / rotors;
  return {std::sqrt(variance), std::sqrt(changes_ / (rotors * (n - 1.0))) / interval_s_};
}

}  // namespace gustlab
