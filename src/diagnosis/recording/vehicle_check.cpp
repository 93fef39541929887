#include "diagnosis/recording/vehicle_check.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gustlab::diagnosis {

namespace {

using Row = Eigen::RowVectorXd;

// what is slower than this is trim, drag or flapping, and does not count here
constexpr double difference_s = 0.06;
// angular acceleration is a local fit over this long; rotor speeds are averaged alike
constexpr double average_s = 0.09;

// how the vehicle turned after its rotors' speeds changed, what they all did alike left out
struct Response {
  Eigen::MatrixXd gram, right;     // rotors × rotors of (Ω/Ω_h)², rotors × 3 with ω̇
  Vector3 norm = Vector3::Zero();  // of the part of each ω̇ that the speeds explain, rad/s²
  double explained = 0.0;          // share of the variance of roll and pitch acceleration
  double yaw_explained = 0.0;      // share of the variance of yaw acceleration

  // correlation of what these gains (rad/s² per (Ω/Ω_h)²) predict with what the speeds can explain at all, -1…1: rotors
  // that never moved apart (a mixer of six has four dimensions) count for nothing
  [[nodiscard]] double agreement(int axis, const Row& gains) const {
    return gains.dot(right.col(axis)) / (std::sqrt((gains * gram).dot(gains)) * norm[axis] + 1e-300);
  }
};

// ω̇ against Ω² some time before
Response measured_response(const std::vector<FlightData>& flights, const VehicleModel& vehicle, double delay_s) {
  const int rotors = vehicle.rotor_count;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(rotors, rotors), right = Eigen::MatrixXd::Zero(rotors, 3);
  Vector3 total = Vector3::Zero();
  const double hover = vehicle.hover_speed_radps();
  for (const FlightData& flight : flights) {
    if (flight.collective_only) continue;
    const CommandRecord& record = flight.rotor_record();
    const auto back = static_cast<std::size_t>(std::max(1.0, std::round(difference_s / flight.sample_s)));
    const auto at = [&](std::size_t k) {
      Row speed(rotors);
      const double t = flight.samples[k].time_s - delay_s;
      const RotorArray mean = record.mean(t - 0.5 * average_s, t + 0.5 * average_s);
      for (int i = 0; i < rotors; ++i) speed[i] = std::pow(mean[static_cast<std::size_t>(i)] / hover, 2);
      return speed;
    };
    for (std::size_t k = 2 * back; k + back < flight.samples.size(); ++k) {
      const Row x = at(k) - at(k - back);
      const Vector3 y =
          flight.motion[k].angular_acceleration_B_radps2 - flight.motion[k - back].angular_acceleration_B_radps2;
      if (!x.allFinite() || !y.allFinite()) continue;
      gram += x.transpose() * x;
      right += x.transpose() * y.transpose();
      total += y.cwiseAbs2();
    }
  }
  const Eigen::VectorXd alike = gram.rowwise().sum();
  right -= alike * right.colwise().sum() / (alike.sum() + 1e-300);
  gram -= alike * alike.transpose() / (alike.sum() + 1e-300);
  Eigen::MatrixXd ridged = gram;
  ridged.diagonal().array() += 1e-6 * gram.trace() / rotors + 1e-12;
  const Vector3 explained = right.cwiseProduct(ridged.ldlt().solve(right)).colwise().sum();
  return {gram, right, explained.cwiseMax(0.0).cwiseSqrt(),
          explained.head<2>().sum() / (total.head<2>().sum() + 1e-300), explained.z() / (total.z() + 1e-300)};
}

// how strongly each rotor turns the vehicle about each axis by the vehicle file, rotor i standing where `place[i]` stands
Eigen::MatrixXd nominal_gains(const VehicleModel& vehicle, const std::vector<int>& place) {
  Eigen::MatrixXd gains(3, vehicle.rotor_count);
  for (int i = 0; i < vehicle.rotor_count; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(place[static_cast<std::size_t>(i)])];
    const Vector3 hub = rotor.position_B_m - vehicle.center_of_mass_B_m;
    gains.col(i) = hub.cross(rotor.axis_B) - rotor.direction * rotor.torque_ratio_m * rotor.axis_B;
  }
  return gains;
}

