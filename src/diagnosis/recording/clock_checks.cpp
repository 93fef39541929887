#include "diagnosis/recording/clock_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "diagnosis/recording/vehicle_check.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double least_jump_s = 0.03;         // a motor lag, seen at other frequencies, varies less
constexpr double gyro_stretch_s = 2.5, command_stretch_s = 4.0;
constexpr double most_gyro_offset_s = 0.2;
constexpr double least_agreement = 0.8;
constexpr double attitude_rate_memory_s = 0.1;  // over which the error of a rate from smoothed attitudes is correlated
constexpr double least_jump_gain = 9.0;         // twice the log likelihood per stretch, three standard deviations each
constexpr double least_rate_variance = 0.05;  // (rad/s)², roll and pitch together: less turning has no time

struct Stretch {
  double from_s = 0.0, to_s = 0.0;
  std::optional<double> delay_s;
};

double jump_of(double sample_s) { return std::max(least_jump_s, 3.1 * sample_s); }

std::vector<Stretch> stretches_of(const FlightData& flight, double length_s,
                                  const std::function<std::optional<double>(std::size_t, std::size_t)>& delay) {
  std::vector<Stretch> result;
  for (std::size_t first = 0, last = 0; first < flight.samples.size(); first = last) {
    const double from_s = flight.samples[first].time_s;
    while (last < flight.samples.size() && flight.samples[last].time_s < from_s + length_s) ++last;
    result.push_back({from_s, flight.samples[last - 1].time_s, delay(first, last)});
  }
  return result;
}

// delays that were told; of many the outermost two may be errors
std::vector<double> told(const std::vector<Stretch>& stretches) {
  std::vector<double> sorted;
  for (const Stretch& s : stretches)
    if (s.delay_s) sorted.push_back(*s.delay_s);
  std::sort(sorted.begin(), sorted.end());
  if (sorted.size() >= 6) sorted = {sorted.begin() + 1, sorted.end() - 1};
  return sorted;
}

// neighbouring stretches of about the same delay are one
std::vector<Stretch> merged(const std::vector<Stretch>& stretches, double jump_s) {
  std::vector<Stretch> result;
  for (const Stretch& s : stretches) {
    if (!s.delay_s) continue;
    if (!result.empty() && std::abs(*result.back().delay_s - *s.delay_s) <= 0.5 * jump_s) result.back().to_s = s.to_s;
    else result.push_back(s);
  }
  return result;
}

FlightData part_of(const FlightData& flight, std::size_t first, std::size_t last) {
  FlightData part;
  part.commands = flight.commands;
  part.measured_speed = flight.measured_speed;
  part.sample_s = flight.sample_s;
  const auto at = [](std::size_t i) { return static_cast<std::ptrdiff_t>(i); };
  part.samples.assign(flight.samples.begin() + at(first), flight.samples.begin() + at(last));
  part.motion.assign(flight.motion.begin() + at(first), flight.motion.begin() + at(last));
  return part;
}

}  // namespace

std::vector<LogFinding> rate_delays(const FlightData& pose, const std::vector<Vector3>& rate_B_radps) {
  const double step_s = pose.sample_s;
  const auto most = static_cast<std::int64_t>(std::lround(most_gyro_offset_s / step_s));
  // cross-correlation of roll and pitch rates; of every stretch that tells, log likelihood over the lags
  std::vector<std::vector<double>> likelihood;
  const auto delay = [&](std::size_t first, std::size_t last) -> std::optional<double> {
    double best = -1.0, energy = 0.0;
    std::int64_t at = 0;
    std::vector<double> over_lags;
    const double independent = 2.0 * static_cast<double>(last - first) * step_s / attitude_rate_memory_s;
    for (std::int64_t lag = -most; lag <= most; ++lag) {
      double xy = 0.0, xx = 0.0, yy = 0.0;
      for (std::size_t k = first; k < last; ++k) {
        const auto j = static_cast<std::int64_t>(k) + lag;
        if (j < 0 || j >= static_cast<std::int64_t>(rate_B_radps.size())) continue;
        const Vector3& gyro = rate_B_radps[static_cast<std::size_t>(j)];
        if (!gyro.allFinite()) continue;
        const Vector3& rate = pose.motion[k].body_rate_B_radps;
        xy += gyro.head<2>().dot(rate.head<2>());
        xx += gyro.head<2>().squaredNorm();
        yy += rate.head<2>().squaredNorm();
      }
      const double r = xy / std::sqrt(xx * yy + 1e-300);
      over_lags.push_back(-0.5 * independent * std::log(1.0 - std::min(r * std::abs(r), 0.9999)));
      if (r > best) best = r, at = lag, energy = yy / static_cast<double>(last - first);
    }
    if (best < least_agreement || energy < least_rate_variance) return std::nullopt;
    likelihood.push_back(std::move(over_lags));
    return static_cast<double>(at) * step_s;
  };
  const std::vector<Stretch> stretches = stretches_of(pose, gyro_stretch_s, delay);
  const std::vector<double> delays = told(stretches);
  if (delays.size() < 2 || delays.back() - delays.front() <= jump_of(step_s)) return {};
  // slow turning has a flat top: what one delay for the whole flight explains as well is no jump
  double each = 0.0, one = -std::numeric_limits<double>::infinity();
  for (const auto& stretch : likelihood) each += *std::max_element(stretch.begin(), stretch.end());
  for (std::size_t lag = 0; lag < likelihood.front().size(); ++lag) {
    double sum = 0.0;
    for (const auto& stretch : likelihood) sum += stretch[lag];
    one = std::max(one, sum);
  }
  if (2.0 * (each - one) < least_jump_gain * static_cast<double>(likelihood.size())) return {};
  std::vector<LogFinding> findings;
  for (const Stretch& s : merged(stretches, jump_of(step_s)))
    findings.push_back({pose.label, "wx…az", "delay", s.from_s, s.to_s,
                        fmt::format("the gyro is {:.0f} ms later than the attitude here, and {:.0f} to {:.0f} ms in the flight: inertial "
                                    "data and pose are on two clocks, and the inertial data are not used",
                                    1e3 * *s.delay_s, 1e3 * delays.front(), 1e3 * delays.back()),
                        false, true});
  return findings;
}

