#include "vehicle/new_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/text.hpp"
#include "gustlab/errors.hpp"
#include "vehicle/estimates.hpp"

namespace gustlab {

namespace {

// four digits: no estimate has more
std::string number(double value) { return fmt::format("{:.4g}", std::abs(value) < 1e-12 ? 0.0 : value); }

double arm_m(const NewVehicle& wanted) {
  double sum = 0.0;
  for (const Hub& hub : wanted.hubs) sum += hub.position_B_m.head<2>().norm();
  return sum / static_cast<double>(wanted.hubs.size());
}

constexpr double least_thrust_to_weight = 1.05, most_thrust_to_weight = 100.0, most_mass_kg = 1e4, least_arm_m = 1e-3,
                 most_arm_m = 100.0;
// Of propellers' tips in hover: 53 m/s (Crazyflie), 58 m/s (1.2 kg on 10 inches), 8 m/s (AeroVelo's Atlas, flown by a man on pedals).
constexpr double speed_of_sound_mps = 340.0, least_tip_speed_mps = 5.0;
constexpr std::array<double, 2> usual_tip_speed_mps = {20.0, 200.0};
// photographers' vehicles have 1.5 to 3, racers up to 14; less than 1.3 leaves nothing to steer with
constexpr std::array<double, 2> usual_thrust_to_weight = {1.3, 15.0};
// of a propeller's diameter over the distance between neighbouring hubs; 0.71 to 0.85 is usual (src/vehicle/estimates.hpp)
constexpr double least_usual_diameter = 0.3;

// the nearest two hubs of one height
double hub_distance_m(const NewVehicle& wanted) {
  double least = 1e300;
  for (const Hub& a : wanted.hubs)
    for (const Hub& b : wanted.hubs) {
      const double distance = (a.position_B_m - b.position_B_m).head<2>().norm();
      if (&a != &b && distance > 1e-6) least = std::min(least, distance);
    }
  return least;
}

double diameter_of(const NewVehicle& wanted) {
  return wanted.propeller_diameter_m ? wanted.propeller_diameter_m->value
                                     : diameter_per_hub_distance * hub_distance_m(wanted);
}

double curve_of(const NewVehicle& wanted) {
  return wanted.throttle_curve ? wanted.throttle_curve->value : usual_throttle_curve;
}

// thrust of all rotors at full throttle over the weight: from 1 = (f h² + (1 − f) h) full thrust / weight, where hover is given
double full_thrust_to_weight(const NewVehicle& wanted) {
  if (wanted.thrust_to_weight) return wanted.thrust_to_weight->value;
  const double f = curve_of(wanted), h = wanted.hover->value;
  return 1.0 / (f * h * h + (1.0 - f) * h);
}

// of a propeller's tips, when all carry this share of the weight together
double tip_speed_mps(const NewVehicle& wanted, double thrust_to_weight) {
  const double diameter = diameter_of(wanted), thrust_N = thrust_to_weight * wanted.mass_kg.value *
                                                          standard_gravity_mps2 /
                                                          static_cast<double>(wanted.hubs.size());
  return 0.5 * diameter * std::sqrt(thrust_N / estimated_thrust_coefficient_Ns2(diameter));
}

// "--mass, --prop: 0.001 kg on 4 propellers of 0.762 m"
std::string mass_on_propellers(const NewVehicle& wanted) {
  return wanted.propeller_diameter_m
             ? fmt::format("--mass, --prop: {} kg on {} propellers of {} m", number(wanted.mass_kg.value),
                           wanted.hubs.size(), number(diameter_of(wanted)))
             : fmt::format("--mass, --arm: {} kg on {} propellers of some {} m, which fit between the motors,",
                           number(wanted.mass_kg.value), wanted.hubs.size(), number(diameter_of(wanted)));
}

// A mass and propellers that no vehicle has together show in the speed of the tips.
void check_tips(const NewVehicle& wanted) {
  const double hover_mps = tip_speed_mps(wanted, 1.0);
  if (hover_mps > speed_of_sound_mps)
    throw ConfigError(
        fmt::format("{} do not hover: their tips would move at {} m/s, faster than sound; check both, "
                    "and their units",
                    mass_on_propellers(wanted), number(std::round(hover_mps))));
  if (hover_mps < least_tip_speed_mps)
    throw ConfigError(
        fmt::format("{} hover with tips at {:.2g} m/s; propellers of that size are heavier than the "
                    "whole vehicle; check both, and their units",
                    mass_on_propellers(wanted), hover_mps));
}

std::vector<std::string> unusual(const NewVehicle& wanted) {
  std::vector<std::string> warnings;
  const double hover_mps = tip_speed_mps(wanted, 1.0), full_mps = tip_speed_mps(wanted, full_thrust_to_weight(wanted));
  if (hover_mps < usual_tip_speed_mps.front() || hover_mps > usual_tip_speed_mps.back())
    warnings.push_back(fmt::format("{} hover with tips at {} m/s ({} to {} m/s are usual); check both, and their units",
                                   mass_on_propellers(wanted), number(std::round(hover_mps)),
                                   usual_tip_speed_mps.front(), usual_tip_speed_mps.back()));
  else if (full_mps > speed_of_sound_mps)
    warnings.push_back(
        fmt::format("{}: {} kg on propellers of {} m need tips at {} m/s for {} times the weight, faster "
                    "than sound; check both",
                    wanted.hover ? "--hover" : "--thrust-to-weight", number(wanted.mass_kg.value),
                    number(diameter_of(wanted)), number(std::round(full_mps)), number(full_thrust_to_weight(wanted))));
  const double ratio = full_thrust_to_weight(wanted), hubs_m = hub_distance_m(wanted);
  if (ratio < usual_thrust_to_weight.front() || ratio > usual_thrust_to_weight.back())
    warnings.push_back(fmt::format(
        "{} all rotors together push with {} times the weight ({} to {} are usual); check it",
        wanted.hover ? fmt::format("--hover: at {} in hover", number(wanted.hover->value)) : "--thrust-to-weight:",
        number(ratio), usual_thrust_to_weight.front(), usual_thrust_to_weight.back()));
  if (diameter_of(wanted) < least_usual_diameter * hubs_m)
    warnings.push_back(
        fmt::format("--prop, --arm: propellers of {} m are small for motors {} m apart ({} of it and more is usual); "
                    "check both, and their units",
                    number(diameter_of(wanted)), number(hubs_m), least_usual_diameter));
  return warnings;
}

void check_wanted_thrust(const NewVehicle& wanted) {
  if (wanted.hover && !(wanted.hover->value > 0.0 && wanted.hover->value < 1.0))
    throw ConfigError(
        fmt::format("--hover: {} is no hover throttle (it is between 0 and 1)", number(wanted.hover->value)));
  if (wanted.hover && wanted.thrust_to_weight)
    throw ConfigError("--hover and --thrust-to-weight are two answers to one question: keep one");
  if (!wanted.hover && !wanted.thrust_to_weight)
    throw ConfigError(
        "--thrust-to-weight or --hover is missing: without one of them nothing says how much the rotors push "
        "(all of them at full throttle over the weight; the throttle in hover, 0 to 1)");
  const double ratio = full_thrust_to_weight(wanted);
  const std::string given =
      wanted.hover ? fmt::format("--hover: {} is a thrust to weight of {}:", number(wanted.hover->value), number(ratio))
                   : "--thrust-to-weight:";
  if (ratio <= least_thrust_to_weight)
    throw ConfigError(
        fmt::format("{} a vehicle with {} does not fly (all rotors at full input carry that much of the weight)", given,
                    number(ratio)));
  if (ratio > most_thrust_to_weight)
    throw ConfigError(fmt::format("{} {} (no multirotor pushes with more than {} times its weight)", given,
                                  number(ratio), most_thrust_to_weight));
}

void check(const NewVehicle& wanted) {
  if (wanted.propeller_diameter_m && wanted.propeller_diameter_m->value > 1.02 * hub_distance_m(wanted))
    throw ConfigError(fmt::format(
        "--prop: propellers of {} m overlap (neighbouring hubs are {} m apart); check --prop and --arm, which is from "
        "the centre to a motor",
        number(wanted.propeller_diameter_m->value), number(hub_distance_m(wanted))));
  if (!(wanted.mass_kg.value < most_mass_kg))
    throw ConfigError(
        fmt::format("--mass: {} kg is no multirotor's (less than {} kg)", number(wanted.mass_kg.value), most_mass_kg));
  if (!(arm_m(wanted) > least_arm_m && arm_m(wanted) < most_arm_m))
    throw ConfigError(
        fmt::format("--arm: {} m is no multirotor's ({} to {} m from the centre to a motor); check its unit",
                    number(arm_m(wanted)), least_arm_m, most_arm_m));
  check_wanted_thrust(wanted);
  check_tips(wanted);
}

// from f h² + (1 − f) h = weight / full thrust
double hover_of(double thrust_to_weight, double curve) {
  const double share = 1.0 / thrust_to_weight;
  if (curve == 0.0) return share;
  return (curve - 1.0 + std::sqrt((1.0 - curve) * (1.0 - curve) + 4.0 * curve * share)) / (2.0 * curve);
}

std::string thrust_table(const NewVehicle& wanted) {
  const Sourced curve = wanted.throttle_curve.value_or(
      Sourced{usual_throttle_curve,
              fmt::format("estimated, usual motor controllers within {} (ArduPilot's default MOT_THST_EXPO)",
                          throttle_curve_spread)});
  const Sourced hover =
      wanted.hover ? *wanted.hover
                   : Sourced{hover_of(wanted.thrust_to_weight->value, curve.value),
                             fmt::format("from thrust to weight {} ({}) and throttle_curve",
                                         number(wanted.thrust_to_weight->value), wanted.thrust_to_weight->source)};
  std::string text =
      fmt::format("[thrust]\n# throttle (0..1) at which all rotors together carry the weight: {}\nhover = {}\n",
                  hover.source, number(hover.value));
  const Sourced diameter = wanted.propeller_diameter_m.value_or(Sourced{
      diameter_of(wanted), fmt::format("estimated, {} of the distance between neighbouring hubs, within {:.0f} %",
                                       diameter_per_hub_distance, 100.0 * diameter_spread)});
  const Sourced ratio = wanted.torque_ratio_m.value_or(
      Sourced{torque_ratio_per_diameter * diameter.value,
              fmt::format("estimated, {} propeller diameters, within {:.0f} % (Brandt, Selig, AIAA 2011-1255)",
                          torque_ratio_per_diameter, 100.0 * torque_ratio_spread)});
  text += fmt::format("# propeller radius, m: {}\nradius_m = {}\n", diameter.source, number(0.5 * diameter.value));
  text += fmt::format("# torque over thrust of a rotor, m: {}\ntorque_ratio = {}\n", ratio.source, number(ratio.value));
  text += fmt::format(
      "# where rotor speeds are logged, write this in place of hover; estimated from the propeller, C_T {} within "
      "{:.0f} %\n"
      "# (Brandt, Selig, AIAA 2011-1255), N/(rad/s)^2\n# coefficient = {}\n",
      propeller_ct, 100.0 * propeller_ct_spread, number(estimated_thrust_coefficient_Ns2(diameter.value)));
  return text + fmt::format("\n[actuator]\n# f of thrust ~ f u^2 + (1 - f) u: {}\nthrottle_curve = {}\n", curve.source,
                            number(curve.value));
}

std::string vehicle_toml(const NewVehicle& wanted) {
  std::string text = fmt::format(
      "# {}: written by `gustlab vehicle new`; every number says where it comes from.\n"
      "# Motor lag, drag and battery sag stand here once flights have told them: `gustlab vehicle fit LOG...`.\n"
      "format = \"gustlab-vehicle/1\"\nname = {}\nmjcf = {}\n\n# in the order of u1...u{}: {}\n",
      wanted.name, config::quoted(wanted.name), config::quoted(wanted.name + ".xml"), wanted.hubs.size(),
      wanted.hubs_source);
  for (std::size_t i = 0; i < wanted.hubs.size(); ++i)
    text += fmt::format("[[rotor]]\nsite = \"rotor{}\"\ndirection = \"{}\"\n", i + 1,
                        wanted.hubs[i].counter_clockwise ? "ccw" : "cw");
  return text + "\n" + thrust_table(wanted);
}

std::string mjcf(const NewVehicle& wanted) {
  const double mass = wanted.mass_kg.value, arm = arm_m(wanted), square = mass * arm * arm;
  const std::string rule = fmt::format(
      "estimated, {} and {} of mass times arm squared, within {:.0f} % (five vehicles: see src/vehicle/estimates.hpp)",
      tilt_inertia_factor, yaw_inertia_factor, 100.0 * inertia_spread);
  const auto inertia = wanted.inertia_kgm2.value_or(std::array<Sourced, 3>{Sourced{tilt_inertia_factor * square, rule},
                                                                           Sourced{tilt_inertia_factor * square, rule},
                                                                           Sourced{yaw_inertia_factor * square, rule}});
  std::string text = fmt::format(
      "<mujoco model=\"{0}\">\n  <!-- x forward, y left, z up; kg, m, kg m^2 -->\n  <compiler "
      "inertiafromgeom=\"false\"/>\n  <worldbody>\n"
      "    <light pos=\"0 0 5\" dir=\"0 0 -1\" directional=\"true\"/>\n    <geom name=\"floor\" type=\"plane\" "
      "size=\"5 5 0.1\" rgba=\"0.8 0.8 0.8 1\"/>\n"
      "    <body name=\"{0}\" pos=\"0 0 1\">\n      <freejoint/>\n      <!-- mass: {1}; inertia: {2}; centre of mass: "
      "assumed at the centre of the hubs -->\n"
      "      <inertial pos=\"0 0 0\" mass=\"{3}\" diaginertia=\"{4} {5} {6}\"/>\n"
      "      <!-- outline, assumed: what touches the ground -->\n      <geom type=\"box\" size=\"{7} {7} {8}\" "
      "group=\"3\" rgba=\"0.8 0.3 0.3 0.3\"/>\n",
      wanted.name, wanted.mass_kg.source, inertia[0].source, number(mass), number(inertia[0].value),
      number(inertia[1].value), number(inertia[2].value), number(0.7 * arm), number(0.15 * arm));
  const double radius = 0.5 * diameter_of(wanted);
  for (std::size_t i = 0; i < wanted.hubs.size(); ++i) {
    const Vector3& p = wanted.hubs[i].position_B_m;
    const std::string at = fmt::format("{} {} {}", number(p.x()), number(p.y()), number(p.z()));
    text += fmt::format(
        "      <site name=\"rotor{0}\" pos=\"{1}\"/>\n"
        "      <geom type=\"capsule\" size=\"{2}\" fromto=\"0 0 0 {1}\" contype=\"0\" conaffinity=\"0\" rgba=\"0.1 0.1 "
        "0.1 1\"/>\n"
        "      <geom type=\"cylinder\" size=\"{3} 0.002\" pos=\"{1}\" contype=\"0\" conaffinity=\"0\" rgba=\"0.2 0.2 "
        "0.2 0.5\"/>\n",
        i + 1, at, number(0.04 * arm), number(radius));
  }
  return text + "    </body>\n  </worldbody>\n</mujoco>\n";
}

}  // namespace

VehicleFiles new_vehicle_files(const NewVehicle& wanted) {
  check(wanted);
  return {vehicle_toml(wanted), mjcf(wanted), unusual(wanted)};
}

}  // namespace gustlab
