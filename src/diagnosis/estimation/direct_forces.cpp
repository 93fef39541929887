#include "diagnosis/estimation/direct_forces.hpp"

#include <algorithm>
#include <cmath>

namespace gustlab::diagnosis {

Whitened whiten_forces(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                       const FurtherColumns& further) {
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const Eigen::Index more = further.size;
  Whitened out;
  out.rows.resize(static_cast<Eigen::Index>(3 * flight.size()), own + more + 1);
  Eigen::Index row_index = 0;
  Eigen::Matrix<double, 3, Eigen::Dynamic> further_felt;
  for (std::size_t k = 0; k < flight.size(); ++k) {
    if (more > 0) further_felt = felt(further.at(k), flight.R_WB[k]);
    for (int axis = 0; axis < 3; ++axis) {
      const int r = first_force_row + axis;
      if (!flight.measured[k][r]) continue;
      auto row = out.rows.row(row_index);
      if (own > 0) row.head(own) = flight.felt_by[k].row(axis);
      if (more > 0) row.segment(own, more) = further_felt.row(axis);
      row[own + more] = flight.y[k][r];
      const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(axis)]);
      const double variance = noise.variance[g] * std::max(1.0, 2.0 * noise.time_s[g] / flight.interval_s[k]);
      row /= std::sqrt(variance);
      out.minus_two_log_likelihood += std::log(variance) + row[own + more] * row[own + more];
      out.time_s.push_back(data.samples[k].time_s);
      out.channel.push_back(r);
      out.warm.push_back(true);
      ++row_index;
    }
  }
  out.rows.conservativeResize(row_index, Eigen::NoChange);
  return out;
}

Smoothed smooth_forces(const LinearFlight& flight) {
  Smoothed out;
  out.disturbance.assign(flight.size(), Eigen::Matrix<double, 6, 1>::Zero());
  out.disturbance_variance.assign(flight.size(), Eigen::Matrix<double, 6, 1>::Zero());
  Vector3 before = Vector3::Zero();
  bool linked = false;
  for (std::size_t k = 0; k < flight.size(); ++k) {
    linked = linked && !flight.starts[k];
    if (!flight.measured[k].tail<3>().all()) {
      linked = false;
      continue;
    }
    const Vector3 residual = flight.y[k].tail<3>();
    out.disturbance[k].head<3>() = flight.R_WB[k] * residual;
    for (std::size_t j = 0; j < 3; ++j) {
      const double d = residual[static_cast<Eigen::Index>(j)], e = before[static_cast<Eigen::Index>(j)];
      out.second[j] += d * d, out.count[j] += 1.0;
      if (linked) out.earlier[j] += e * e, out.later[j] += d * d, out.lagged[j] += d * e, out.pairs[j] += 1.0;
    }
    before = residual;
    linked = true;
  }
  // of torques nothing is learnt: at their floor, and no finding
  for (std::size_t j = 3; j < 6; ++j) {
    out.second[j] = out.earlier[j] = out.later[j] = 1e-12, out.lagged[j] = 0.5e-12;
    out.count[j] = out.pairs[j] = 1.0;
  }
  return out;
}

}  // namespace gustlab::diagnosis
