#include "vehicle/read_thrust.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "vehicle/estimates.hpp"

namespace gustlab {

namespace {

using config::Table;

// `hover` is in the actuator's unit: throttle up to 1, pwm from 8000 to 65535, rotor speed in rad/s between (a rotor that
// hovers at 8000 rad/s would be of a vehicle of some grams). No propeller carries at 20 rad/s, three turns a second.
constexpr double most_throttle = 1.0, least_speed_radps = 20.0, most_speed_radps = 8000.0;

std::optional<double> not_negative(Table& table, std::string_view key) {
  const auto value = table.number(key);
  if (value && !(*value >= 0.0)) table.fail(key, fmt::format("\"{}\" must not be negative", key), "", "");
  return value;
}

// propellers of which only the room that they have is known
double diameter_m(const VehicleModel& vehicle) {
  if (vehicle.rotor_radius_m > 0.0) return 2.0 * vehicle.rotor_radius_m;
  return diameter_per_hub_distance * 2.0 * vehicle.arm_m() * std::sin(pi / vehicle.rotor_count);
}

// f = c u² + (1 − c) u in units of the thrust at hover, u as a share of the full input; N
std::array<double, 3> thrust_curve(double curve, double hover, double full, double hover_thrust_N) {
  const double at_hover = curve * hover * hover + (1.0 - curve) * hover * full;
  return {0.0, hover_thrust_N * (1.0 - curve) * full / at_hover, hover_thrust_N * curve / at_hover};
}

// the input that hovers, in place of a thrust coefficient; returns that
double read_hover(Table& thrust, double curve, VehicleModel& vehicle) {
  const double hover = *positive(thrust, "hover");
  if (hover > full_pwm || (hover > most_throttle && hover < least_speed_radps))
    thrust.fail("hover", fmt::format("\"hover\" of {:g} is no actuator input", hover),
                fmt::format("throttle is 0 to 1, rotor speed {:g} to {:g} rad/s, pwm {:g} to {:g}", least_speed_radps,
                            most_speed_radps, most_speed_radps, full_pwm),
                "");
  const double thrust_N = vehicle.hover_thrust_N();
  if (hover > most_throttle && hover <= most_speed_radps) return thrust_N / (hover * hover);
  const bool throttle = hover <= most_throttle;
  const double full = throttle ? most_throttle : full_pwm;
  (throttle ? vehicle.actuator.throttle_thrust : vehicle.actuator.pwm_thrust) =
      thrust_curve(curve, hover, full, thrust_N);
  const auto& map = throttle ? *vehicle.actuator.throttle_thrust : *vehicle.actuator.pwm_thrust;
  // stands for what nothing tells: speeds are on this scale
  const double coefficient_Ns2 = estimated_thrust_coefficient_Ns2(diameter_m(vehicle));
  vehicle.rotor_speed_known = false;
  vehicle.max_speed_radps = std::sqrt((map[1] + map[2] * full) * full / coefficient_Ns2);
  return coefficient_Ns2;
}

// 1 when absent
double read_curve(Table& document, bool has_hover) {
  auto actuator = document.table("actuator");
  const auto curve = actuator ? actuator->number("throttle_curve") : std::nullopt;
  if (!curve) return 1.0;
  if (!has_hover)
    actuator->fail("throttle_curve", "there is no [thrust] hover",
                   "throttle_curve says how thrust rises from and to that", "");
  if (!(*curve >= 0.0 && *curve <= 1.0))
    actuator->fail("throttle_curve", "\"throttle_curve\" must be from 0 to 1", "", "");
  return *curve;
}

void read_map(Table& actuator, const std::string& input, std::optional<std::pair<double, double>>& line,
              std::optional<std::array<double, 3>>& thrust) {
  const std::string thrust_key = input + "_thrust";
  if (thrust && (actuator.has(input) || actuator.has(thrust_key)))
    actuator.fail(actuator.has(input) ? input : thrust_key,
                  fmt::format("both [thrust] hover and a map of {} are here", input),
                  "they are two answers to one question", "keep one");
  if (auto table = actuator.table(input)) {
    const double slope = table->need_number("slope");
    if (!(slope > 0.0)) table->fail("slope", "\"slope\" must be positive", "", "");
    line = {slope, table->need_number("offset")};
  }
  if (const auto c = actuator.numbers(thrust_key)) {
    if (c->size() != 3)
      actuator.fail(thrust_key, fmt::format("\"{}\" must have three numbers", thrust_key),
                    fmt::format("this has {}", c->size()),
                    fmt::format("write [c0, c1, c2] of f = c0 + c1 {0} + c2 {0}^2", input));
    thrust = {(*c)[0], (*c)[1], (*c)[2]};
  }
  if (line && thrust)
    actuator.fail(thrust_key, fmt::format("both \"{}\" and \"{}\" are here", input, thrust_key),
                  "they are two answers to one question", "keep one");
}

}  // namespace

std::optional<double> positive(Table& table, std::string_view key) {
  const auto value = table.number(key);
  if (value && !(*value > 0.0)) table.fail(key, fmt::format("\"{}\" must be positive", key), "", "");
  return value;
}

void check_thrust(Table& document, config::Problems& problems) {
  problems.collect([&] {
    auto thrust = document.table("thrust");
    if (!thrust) return;
    for (const std::string_view key : {"coefficient", "hover", "max_speed_radps", "nominal_voltage_V", "radius_m"})
      problems.collect([&] { positive(*thrust, key); });
    problems.collect([&] { not_negative(*thrust, "torque_ratio"); });
  });
  problems.collect([&] {
    auto actuator = document.table("actuator");
    if (!actuator) return;
    problems.collect([&] { actuator->number("throttle_curve"); });
    for (const std::string input : {"pwm", "throttle"}) {
      problems.collect([&] {
        if (auto line = actuator->table(input))
          for (const std::string_view key : {"slope", "offset"}) problems.collect([&] { line->number(key); });
      });
      problems.collect([&] { actuator->numbers(input + "_thrust"); });
    }
  });
}

void read_thrust(Table& document, const std::vector<std::optional<double>>& own_coefficient, VehicleModel& vehicle) {
  Table thrust = document.table("thrust").value_or(Table::parse("", document.path()));
  const double curve = read_curve(document, thrust.has("hover"));
  if (thrust.has("hover") && thrust.has("coefficient"))
    thrust.fail("hover", "both \"coefficient\" and \"hover\" are here", "they are two answers to one question",
                "keep one");

  vehicle.max_speed_radps = std::numeric_limits<double>::infinity();
  vehicle.rotor_radius_m = positive(thrust, "radius_m").value_or(0.0);
  const auto coefficient = positive(thrust, "coefficient");
  const double common = coefficient           ? *coefficient
                        : thrust.has("hover") ? read_hover(thrust, curve, vehicle)
                                              : *own_coefficient.front();
  if (const auto most = positive(thrust, "max_speed_radps")) vehicle.max_speed_radps = *most;
  vehicle.nominal_voltage_V = positive(thrust, "nominal_voltage_V").value_or(0.0);
  const auto torque_ratio_m = not_negative(thrust, "torque_ratio");
  vehicle.torque_ratio_known = torque_ratio_m.has_value();
  const double ratio_m = torque_ratio_m.value_or(torque_ratio_per_diameter * diameter_m(vehicle));
  for (std::size_t i = 0; i < own_coefficient.size(); ++i) {
    vehicle.rotors[i].thrust_coefficient_Ns2 = own_coefficient[i].value_or(common);
    vehicle.rotors[i].torque_ratio_m = ratio_m;
  }
  auto actuator = document.table("actuator");
  if (!actuator) return;
  read_map(*actuator, "pwm", vehicle.actuator.pwm_line, vehicle.actuator.pwm_thrust);
  read_map(*actuator, "throttle", vehicle.actuator.throttle_line, vehicle.actuator.throttle_thrust);
}

}  // namespace gustlab
