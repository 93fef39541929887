#include "diagnosis/estimation/rotor_speeds.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/model/propagation.hpp"
#include "diagnosis/model/speed_comparison.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double settling_s = 0.3;  // after a gap, until the speed before it is forgotten
constexpr double least_hover = 0.2,
                 most_limit = 0.98;  // shares of the hover speed and of the limit between which a map holds
constexpr double latest_s = 0.1;
constexpr double least_white_share = 2e-4;  // of the hover speed, sd: integrators differ

}  // namespace

Whitened whiten_speeds(const FlightData& data, const LinearFlight& flight, const SpeedNoise& noise) {
  Whitened out;
  if (flight.faster.empty() || noise.white <= 0.0) return out;
  const std::size_t n = flight.faster.size();
  const auto rotors = static_cast<std::size_t>(data.vehicle.rotor_count);
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const double hover = data.vehicle.hover_speed_radps(), limit = most_limit * data.vehicle.max_speed_radps;
  out.rows.resize(static_cast<Eigen::Index>(n * rotors), own + 1);
  using Map = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Map map(out.rows.rows(), 3);
  // one process for each column: innovations of an Ornstein-Uhlenbeck process beside white noise
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(own + 1 + map.cols(), static_cast<Eigen::Index>(rotors));
  Eigen::VectorXd e(state.rows());
  double P = noise.variance, begin_s = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (data.samples[k].starts_segment) {
      state.setZero();
      P = noise.variance;
      begin_s = data.samples[k].time_s;
    }
    const double S = P + noise.white, sd = std::sqrt(S);
    for (std::size_t i = 0; i < rotors; ++i) {
      const auto at = static_cast<Eigen::Index>(k * rotors + i);
      for (Eigen::Index j = 0; j < own; ++j) {
        const auto& by = flight.predicted_by[static_cast<std::size_t>(j)];
        e[j] = by.empty() ? 0.0 : by[k][i];
      }
      const double speed = flight.predicted[k][i] / hover;
      e[own] = flight.faster[k][i];
      e.tail<3>() << 1.0, speed, speed * speed;
      e -= state.col(static_cast<Eigen::Index>(i));
      out.rows.row(at) = e.head(own + 1).transpose() / sd;
      map.row(at) = e.tail<3>().transpose() / sd;
      state.col(static_cast<Eigen::Index>(i)) += P / S * e;
      out.time_s.push_back(data.samples[k].time_s);
      out.warm.push_back(data.samples[k].time_s - begin_s > settling_s && speed > least_hover &&
                         flight.predicted[k][i] < limit);
      out.minus_two_log_likelihood += out.warm.back() ? std::log(S) : 0.0;
    }
    P *= noise.white / S;
    if (k + 1 == n) break;
    const double kept = std::exp(-(data.samples[k + 1].time_s - data.samples[k].time_s) / noise.time_s);
    state *= kept;
    P = kept * kept * P + (1.0 - kept * kept) * noise.variance;
  }
  for (std::size_t i = 0; i < rotors; ++i) {
    std::vector<Eigen::Index> rows;
    for (std::size_t k = 0; k < n; ++k)
      if (out.warm[k * rotors + i]) rows.push_back(static_cast<Eigen::Index>(k * rotors + i));
    const Map M = map(rows, Eigen::all);
    const Eigen::MatrixXd X = out.rows(rows, Eigen::all);
    Eigen::Matrix3d gram = M.transpose() * M;
    gram.diagonal().array() += 1e-12 * gram.trace() + 1e-300;
    const Eigen::MatrixXd left = X - M * gram.ldlt().solve(M.transpose() * X);
    out.rows(rows, Eigen::all) = left;
    // not of out.rows(rows, own): Eigen 3.4 sums such a view of a row-major matrix wrongly
    out.minus_two_log_likelihood += left.col(own).squaredNorm();
  }
  return out;
}

