#include "identification/force_residual.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "gustlab/errors.hpp"
#include "util/quantiles.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using Columns = std::vector<const std::vector<double>*>;

// the columns, or none when the log has none of them
Columns find(const FlightLog& log, std::initializer_list<std::string_view> names) {
  Columns columns;
  for (std::string_view name : names) {
    if (const auto* column = log.find(name)) columns.push_back(column);
  }
  return columns.size() == names.size() ? columns : Columns{};
}

Columns need(const FlightLog& log, std::initializer_list<std::string_view> names, std::string_view why) {
  Columns columns = find(log, names);
  if (columns.empty()) {
    throw DataError(
        fmt::format("{}:1:1: columns {} are missing ({}); log them", log.path, fmt::join(names, ", "), why));
  }
  return columns;
}

Vector3 vector_at(const Columns& columns, std::size_t row) {
  return columns.empty() ? Vector3::Zero() : Vector3((*columns[0])[row], (*columns[1])[row], (*columns[2])[row]);
}

// rows without gaps: a step of more than 1.6 times the median ends a part
std::vector<std::vector<std::size_t>> unbroken(const std::vector<double>& time_s,
                                               const std::vector<std::size_t>& rows) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) steps.push_back(time_s[rows[i]] - time_s[rows[i - 1]]);
  if (steps.empty()) return {};
  const double longest_s = 1.6 * median(steps);
  std::vector<std::vector<std::size_t>> parts = {{rows[0]}};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (steps[i - 1] > longest_s) parts.emplace_back();
    parts.back().push_back(rows[i]);
  }
  return parts;
}

// removes jumps of 2π
void unwrap(Eigen::Ref<VectorXd> angle_rad) {
  for (Index i = 1; i < angle_rad.size(); ++i) {
    angle_rad[i] -= 2.0 * pi * std::round((angle_rad[i] - angle_rad[i - 1]) / (2.0 * pi));
  }
}

class Extraction {
 public:
  Extraction(const FlightLog& log, const VehicleModel& vehicle, const KnownModel& known,
             const Differentiation& differentiation, AccelerationSource source)
      : log_(log),
        vehicle_(vehicle),
        known_(known),
        differentiation_(differentiation),
        source_(source),
        position_(find(log, {"px", "py", "pz"})),
        velocity_(find(log, {"vx", "vy", "vz"})),
        attitude_(need(log, {"qw", "qx", "qy", "qz"}, "thrust acts along the body's axis")),
        rate_(find(log, {"wx", "wy", "wz"})),
        specific_force_(find(log, {"ax", "ay", "az"})) {
    if (velocity_.empty()) need(log, {"px", "py", "pz"}, "the acceleration is a derivative of velocity or position");
    if (source == AccelerationSource::accelerometer) need(log, {"ax", "ay", "az"}, "asked for by --acceleration");
  }

  std::vector<ResidualSamples> run() const {
    std::vector<ResidualSamples> out;
    const int window = differentiation_.kind == DerivativeKind::savitzky_golay ? differentiation_.window : 3;
    const auto shortest = static_cast<std::size_t>(std::max(window, differentiation_.smoothing_window));
    for (const auto& rows : unbroken(log_.time_s, complete_rows())) {
      if (rows.size() < shortest) continue;
      ResidualSamples samples = part(rows);
      if (!samples.inputs.empty()) out.push_back(std::move(samples));
    }
    if (out.empty()) {
      throw DataError(
          fmt::format("{}: no usable stretch is left (fewer than {} samples in a row, or all of it trimmed); "
                      "trim or smooth less, or give a longer log",
                      log_.path, shortest));
    }
    return out;
  }