// angular acceleration about an axis over what these gains predict of it
double size_of(const Response& response, int axis, const Row& gains, const VehicleModel& vehicle) {
  const double thrust_N = vehicle.rotors[0].thrust_coefficient_Ns2 * std::pow(vehicle.hover_speed_radps(), 2);
  return gains.dot(response.right.col(axis)) / ((gains * response.gram).dot(gains) + 1e-300) *
         vehicle.inertia_B_kgm2(axis, axis) / thrust_N;
}

// A size that the file's torques and moments of inertia can have. What a loop answers, or half a swing of it later, is of another.
bool is_plausible(double size) {
  constexpr double most = 2.5;
  return size > 1.0 / most && size < most;
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
  // Rotors and logs answer late by an unknown time. Of delays that explain nearly as much the least counts: a loop that swings seems to
  // answer half a swing later, too, the other way round.
  std::vector<Response> at;
  for (const double delay_s : {0.0, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.1, 0.125, 0.15, 0.175})
    at.push_back(measured_response(flights, vehicle, delay_s));
  const double most = std::ranges::max_element(at, {}, &Response::explained)->explained;
  const auto first = std::ranges::find_if(at, [&](const Response& r) { return r.explained >= 0.8 * most; });
  const Response& found = *first;
  if (found.explained < 0.1) return findings;
  std::vector<int> place(static_cast<std::size_t>(vehicle.rotor_count));
  std::iota(place.begin(), place.end(), 0);
  const auto level_at = [&](const Response& r, const Eigen::MatrixXd& g) {
    return r.agreement(0, g.row(0)) + r.agreement(1, g.row(1));
  };
  const auto sized = [&](const Response& r, const Eigen::MatrixXd& g) {
    return is_plausible(size_of(r, 0, g.row(0), vehicle)) && is_plausible(size_of(r, 1, g.row(1), vehicle));
  };
  const auto level = [&](const std::vector<int>& p) { return level_at(found, nominal_gains(vehicle, p)); };
  const auto whole = [&](const std::vector<int>& p) {
    return level(p) + 0.5 * std::abs(found.agreement(2, nominal_gains(vehicle, p).row(2)));
  };
  const std::string file = vehicle.source_path.substr(vehicle.source_path.find_last_of('/') + 1);
  constexpr double agrees = 1.5;
  const Eigen::MatrixXd by_file = nominal_gains(vehicle, place);
  const double stated = level_at(found, by_file);
  // what comes after the file's order is what the loop answers
  const bool before = std::any_of(
      at.begin(), first, [&](const Response& r) { return level_at(r, by_file) >= agrees && sized(r, by_file); });
  if (stated < agrees && !before) {
    std::vector<int> best = place, trial = place;
    do {
      if (whole(trial) > whole(best)) best = trial;
    } while (std::next_permutation(trial.begin(), trial.end()));
    if (level(best) > 1.7 && level(best) > stated + 0.4 && sized(found, nominal_gains(vehicle, best))) {
      LogFinding finding;
      finding.file = file;
      finding.column = "rotor";
      finding.kind = "inconsistent";
      finding.says = fmt::format(
          "the rotor order of the vehicle file contradicts roll and pitch (agreement {:.2f}, full is 2); u1…u{} drive "
          "the rotors that the file lists as {} (agreement {:.2f}): the diagnosis goes on with that order",
          stated, vehicle.rotor_count, order_text(best), level(best));
      findings.push_back(finding);
      const auto rotors = vehicle.rotors;
      for (std::size_t i = 0; i < best.size(); ++i) vehicle.rotors[i] = rotors[static_cast<std::size_t>(best[i])];
    }
  }
  // A part that small is noise, which agrees with any torque or its opposite. And the loop of a right vehicle may answer what yaws it at once,
  // with a torque against the acceleration that is there: that is several times smaller, or larger, than the file's torque would need.
  constexpr double least_explained = 0.15, surely = 0.6;
  if (level(place) > 1.0 && found.yaw_explained > least_explained && vehicle.rotors[0].torque_ratio_m > 0.0) {
    const Row gains = nominal_gains(vehicle, place).row(2);
    const double yaw = found.agreement(2, gains);
    if (yaw < -surely && is_plausible(-size_of(found, 2, gains, vehicle))) {
      LogFinding finding;
      finding.file = file;
      finding.column = "rotor.direction";
      finding.kind = "sign";
      finding.says = fmt::format(
          "the vehicle yaws against the torque of the vehicle file (agreement {:.2f}, full is 1): every rotor turns "
          "the other way "
          "round than the file says, and the diagnosis goes on with that",
          yaw);
      findings.push_back(finding);
      for (int i = 0; i < vehicle.rotor_count; ++i) vehicle.rotors[static_cast<std::size_t>(i)].direction *= -1.0;
    }
  }
  return findings;
}

