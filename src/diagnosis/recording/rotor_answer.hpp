// How the rotors of a vehicle file answer a command that is held: by its lag alone.
#pragma once

#include "plant/force_model.hpp"

namespace gustlab::diagnosis {

class RotorAnswer final {
 public:
  explicit RotorAnswer(const VehicleModel& vehicle);
  // Speeds, rad/s, of rotors that had these a while before.
  RotorArray after(double held_s, const RotorArray& speed_radps, const RotorArray& command_radps) const;

 private:
  ForceModel forces_;
};

}  // namespace gustlab::diagnosis