namespace {

// an Ornstein–Uhlenbeck process seen through white noise, smoothed (Rauch, Tung, Striebel 1965), from one segment's values
std::vector<double> smoothed(const std::vector<double>& y, const std::vector<double>& kept, const SpeedNoise& noise) {
  const std::size_t n = y.size();
  std::vector<double> x(n), P(n), ahead(n), P_ahead(n);
  for (std::size_t k = 0; k < n; ++k) {
    ahead[k] = k > 0 ? kept[k - 1] * x[k - 1] : 0.0;
    P_ahead[k] = k > 0 ? kept[k - 1] * kept[k - 1] * P[k - 1] + (1.0 - kept[k - 1] * kept[k - 1]) * noise.variance
                       : noise.variance;
    const double gain = P_ahead[k] / (P_ahead[k] + noise.white);
    x[k] = ahead[k] + gain * (y[k] - ahead[k]);
    P[k] = (1.0 - gain) * P_ahead[k];
  }
  for (std::size_t k = n; k-- > 1;) x[k - 1] += P[k - 1] * kept[k - 1] / P_ahead[k] * (x[k] - ahead[k]);
  return x;
}

}  // namespace

void estimate_speeds(FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                     const SpeedNoise& noise) {
  flight.estimated = {};
  if (flight.measured_at_sample.empty() || !flight.jumping_speed.empty() || noise.white <= 0.0) return;
  const ForceModel forces = force_model(flight, catalogue, value, flight_index, -1);
  RotorHistory estimate = commanded_history(flight, forces);
  const std::vector<RotorArray>& measured = flight.measured_at_sample;
  const std::size_t n = measured.size(), count = static_cast<std::size_t>(estimate.substeps);
  const auto rotors = static_cast<std::size_t>(flight.vehicle.rotor_count);
  std::vector<double> kept(n, 0.0);
  for (std::size_t k = 0; k + 1 < n; ++k)
    if (!flight.samples[k + 1].starts_segment)
      kept[k] = std::exp(-(flight.samples[k + 1].time_s - flight.samples[k].time_s) / noise.time_s);
  std::vector<RotorArray> correction(n, RotorArray{});
  double left = 0.0, changes = 0.0;
  for (std::size_t i = 0; i < rotors; ++i) {
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    Vector3 right = Vector3::Zero();
    const auto map = [&](std::size_t k) {
      const double speed = estimate.at_sample[k][i] / flight.vehicle.hover_speed_radps();
      return Vector3(1.0, speed, speed * speed);
    };
    for (std::size_t k = 0; k < n; ++k) {
      gram += map(k) * map(k).transpose();
      right += map(k) * (measured[k][i] - estimate.at_sample[k][i]);
    }
    gram.diagonal().array() += 1e-12 * gram.trace() + 1e-300;
    const Vector3 coefficient = gram.ldlt().solve(right);
    std::vector<double> rest(n);
    for (std::size_t k = 0; k < n; ++k) rest[k] = measured[k][i] - estimate.at_sample[k][i] - coefficient.dot(map(k));
    const std::vector<double> slow = smoothed(rest, kept, noise);
    for (std::size_t k = 1; k < n; ++k)
      left += std::pow(slow[k] - slow[k - 1], 2), changes += std::pow(measured[k][i] - measured[k - 1][i], 2);
    for (std::size_t k = 0; k < n; ++k) correction[k][i] = coefficient.dot(map(k)) + slow[k];
  }
  if (left > decisions::most_speed_left * changes) return;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t next = k + 1 < n && !flight.samples[k + 1].starts_segment ? k + 1 : k;
    const double interval_s = next > k ? flight.samples[next].time_s - flight.samples[k].time_s : flight.sample_s;
    for (std::size_t i = 0; i < rotors; ++i) {
      const double rise = correction[next][i] - correction[k][i];
      estimate.at_sample[k][i] += correction[k][i];
      for (std::size_t s = 0; s < count; ++s) {
        estimate.mean[k * count + s][i] +=
            correction[k][i] + rise * (static_cast<double>(s) + 0.5) / static_cast<double>(count);
        estimate.acceleration[k * count + s][i] += rise / interval_s;
      }
    }
  }
  flight.estimated = std::move(estimate);
}

