#include "diagnosis/model/command_innovation.hpp"

#include <Eigen/Cholesky>

#include "diagnosis/model/propagation.hpp"
#include "simulation/make_effects.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr std::size_t lags = 3, fewest_samples = 200;
constexpr double memory_s = 0.2, ridge = 1e-6;
constexpr double slower_commands = 1.5;  // an interval that is so many samples long is no jitter of one sample
constexpr Eigen::Index per_lag = 4 + 3 + 3 + 3 + 3, inputs = per_lag * static_cast<Eigen::Index>(lags) + 1;

// what a controller could know at a sample: each channel as it was last measured
std::vector<Sample> as_known(const FlightData& flight) {
  std::vector<Sample> known = flight.samples;
  for (std::size_t k = 1; k < known.size(); ++k) {
    Sample& now = known[k];
    const Sample& before = known[k - 1];
    if (!(now.channels & has_rate)) now.body_rate_B_radps = before.body_rate_B_radps;
    if (!(now.channels & has_attitude)) now.attitude_WB = before.attitude_WB;
    if (!(now.channels & (has_velocity | has_position))) now.velocity_W_mps = before.velocity_W_mps;
    if (!(now.channels & has_position)) now.position_W_m = before.position_W_m;
  }
  return known;
}

// First samples of the intervals that one command lasts, and behind the last: of commands that are logged as often as all else, every
// sample.
std::vector<std::size_t> command_intervals(const FlightData& flight) {
  std::vector<std::size_t> first;
  const std::vector<double>& at_s = flight.commands.time_s();
  const bool slower = commands_are_slower(flight);
  for (std::size_t k = 0, next = 0; k < flight.samples.size(); ++k) {
    const double from_s = flight.samples[k].time_s - 0.5 * flight.sample_s;
    const bool fresh = next < at_s.size() && at_s[next] <= from_s + flight.sample_s;
    while (next < at_s.size() && at_s[next] <= from_s + flight.sample_s) ++next;
    if (!slower || fresh || flight.samples[k].starts_segment) first.push_back(k);
  }
  first.push_back(flight.samples.size());
  return first;
}

}  // namespace

std::vector<Eigen::Vector4d> rotor_acceleration(const FlightData& flight) {
  ForceModel forces(flight.vehicle, make_effects(flight.vehicle.effects));
  forces.set_speed_is_measured(!flight.measured_speed.empty());
  forces.prepare(flight.sample_s / flight.substeps, 0, 0);
  return rotor_acceleration(flight, forces, rotor_history(flight, forces));
}

std::vector<Eigen::Vector4d> rotor_acceleration(const FlightData& flight, const ForceModel& forces,
                                                const RotorHistory& rotors) {
  const auto count = static_cast<std::size_t>(rotors.substeps);
  Evaluator evaluate{forces, {}, {}};
  const Point rest{Vector3(0.0, 0.0, 1e3), Vector3::Zero(), Quaternion::Identity(), Vector3::Zero()};
  std::vector<Eigen::Vector4d> result;
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const Acceleration a =
        evaluate(rest, 0.0, flight.vehicle.nominal_voltage_V, mean_of(&rotors.mean[k * count], rotors.substeps), {});
    result.emplace_back(a.angular_B_radps2.x(), a.angular_B_radps2.y(), a.angular_B_radps2.z(), a.linear_W_mps2.z());
  }
  return result;
}

bool commands_are_slower(const FlightData& flight) {
  const std::vector<double>& at_s = flight.commands.time_s();
  if (flight.hold_known || !flight.measured_speed.empty() || at_s.size() < 2) return false;
  if (flight.loop_goes_on) return true;
  const double interval_s = (at_s.back() - at_s.front()) / static_cast<double>(at_s.size() - 1);
  return interval_s > slower_commands * flight.sample_s;
}

std::vector<CommandInnovation> command_innovation(const FlightData& flight) {
  if (flight.collective_only || flight.samples.size() < fewest_samples) return {};
  const std::vector<Sample> known = as_known(flight);
  const std::vector<Eigen::Vector4d> each = rotor_acceleration(flight);
  const std::vector<std::size_t> first = command_intervals(flight);
  const std::size_t intervals = first.size() - 1;
  std::vector<Eigen::Vector4d> acceleration(intervals, Eigen::Vector4d::Zero());
  for (std::size_t i = 0; i < intervals; ++i)
    for (std::size_t k = first[i]; k < first[i + 1]; ++k)
      acceleration[i] += each[k] / static_cast<double>(first[i + 1] - first[i]);

  std::vector<std::size_t> row;
  for (std::size_t i = 0, run = 0; i < intervals; ++i) {
    run = known[first[i]].starts_segment ? 0 : run + 1;
    if (run > lags) row.push_back(i);
  }
  Eigen::MatrixXd X(static_cast<Eigen::Index>(row.size()), inputs), Y(static_cast<Eigen::Index>(row.size()), 4);
  for (std::size_t i = 0; i < row.size(); ++i) {
    Eigen::Matrix<double, 1, inputs> x;
    Eigen::Index at = 0;
    for (std::size_t lag = 0; lag < lags; ++lag) {
      const Sample& s = known[first[row[i] - lag]];
      const Matrix3 R = s.attitude_WB.toRotationMatrix();
      x.segment<3>(at) = s.body_rate_B_radps.transpose();
      x.segment<3>(at + 3) = R.row(2);
      x.segment<3>(at + 6) = (R.transpose() * s.velocity_W_mps).transpose();
      x.segment<3>(at + 9) = s.position_W_m.transpose();
      x.segment<4>(at + 12) = acceleration[row[i] - lag - 1].transpose();
      at += per_lag;
    }
    x[at] = 1.0;
    X.row(static_cast<Eigen::Index>(i)) = x;
    Y.row(static_cast<Eigen::Index>(i)) = acceleration[row[i]].transpose();
  }
  const Eigen::RowVectorXd mean = X.colwise().mean();
  X.rowwise() -= mean;
  X.rightCols<1>().setOnes();
  const Eigen::RowVectorXd scale =
      (X.colwise().squaredNorm() / static_cast<double>(X.rows())).cwiseSqrt().array() + 1e-12;
  for (Eigen::Index c = 0; c < inputs; ++c) X.col(c) /= scale[c];
  Eigen::MatrixXd gram = X.transpose() * X;
  gram.diagonal().head<inputs - 1>().array() += ridge * static_cast<double>(X.rows());  // the mean is free
  const Eigen::MatrixXd left = Y - X * gram.ldlt().solve(X.transpose() * Y);
  std::vector<CommandInnovation> innovation(each.size(), CommandInnovation::Zero());
  for (std::size_t i = 0; i < row.size(); ++i)
    for (std::size_t k = first[row[i]]; k < first[row[i] + 1]; ++k)
      innovation[k].head<4>() = left.row(static_cast<Eigen::Index>(i)).transpose();
  const double kept = std::exp(-flight.sample_s / memory_s);
  for (std::size_t k = 1; k < innovation.size(); ++k)
    if (!flight.samples[k].starts_segment)
      innovation[k].segment<4>(4) = kept * innovation[k - 1].segment<4>(4) + (1.0 - kept) * innovation[k - 1].head<4>();
  if (commands_are_slower(flight))
    for (std::size_t k = 0; k < innovation.size(); ++k)
      innovation[k].tail<4>() << known[k].body_rate_B_radps.head<2>(), each[k].head<2>();
  return innovation;
}

}  // namespace gustlab::diagnosis
