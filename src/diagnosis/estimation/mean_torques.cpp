#include "diagnosis/estimation/mean_torques.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/estimation/indices.hpp"

namespace gustlab::diagnosis {

namespace {

// Of Neural-Swarm's flights means over 1 s are correlated with their neighbours by −0.2 to −0.7, those over 2 s by 0.1 to 0.4.
constexpr double averaged_s = 2.0;
constexpr double least_sd_radps2 = 0.05;

using AngularAccelerations = Eigen::Matrix<double, 3, Eigen::Dynamic>;

// Between samples the loop answers how the body turns: what goes with its rate is projected out, axis by axis.
void take_damping_out(const std::vector<Vector3>& rates, LinearFlight& flight) {
  for (int axis = 0; axis < 2; ++axis) {
    double squares = 1e-12;
    for (const Vector3& rate : rates) squares += rate[axis] * rate[axis];
    double along = 0.0;
    Eigen::RowVectorXd along_by = Eigen::RowVectorXd::Zero(std::ssize(flight.columns));
    for (std::size_t w = 0; w < rates.size(); ++w) {
      along += rates[w][axis] * flight.mean_acceleration[w][axis] / squares;
      along_by += rates[w][axis] / squares * flight.mean_acceleration_by[w].row(axis);
    }
    for (std::size_t w = 0; w < rates.size(); ++w) {
      flight.mean_acceleration[w][axis] -= rates[w][axis] * along;
      flight.mean_acceleration_by[w].row(axis) -= rates[w][axis] * along_by;
    }
  }
}

}  // namespace

std::vector<int> that_shift_torques(const Catalogue& catalogue, const std::vector<int>& columns) {
  std::vector<int> some;
  std::ranges::copy_if(columns, std::back_inserter(some), [&](int c) {
    const int g = catalogue.column(c).group;
    return g >= 0 && shifts_torques(*catalogue.group(g).row);
  });
  return some;
}

void balance_torques(const FlightData& each_rotor, const LinearFlight& linear, LinearFlight& flight) {
  flight.window_s.clear(), flight.mean_acceleration.clear(), flight.mean_acceleration_by.clear();
  const std::vector<int> to = indices_of(linear.columns, flight.columns);
  std::vector<Vector3> rates;
  const std::size_t n = linear.size();
  for (std::size_t first = 0; first < n;) {
    std::size_t last = first;
    double duration_s = 0.0;
    Vector3 missing = Vector3::Zero(), turned = Vector3::Zero();
    AngularAccelerations by = AngularAccelerations::Zero(3, std::ssize(linear.columns));
    for (; last + 1 < n && !linear.starts[last + 1] && duration_s < averaged_s; ++last) {
      missing -= linear.b[last].tail<3>();
      by += linear.interval_s[last] * linear.acceleration_by[last].bottomRows<3>();
      turned += linear.interval_s[last] * each_rotor.motion[last].body_rate_B_radps;
      duration_s += linear.interval_s[last];
    }
    if (duration_s >= averaged_s) {
      flight.window_s.push_back(each_rotor.samples[first].time_s);
      flight.mean_acceleration.emplace_back(missing / duration_s);
      flight.mean_acceleration_by.emplace_back(AngularAccelerations::Zero(3, std::ssize(flight.columns)))(
          Eigen::all, to) = by / duration_s;
      rates.emplace_back(turned / duration_s);
    }
    first = std::max(last, first + 1);
  }
  take_damping_out(rates, flight);
}

Whitened whiten_mean_torques(const LinearFlight& flight, double variance) {
  Whitened out;
  if (flight.mean_acceleration.empty() || variance <= 0.0) return out;
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const double sd = std::sqrt(variance);
  out.rows.resize(2 * std::ssize(flight.mean_acceleration), own + 1);
  Eigen::Index row = 0;
  for (std::size_t w = 0; w < flight.mean_acceleration.size(); ++w)
    for (int axis = 0; axis < 2; ++axis, ++row) {
      const double z = flight.mean_acceleration[w][axis] / sd;
      if (own > 0) out.rows.row(row).head(own) = flight.mean_acceleration_by[w].row(axis) / sd;
      out.rows(row, own) = z;
      out.minus_two_log_likelihood += std::log(variance) + z * z;
      out.time_s.push_back(flight.window_s[w]);
      out.channel.push_back(axis);
      out.warm.push_back(true);
    }
  return out;
}

double mean_torque_variance(const std::vector<LinearFlight>& rest) {
  double squares = 0.0, differences = 0.0, count = 0.0, pairs = 0.0;
  for (const LinearFlight& flight : rest)
    for (std::size_t w = 0; w < flight.mean_acceleration.size(); ++w) {
      squares += flight.mean_acceleration[w].head<2>().squaredNorm(), count += 2.0;
      if (w == 0) continue;
      differences += 0.5 * (flight.mean_acceleration[w] - flight.mean_acceleration[w - 1]).head<2>().squaredNorm(),
          pairs += 2.0;
    }
  if (count == 0.0) return 0.0;
  return std::max({squares / count, differences / std::max(1.0, pairs), least_sd_radps2 * least_sd_radps2});
}

}  // namespace gustlab::diagnosis