double speed_latency_s(const std::vector<FlightData>& data, const std::vector<LinearFlight>& flights) {
  const double sample_s = data.front().sample_s;
  double least = std::numeric_limits<double>::infinity(), best_s = 0.0;
  for (double latency_s = 0.0; latency_s <= latest_s; latency_s += 0.25 * sample_s) {
    const auto whole = static_cast<std::size_t>(latency_s / sample_s);
    const double part = latency_s / sample_s - static_cast<double>(whole);
    double squares = 0.0;
    for (std::size_t f = 0; f < flights.size(); ++f) {
      const auto& predicted = flights[f].predicted;
      for (std::size_t k = static_cast<std::size_t>(latest_s / sample_s) + 3; k < predicted.size(); ++k)
        for (std::size_t i = 0; i < static_cast<std::size_t>(data[f].vehicle.rotor_count); ++i) {
          const auto change = [&](std::size_t at) { return predicted[at][i] - predicted[at - 1][i]; };
          const double measured = change(k) + flights[f].faster[k][i] - flights[f].faster[k - 1][i];
          squares += std::pow(measured - (1.0 - part) * change(k - whole) - part * change(k - whole - 1), 2);
        }
    }
    if (squares < least) least = squares, best_s = latency_s;
  }
  return best_s;
}

namespace {

double least_variance(const std::vector<FlightData>& data) {
  return std::pow(least_white_share * data.front().vehicle.hover_speed_radps(), 2);
}

}  // namespace

double speeds_left_radps(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                         const Eigen::VectorXd& value) {
  double squares = 0.0, rows = 0.0;
  for (const FlightData& data : flights) {
    LinearFlight flight;
    compare_speeds(data, 0, catalogue, value, flight);
    const Whitened w = whiten_speeds(data, flight, {0.0, 1.0, 1.0});
    for (Eigen::Index r = 0; r < w.rows.rows(); ++r)
      if (w.warm[static_cast<std::size_t>(r)]) squares += std::pow(w.rows(r, 0), 2), rows += 1.0;
  }
  return std::sqrt(squares / std::max(1.0, rows));
}

SpeedNoise white_speed_noise(const std::vector<FlightData>& data, const std::vector<LinearFlight>& flights) {
  double changes = 0.0, rows = 0.0;
  for (const LinearFlight& flight : flights)
    for (std::size_t k = 1; k < flight.faster.size(); ++k)
      for (std::size_t i = 0; i < static_cast<std::size_t>(data.front().vehicle.rotor_count); ++i)
        changes += std::pow(flight.faster[k][i] - flight.faster[k - 1][i], 2), rows += 1.0;
  const double least = least_variance(data);
  return rows > 0.0 ? SpeedNoise{0.1 * least, 0.1, std::max(0.5 * changes / rows, least)} : SpeedNoise{};
}

SpeedNoise likeliest(const std::vector<FlightData>& data, const std::vector<LinearFlight>& rest, SpeedNoise noise) {
  if (noise.white <= 0.0) return noise;
  const double least = least_variance(data), sample_s = data.front().sample_s;
  const auto misfit = [&](const SpeedNoise& trial) {
    double sum = 0.0;
    for (std::size_t f = 0; f < rest.size(); ++f)
      sum += whiten_speeds(data[f], rest[f], trial).minus_two_log_likelihood;
    return sum;
  };
  double now = misfit(noise);
  for (const double factor : {4.0, 2.0, 1.3})
    for (bool moved = true; moved;) {
      moved = false;
      for (double SpeedNoise::*part : {&SpeedNoise::variance, &SpeedNoise::time_s, &SpeedNoise::white})
        for (const double by : {factor, 1.0 / factor}) {
          SpeedNoise trial = noise;
          trial.*part *= by;
          if (trial.white < least || trial.variance < 0.1 * least || trial.time_s < 0.5 * sample_s ||
              trial.time_s > slowest_disturbance_s)
            continue;
          const double here = misfit(trial);
          if (here < now - 1.0) now = here, noise = trial, moved = true;
        }
    }
  return noise;
}

}  // namespace gustlab::diagnosis
