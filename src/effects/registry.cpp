#include "effects/effects.hpp"

namespace gustlab {

std::string_view to_string(Place place) {
  switch (place) {
    case Place::body: return "body";
    case Place::actuation: return "actuation";
    case Place::rotor: return "rotor";
    case Place::wrench: return "wrench";
    case Place::measurement: return "measurement";
  }
  return "?";
}

namespace {

// order of application. actuation: 0 delay, 10 saturation, 20 sag, 30 lag. rotor: 20 scale and loss, 40 inflow and lift,
// 60 ground and ceiling, 65 reaction torque alone, 80 tilt. wrench: 0 wind (changes the flow), 10 all others.
constexpr EffectRow rows[] = {
    {.name = "rotor_drag", .place = Place::wrench, .order = 10, .per_flight = false, .diagnosable = true, .external = false,
     .says = "lateral force against the motion, proportional to rotor speed",
     .shows_in = "sustained 0.5-3 m/s in two directions",
     .confused_with = "quadratic_drag: speed sweep; steady_wind: reverse travel; attitude_offset: yaw",
     .source = "Faessler et al., RA-L 3(2) 2018", .make = make_rotor_drag},
    {.name = "mass", .place = Place::body, .order = 0, .per_flight = false, .diagnosable = true, .external = false,
     .says = "the vehicle weighs more (or less) than its model",
     .shows_in = "vertical and torque excitation",
     .confused_with = "thrust_scale, constant_force: aggressive attitude",
     .source = "Newton", .make = make_mass},
    {.name = "motor_lag", .place = Place::actuation, .order = 30, .per_flight = false, .diagnosable = true, .external = false,
     .says = "rotor speed follows its command late, as a first-order lag",
     .shows_in = "torque above 2 Hz",
     .confused_with = "actuation_delay, inertia: above 5 Hz",
     .source = "Forster, ETH 2015 (Crazyflie identification)", .make = make_motor_lag},
};

}  // namespace

std::span<const EffectRow> effect_registry() { return rows; }

const EffectRow* find_effect(std::string_view name) {
  for (const EffectRow& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace gustlab
