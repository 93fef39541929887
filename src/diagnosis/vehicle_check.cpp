#include "diagnosis/vehicle_check.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace gustlab::diagnosis {

namespace {

using Row = Eigen::RowVectorXd;

// how strongly each rotor's thrust turns the vehicle about each axis, from the data: ω̇ regressed on Ω², slow parts removed
Eigen::MatrixXd measured_gains(const std::vector<FlightData>& flights, const VehicleModel& vehicle) {
  const int rotors = vehicle.rotor_count;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(rotors, rotors);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(rotors, 3);
  const double hover = vehicle.hover_speed_radps();
  for (const FlightData& flight : flights) {
    if (flight.collective_only) continue;
    const CommandRecord& record = flight.measured_speed.empty() ? flight.commands : flight.measured_speed;
    const auto lag = static_cast<std::size_t>(std::max(1.0, std::round(0.5 / flight.sample_s)));
    const auto at = [&](std::size_t k) {
      Row speed(rotors);
      // the rotors answer some 30 ms late; what counts here is only who turns what
      const double t = flight.samples[k].time_s - 0.03;
      const RotorArray mean = record.mean(t - 2.0 * flight.sample_s, t + 2.0 * flight.sample_s);
      for (int i = 0; i < rotors; ++i) speed[i] = std::pow(mean[static_cast<std::size_t>(i)] / hover, 2);
      return speed;
    };
    for (std::size_t k = lag; k + 1 < flight.samples.size(); ++k) {
      const std::size_t old = k - lag;
      const Row x = at(k) - at(old);
      const Vector3 y = flight.motion[k].angular_acceleration_B_radps2 - flight.motion[old].angular_acceleration_B_radps2;
      if (!x.allFinite() || !y.allFinite()) continue;
      gram += x.transpose() * x;
      right += x.transpose() * y.transpose();
    }
  }
  gram.diagonal().array() += 1e-6 * gram.trace() / rotors + 1e-12;
  return gram.ldlt().solve(right).transpose();
}

// the same from the vehicle file, rotor i standing where `place[i]` stands
Eigen::MatrixXd nominal_gains(const VehicleModel& vehicle, const std::vector<int>& place) {
  Eigen::MatrixXd gains(3, vehicle.rotor_count);
  for (int i = 0; i < vehicle.rotor_count; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(place[static_cast<std::size_t>(i)])];
    const Vector3 hub = rotor.position_B_m - vehicle.center_of_mass_B_m;
    gains.col(i) = hub.cross(rotor.axis_B) - rotor.direction * rotor.torque_ratio_m * rotor.axis_B;
  }
  return gains;
}

double similarity(const Row& a, const Row& b) {
  const Row x = a.array() - a.mean(), y = b.array() - b.mean();
  return x.dot(y) / std::sqrt(x.squaredNorm() * y.squaredNorm() + 1e-300);
}

std::string order_text(const std::vector<int>& place) {
  std::string text;
  for (const int p : place) text += fmt::format("{}{}", text.empty() ? "" : ", ", p + 1);
  return text;
}

}  // namespace

std::vector<LogFinding> check_rotors(const std::vector<FlightData>& flights, VehicleModel& vehicle) {
  std::vector<LogFinding> findings;
  const bool turns = std::any_of(flights.begin(), flights.end(), [](const FlightData& flight) {
    return !flight.collective_only && std::any_of(flight.samples.begin(), flight.samples.end(), [](const Sample& s) {
      return (s.channels & (has_rate | has_attitude)) != 0;
    });
  });
  if (!turns || vehicle.rotor_count > 6) return findings;
  const Eigen::MatrixXd measured = measured_gains(flights, vehicle);
  std::vector<int> place(static_cast<std::size_t>(vehicle.rotor_count));
  std::iota(place.begin(), place.end(), 0);
  const auto level = [&](const std::vector<int>& p) {
    const Eigen::MatrixXd g = nominal_gains(vehicle, p);
    return similarity(measured.row(0), g.row(0)) + similarity(measured.row(1), g.row(1));
  };
  const auto whole = [&](const std::vector<int>& p) {
    return level(p) + 0.5 * std::abs(similarity(measured.row(2), nominal_gains(vehicle, p).row(2)));
  };
  const std::string file = vehicle.source_path.substr(vehicle.source_path.find_last_of('/') + 1);
  const double stated = level(place);
  if (stated < 1.0) {
    std::vector<int> best = place, trial = place;
    do {
      if (whole(trial) > whole(best)) best = trial;
    } while (std::next_permutation(trial.begin(), trial.end()));
    if (level(best) > 1.6 && level(best) > stated + 0.8) {
      LogFinding finding;
      finding.file = file;
      finding.column = "rotor";
      finding.kind = "inconsistent";
      finding.says = fmt::format(
          "the rotor order of the vehicle file contradicts roll and pitch (agreement {:.2f} of 2); u1…u{} drive the rotors "
          "that the file lists as {} (agreement {:.2f}): the diagnosis goes on with that order",
          stated, vehicle.rotor_count, order_text(best), level(best));
      findings.push_back(finding);
      const auto rotors = vehicle.rotors;
      for (std::size_t i = 0; i < best.size(); ++i) vehicle.rotors[i] = rotors[static_cast<std::size_t>(best[i])];
    }
  }
  if (level(place) > 1.0 && vehicle.rotors[0].torque_ratio_m > 0.0) {
    const double yaw = similarity(measured.row(2), nominal_gains(vehicle, place).row(2));
    if (yaw < -0.6) {
      LogFinding finding;
      finding.file = file;
      finding.column = "rotor.direction";
      finding.kind = "sign";
      finding.says = fmt::format(
          "the vehicle yaws against the torque of the vehicle file (agreement {:.2f}): every rotor turns the other way "
          "round than the file says, and the diagnosis goes on with that",
          yaw);
      findings.push_back(finding);
      for (int i = 0; i < vehicle.rotor_count; ++i) vehicle.rotors[static_cast<std::size_t>(i)].direction *= -1.0;
    }
  }
  return findings;
}

}  // namespace gustlab::diagnosis
