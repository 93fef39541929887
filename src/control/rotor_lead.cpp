#include "control/rotor_lead.hpp"

#include <algorithm>
#include <cmath>

namespace gustlab {

RotorLead::RotorLead(const VehicleModel& vehicle, double period_s)
    : count_(vehicle.rotor_count), max_speed_radps_(vehicle.max_speed_radps) {
  const double lag_s = nominal_motor_lag_s(vehicle);
  factor_ = std::clamp(lag_s / 0.02, 1.0, 4.0);
  lag_s_ = lag_s / factor_;
  if (lag_s > 0.0) follows_ = 1.0 - std::exp(-period_s / lag_s);
}

RotorCommand RotorLead::update(RotorCommand wanted) {
  if (factor_ == 1.0) return wanted;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    double& speed = wanted.speed_radps[i];
    speed = std::clamp(speed_radps_[i] + factor_ * (speed - speed_radps_[i]), 0.0, max_speed_radps_);
    speed_radps_[i] += follows_ * (speed - speed_radps_[i]);
  }
  return wanted;
}

}  // namespace gustlab