namespace {

struct CommandClock {
  bool steady = false;               // the delay is told in half of the flight or more, and stays the same
  std::vector<LogFinding> findings;  // one per stretch when it jumps
};

CommandClock clock_of_commands(const FlightData& flight, const VehicleModel& vehicle) {
  CommandClock clock;
  const std::vector<Stretch> stretches = stretches_of(flight, command_stretch_s, [&](std::size_t first, std::size_t last) {
    return flight.collective_only ? std::nullopt : torque_delay_s(part_of(flight, first, last), vehicle);
  });
  const std::vector<double> delays = told(stretches);
  const double jump_s = jump_of(flight.sample_s);
  const bool jumps = delays.size() >= 3 && delays.back() - delays.front() > jump_s;
  clock.steady = !jumps && 2 * delays.size() >= stretches.size();
  if (jumps)
    for (const Stretch& s : merged(stretches, jump_s))
      clock.findings.push_back({flight.label, "u1…uN", "delay", s.from_s, s.to_s,
                                fmt::format("here the vehicle turns {:.0f} ms after its rotors are told to, and {:.0f} to {:.0f} ms in the "
                                            "flight: two clocks, and torques are not judged",
                                            1e3 * *s.delay_s, 1e3 * delays.front(), 1e3 * delays.back()),
                                false, false});
  return clock;
}

}  // namespace

bool clocks_apart(const std::vector<FlightData>& flights, const VehicleModel& vehicle, std::vector<LogFinding>& findings) {
  bool apart = false;
  for (const FlightData& flight : flights) {
    const bool gyro_jumps = std::any_of(findings.begin(), findings.end(),
                                        [&](const LogFinding& f) { return f.kind == "delay" && f.file == flight.label; });
    if (!gyro_jumps) continue;
    const CommandClock clock = clock_of_commands(flight, vehicle);
    findings.insert(findings.end(), clock.findings.begin(), clock.findings.end());
    apart = apart || !clock.steady;
  }
  return apart;
}

FlightLog with_total_thrust(FlightLog log, const VehicleModel& vehicle) {
  std::vector<std::vector<double>*> input;
  for (LogColumn& column : log.columns) {
    if (column.name == "rotor1") return log;
    for (int i = 1; i <= vehicle.rotor_count; ++i)
      if (column.name == fmt::format("u{}", i)) input.push_back(&column.values);
  }
  if (input.size() != static_cast<std::size_t>(vehicle.rotor_count) || log.meta.actuator == ActuatorKind::collective_thrust) return log;
  std::vector<double> total(log.rows());
  for (std::size_t i = 0; i < input.size(); ++i)
    for (std::size_t k = 0; k < log.rows(); ++k) {
      const Rotor& rotor = vehicle.rotors[i];
      total[k] += rotor.thrust_coefficient_Ns2 * std::pow(rotor_speed_radps(vehicle, rotor, log.meta.actuator, (*input[i])[k]), 2);
    }
  *input.front() = std::move(total);
  log.meta.actuator = ActuatorKind::collective_thrust;
  std::erase_if(log.columns, [](const LogColumn& column) { return column.name.size() == 2 && column.name[0] == 'u' && column.name[1] != '1'; });
  return log;
}

}  // namespace gustlab::diagnosis