AngularAccelerationSeries angular_acceleration_series(const FlightData& flight, const VehicleModel& vehicle) {
  const CommandRecord& record = flight.rotor_record();
  std::vector<int> place(static_cast<std::size_t>(vehicle.rotor_count));
  std::iota(place.begin(), place.end(), 0);
  const Eigen::MatrixXd gains = nominal_gains(vehicle, place);
  const double hover = vehicle.hover_speed_radps();
  const auto back = static_cast<std::size_t>(std::max(1.0, std::round(difference_s / flight.sample_s)));
  const std::size_t count = flight.samples.size();
  const Eigen::Vector2d none = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  AngularAccelerationSeries series{std::vector<Eigen::Vector2d>(count, none),
                                   std::vector<Eigen::Vector2d>(count, none)};
  std::vector<Eigen::Vector2d> torque;
  for (const Sample& sample : flight.samples) {
    const RotorArray speed = record.mean(sample.time_s - 0.5 * average_s, sample.time_s + 0.5 * average_s);
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int i = 0; i < vehicle.rotor_count; ++i)
      sum += gains.col(i).head<2>() * std::pow(speed[static_cast<std::size_t>(i)] / hover, 2);
    torque.push_back(sum);
  }
  for (std::size_t k = 2 * back; k + back < count; ++k) {
    series.torque[k] = torque[k] - torque[k - back];
    series.acceleration[k] =
        (flight.motion[k].angular_acceleration_B_radps2 - flight.motion[k - back].angular_acceleration_B_radps2)
            .head<2>();
  }
  return series;
}

std::optional<double> torque_delay_s(const FlightData& flight, const VehicleModel& vehicle) {
  if (flight.collective_only || flight.samples.size() < 200) return std::nullopt;
  const CommandRecord& record = flight.rotor_record();
  std::vector<int> place(static_cast<std::size_t>(vehicle.rotor_count));
  std::iota(place.begin(), place.end(), 0);
  const Eigen::MatrixXd gains = nominal_gains(vehicle, place);
  const double hover = vehicle.hover_speed_radps(), dt = flight.sample_s;
  const auto lag = static_cast<std::size_t>(std::max(1.0, std::round(difference_s / dt)));
  const auto agreement = [&](double delay_s) {
    double xy = 0.0, xx = 0.0, yy = 0.0;
    const auto torque = [&](std::size_t k) {
      const RotorArray speed = record.mean(flight.samples[k].time_s - delay_s - 0.5 * average_s,
                                           flight.samples[k].time_s - delay_s + 0.5 * average_s);
      Eigen::Vector2d t = Eigen::Vector2d::Zero();
      for (int i = 0; i < vehicle.rotor_count; ++i)
        t += gains.col(i).head<2>() * std::pow(speed[static_cast<std::size_t>(i)] / hover, 2);
      return t;
    };
    for (std::size_t k = 2 * lag; k + lag < flight.samples.size(); ++k) {
      const Eigen::Vector2d x = torque(k) - torque(k - lag);
      const Eigen::Vector2d y =
          (flight.motion[k].angular_acceleration_B_radps2 - flight.motion[k - lag].angular_acceleration_B_radps2)
              .head<2>();
      xy += x.dot(y), xx += x.squaredNorm(), yy += y.squaredNorm();
    }
    return xy / std::sqrt(xx * yy + 1e-300);
  };
  double best = 0.0, at = 0.0;
  const double step = 0.25 * dt;
  for (double delay_s = -4.0 * dt; delay_s <= 10.0 * dt + 1e-9; delay_s += step) {
    const double r = agreement(delay_s);
    if (r > best) best = r, at = delay_s;
  }
  if (best < 0.25) return std::nullopt;
  // the top of a parabola through three points
  const double left = agreement(at - step), right = agreement(at + step), bend = left - 2.0 * best + right;
  return bend < 0.0 ? at + 0.5 * step * (left - right) / bend : at;
}

}  // namespace gustlab::diagnosis
