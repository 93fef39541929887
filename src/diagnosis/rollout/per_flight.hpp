// Values that a model has per flight (wind, a constant force), from the samples of the flight so far (DIAGNOSIS.md §3.8).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/rollout/rollout.hpp"

namespace gustlab::diagnosis {

// Half-second rollouts one after the other; each says with its velocity (without one: its position) how far the values
// are off. Extended Kalman filter of constant values: every rollout is linearised about what those before it say, the
// model's own values are known to within a parameter's natural size, and the noise is what the rollouts leave, at least
// the sensors'. Nothing that comes after a window's start is used for it. Not wanted: the model's own values stay.
class PerFlightFit {
 public:
  PerFlightFit(const Recording& recording, const std::vector<EffectSpec>& effects,
               const std::vector<RotorArray>& rotor_speeds, bool wanted, int jobs);

  // Number of rollouts that end at a row or before it.
  std::size_t known_by(std::size_t row) const;
  // The effects with what that many rollouts say.
  std::vector<EffectSpec> effects(std::size_t rollouts) const;

 private:
  struct Parameter {
    std::size_t effect, value;  // indices into the specs
    double start, step;
  };
  void find_parameters(const VehicleModel& vehicle);
  std::vector<EffectSpec> with(const Eigen::VectorXd& change) const;

  std::vector<EffectSpec> specs_;
  std::vector<Parameter> parameters_;
  std::vector<std::size_t> end_row_;
  std::vector<Eigen::VectorXd> change_;  // [rollouts so far], in steps
};

}  // namespace gustlab::diagnosis