 private:
  std::vector<std::size_t> complete_rows() const {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < log_.rows(); ++row) {
      const auto has = [row](const Columns& columns) {
        return std::all_of(columns.begin(), columns.end(), [row](const auto* c) { return std::isfinite((*c)[row]); });
      };
      const bool accelerometer = source_ != AccelerationSource::accelerometer || has(specific_force_);
      if (!has(position_) || !has(velocity_) || !has(attitude_) || !has(rate_) || !accelerometer) continue;
      if (std::isfinite(known_(row, state(row)).thrust_N)) rows.push_back(row);
    }
    return rows;
  }

  VehicleState state(std::size_t row) const {
    VehicleState out;
    out.time_s = log_.time_s[row];
    out.position_W_m = vector_at(position_, row);
    out.velocity_W_mps = vector_at(velocity_, row);
    out.attitude_WB =
        Quaternion((*attitude_[0])[row], (*attitude_[1])[row], (*attitude_[2])[row], (*attitude_[3])[row]).normalized();
    out.body_rate_B_radps = vector_at(rate_, row);
    return out;
  }

  ResidualSamples part(const std::vector<std::size_t>& rows) const {
    // columns of one table: 0 position, 3 velocity of the origin, 6 of the centre of mass, 9 known force, 12 specific
    // force of the origin, all in W; 15 roll, pitch, yaw, 18 thrust, 19 body rate
    const Index n = static_cast<Index>(rows.size());
    VectorXd time_s(n);
    MatrixXd raw = MatrixXd::Zero(n, 22), position(n, 3);
    for (Index i = 0; i < n; ++i) {
      const std::size_t row = rows[static_cast<std::size_t>(i)];
      time_s[i] = log_.time_s[row];
      position.row(i) = vector_at(position_, row);
    }
    const MatrixXd derived = velocity_.empty() ? finite_difference(time_s, position) : MatrixXd();
    for (Index i = 0; i < n; ++i) {
      const std::size_t row = rows[static_cast<std::size_t>(i)];
      VehicleState now = state(row);
      if (velocity_.empty()) now.velocity_W_mps = derived.row(i);
      const Matrix3 R_WB = now.attitude_WB.toRotationMatrix();
      const KnownForce force = known_(row, now);
      FeatureInput angles;
      set_angles(angles, R_WB);
      raw.row(i) << now.position_W_m.transpose(), now.velocity_W_mps.transpose(),
          (now.velocity_W_mps + R_WB * now.body_rate_B_radps.cross(vehicle_.center_of_mass_B_m)).transpose(),
          (R_WB * force.force_B_N).transpose(), (R_WB * vector_at(specific_force_, row)).transpose(), angles.roll_rad,
          angles.pitch_rad, angles.yaw_rad, force.thrust_N, now.body_rate_B_radps.transpose();
    }
    unwrap(raw.col(15));
    unwrap(raw.col(17));

    const MatrixXd smooth = differentiation_.smooth(time_s, raw);
    MatrixXd force_W_N = -smooth.middleCols(9, 3);
    if (source_ == AccelerationSource::accelerometer) {
      // it rides on the origin: what the centre of mass accelerates beyond that is a derivative after all
      const MatrixXd beyond = raw.middleCols(6, 3) - raw.middleCols(3, 3);
      force_W_N += vehicle_.mass_kg * (smooth.middleCols(12, 3) + differentiation_.derivative(time_s, beyond));
    } else {
      force_W_N += vehicle_.mass_kg * differentiation_.derivative(time_s, raw.middleCols(6, 3));
      force_W_N.col(2).array() += vehicle_.weight_N();
    }

    const auto [first, count] = trimmed_rows(time_s, differentiation_.edge_s);
    ResidualSamples out;
    out.force_W_N = force_W_N.middleRows(first, count);
    for (Index i = first; i < first + count; ++i) {
      FeatureInput input;
      input.position_W_m = smooth.row(i).segment<3>(0);
      input.velocity_W_mps = smooth.row(i).segment<3>(3);
      input.roll_rad = smooth(i, 15);
      input.pitch_rad = smooth(i, 16);
      input.yaw_rad = smooth(i, 17);
      input.thrust_N = smooth(i, 18);
      input.body_rate_B_radps = smooth.row(i).segment<3>(19);
      out.time_s.push_back(time_s[i]);
      out.inputs.push_back(input);
    }
    return out;
  }

  const FlightLog& log_;
  const VehicleModel& vehicle_;
  const KnownModel& known_;
  const Differentiation& differentiation_;
  AccelerationSource source_;
  Columns position_, velocity_, attitude_, rate_, specific_force_;
};

}  // namespace

std::vector<ResidualSamples> force_residual(const FlightLog& log, const VehicleModel& vehicle, const KnownModel& known,
                                            const Differentiation& differentiation, AccelerationSource source) {
  differentiation.check();
  return Extraction(log, vehicle, known, differentiation, source).run();
}

}  // namespace gustlab
