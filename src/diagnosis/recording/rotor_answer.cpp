#include "diagnosis/recording/rotor_answer.hpp"

#include "simulation/make_effects.hpp"

namespace gustlab::diagnosis {

namespace {

std::vector<EffectSpec> lags_of(const VehicleModel& vehicle) {
  std::vector<EffectSpec> lags = vehicle.effects;
  std::erase_if(lags, [](const EffectSpec& effect) { return find_effect(effect.type)->latency != Latency::lag; });
  return lags;
}

}  // namespace

RotorAnswer::RotorAnswer(const VehicleModel& vehicle) : forces_(vehicle, make_effects(lags_of(vehicle))) {
  forces_.prepare(0.001, 0, 0);
}

RotorArray RotorAnswer::after(double held_s, const RotorArray& speed_radps, const RotorArray& command_radps) const {
  Actuation step;
  step.step_s = held_s;
  step.command_radps = command_radps;
  step.start_speed_radps = speed_radps;
  forces_.actuate(step);
  return step.end_speed_radps;
}

}  // namespace gustlab::diagnosis
