// Quickens rotors that follow slowly: the command goes past the wanted speed by as much as a model of their lag says is
// missing. Four times as fast at most, because the speed limit does not allow more.
#pragma once

#include "control/rotors.hpp"

namespace gustlab {

class RotorLead {
 public:
  RotorLead() = default;
  RotorLead(const VehicleModel& vehicle, double period_s);

  void reset(const RotorArray& speed_radps) { speed_radps_ = speed_radps; }
  RotorCommand update(RotorCommand wanted);
  // what is left of the nominal lag
  double lag_s() const { return lag_s_; }

 private:
  int count_ = 0;
  double max_speed_radps_ = 0.0;
  double factor_ = 1.0;   // command = model + factor (wanted − model)
  double follows_ = 1.0;  // share of the gap that the model closes in a period
  double lag_s_ = 0.0;
  RotorArray speed_radps_{};  // of the model
};

}  // namespace gustlab
