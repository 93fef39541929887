#include "diagnosis/recording/attitude_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/recording/flight_labels.hpp"
#include "gustlab/types.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

namespace {

using Vector2 = Eigen::Vector2d;

constexpr double usual_gravity_mps2 = 9.81;
constexpr double window_s = 0.4;
constexpr std::size_t least_windows = 20;
constexpr double least_acceleration_mps2 = 0.05;  // rms: less is drift and noise
constexpr double too_much = 0.4;                  // share of the acceleration that is left over
constexpr double clearly_better = 0.25;

struct Reading {
  const char* columns;
  const char* says;
  bool scalar_last = false, world_to_body = false, mirrored = false;
};
constexpr Reading readings[] = {
    {"", ""},
    {"qw…qz", "the quaternion were scalar-last", true, false},
    {"qw…qz", "the quaternion were world-to-body", false, true},
    {"qw…qz", "the quaternion were scalar-last and world-to-body", true, true},
    {"px…vz", "y and z of its path had the other sign, as north-east-down has it", false, false, true}};

// columns that are all there; else none
std::vector<const std::vector<double>*> columns_of(const FlightLog& log, std::initializer_list<const char*> names) {
  std::vector<const std::vector<double>*> result;
  for (const char* name : names) {
    result.push_back(log.find(name));
    if (!result.back()) return {};
  }
  return result;
}

// The columns that drive the rotors; none where they have no map to thrust.
ActuatorKind inputs_of(const FlightLog& log, const VehicleModel& vehicle,
                       std::vector<const std::vector<double>*>& inputs) {
  for (const auto& [prefix, kind] : {std::pair{"rotor", ActuatorKind::rotor_speed}, {"u", log.meta.actuator}}) {
    inputs.clear();
    const int wanted = kind == ActuatorKind::collective_thrust ? 1 : vehicle.rotor_count;
    for (int i = 1; i <= wanted; ++i)
      if (const auto* column = log.find(fmt::format("{}{}", prefix, i))) inputs.push_back(column);
    if (static_cast<int>(inputs.size()) == wanted && kind != ActuatorKind::throttle) return kind;
  }
  inputs.clear();
  return log.meta.actuator;
}

// Thrust per mass that a row's inputs ask for; NaN where it has none, gravity where no input says.
double thrust_mps2(const VehicleModel& vehicle, const std::vector<const std::vector<double>*>& inputs,
                   ActuatorKind kind, std::size_t row) {
  if (inputs.empty()) return usual_gravity_mps2;
  return thrust_N(vehicle,
                  speeds_radps(vehicle, kind,
                               [&](std::size_t i) { return (*inputs[std::min(i, inputs.size() - 1)])[row]; })) /
         vehicle.mass_kg;
}

// horizontal part of the body's z axis in W, as the path has its axes
Vector2 lean(const double (&c)[4], const Reading& reading) {
  const Quaternion q = reading.scalar_last ? Quaternion(c[3], c[0], c[1], c[2]) : Quaternion(c[0], c[1], c[2], c[3]);
  Vector2 lean = ((reading.world_to_body ? q.conjugate() : q) * Vector3::UnitZ()).head<2>();
  if (reading.mirrored) lean.y() = -lean.y();
  return lean;
}

}  // namespace

std::vector<LogFinding> check_attitude(const FlightLog& log, const VehicleModel& vehicle) {
  const auto q = columns_of(log, {"qw", "qx", "qy", "qz"}), v = columns_of(log, {"vx", "vy"});
  if (q.empty() || v.empty()) return {};
  // per window: mean acceleration, and the mean thrust of each reading
  std::vector<Vector2> acceleration;
  std::vector<Vector2> leaning[std::size(readings)];
  std::vector<const std::vector<double>*> inputs;
  const ActuatorKind kind = inputs_of(log, vehicle, inputs);
  double thrust = usual_gravity_mps2;
  for (std::size_t first = 0, last = 0; first < log.rows(); first = last) {
    Vector2 sum[std::size(readings)];
    std::ranges::fill(sum, Vector2::Zero());
    std::size_t from = log.rows(), to = log.rows();
    double count = 0.0;
    for (last = first; last < log.rows() && log.time_s[last] - log.time_s[first] < window_s; ++last) {
      if (std::isfinite((*v[0])[last]) && std::isfinite((*v[1])[last]))
        from = from == log.rows() ? last : from, to = last;
      if (const double now = thrust_mps2(vehicle, inputs, kind, last); std::isfinite(now)) thrust = now;
      const double c[4] = {(*q[0])[last], (*q[1])[last], (*q[2])[last], (*q[3])[last]};
      if (!std::isfinite(c[0] + c[1] + c[2] + c[3])) continue;
      for (std::size_t r = 0; r < std::size(readings); ++r) sum[r] += thrust * lean(c, readings[r]);
      count += 1.0;
    }
    if (count == 0.0 || from == to || log.time_s[to] - log.time_s[from] < 0.5 * window_s) continue;
    acceleration.emplace_back(Vector2((*v[0])[to] - (*v[0])[from], (*v[1])[to] - (*v[1])[from]) /
                              (log.time_s[to] - log.time_s[from]));
    for (std::size_t r = 0; r < std::size(readings); ++r) leaning[r].emplace_back(sum[r] / count);
  }
  if (acceleration.size() < least_windows) return {};

  // mean square about the mean: a steady wind or a trim does not count
  const auto mean_square = [&](const auto& value) {
    Vector2 mean = Vector2::Zero();
    double square = 0.0;
    const double count = static_cast<double>(acceleration.size());
    for (std::size_t k = 0; k < acceleration.size(); ++k) mean += value(k) / count;
    for (std::size_t k = 0; k < acceleration.size(); ++k) square += (value(k) - mean).squaredNorm() / count;
    return square;
  };
  const double all = mean_square([&](std::size_t k) { return acceleration[k]; });
  if (all < least_acceleration_mps2 * least_acceleration_mps2) return {};
  const auto left = [&](std::size_t r) {
    return mean_square([&, r](std::size_t k) -> Vector2 { return acceleration[k] - leaning[r][k]; }) / all;
  };
  const double as_read = left(0);
  std::size_t best = 0;
  for (std::size_t r = 1; r < std::size(readings); ++r)
    if (left(r) < (best == 0 ? clearly_better * std::min(1.0, as_read) : left(best))) best = r;
  if (as_read < too_much || best == 0) return {};
  const std::string file = label_of(log.path);
  return {{file, readings[best].columns, "inconsistent", log.time_s.front(), log.time_s.back(),
           fmt::format("the vehicle does not accelerate as its attitude leans, and would if {}: set aside",
                       readings[best].says),
           true, false}};
}

}  // namespace gustlab::diagnosis
