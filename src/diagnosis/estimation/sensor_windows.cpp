#include "diagnosis/estimation/sensor_windows.hpp"

#include <algorithm>
#include <cmath>

#include "util/rotations.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double turn_s = 0.2, way_s = 0.15;  // from an attitude to the next; half of what positions span
constexpr double longest_share = 1.5;         // of those, at most
constexpr double longest_gap_s = 0.03;        // between inertial samples
constexpr int clustered = 10;                 // windows

// What a flight's sensors have in place of the file's.
struct SensorState {
  SensorCorrection corrects;
  Vector3 lever_B_m = Vector3::Zero(), force_bias_B_mps2 = Vector3::Zero();
};

bool is_lever(const EffectRow& row) { return row.place == Place::measurement && row.asks(Need::accelerometer); }

SensorState state_of(const Catalogue& catalogue, const Eigen::VectorXd& value, int flight) {
  SensorState state{catalogue.sensor_correction(value, flight)};
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    if (column.group < 0 && column.flight == flight && column.parameter >= force_bias && column.parameter < torque_trim)
      state.force_bias_B_mps2[column.parameter - force_bias] = value[c];
    if (column.group >= 0 && is_lever(*catalogue.group(column.group).row)) state.lever_B_m[column.parameter] = value[c];
  }
  return state;
}

bool is_of_sensors(const Catalogue& catalogue, const Column& column, int flight) {
  if (column.flight >= 0 && column.flight != flight) return false;
  if (column.group < 0) return column.parameter < torque_trim;
  const EffectRow& row = *catalogue.group(column.group).row;
  return row.place == Place::measurement &&
         (row.corrects != Corrects::nothing || row.latency == Latency::delay || is_lever(row));
}

struct Stream {
  std::vector<double> time_s;
  std::vector<const Sample*> sample;
  // sample before a time that is not the last
  std::size_t before(double t) const {
    const auto next = std::upper_bound(time_s.begin(), time_s.end(), t);
    return std::clamp<std::size_t>(static_cast<std::size_t>(next - time_s.begin()), 1, time_s.size() - 1) - 1;
  }
  bool whole(double from_s, double to_s) const {
    if (time_s.size() < 2 || from_s < time_s.front() || to_s > time_s.back()) return false;
    for (std::size_t k = before(from_s); k + 1 < time_s.size() && time_s[k] < to_s; ++k)
      if (time_s[k + 1] - time_s[k] > longest_gap_s) return false;
    return true;
  }
};

Stream stream_of(const FlightData& flight, unsigned channel, double late_s) {
  Stream stream;
  for (const Sample& sample : flight.samples)
    if (sample.channels & channel) stream.time_s.push_back(sample.time_s - late_s), stream.sample.push_back(&sample);
  return stream;
}

// Residuals of one flight's windows with some sensors; a pose that is late belongs to an earlier time of the inertial data.
class Comparison {
 public:
  explicit Comparison(const FlightData& flight)
      : gyro_(stream_of(flight, has_rate, flight.late.rate_s)),
        force_(stream_of(flight, has_force, flight.late.force_s)),
        attitude_(stream_of(flight, has_attitude, 0.0)),
        position_(stream_of(flight, has_position, 0.0)),
        gravity_mps2_(flight.vehicle.gravity_mps2) {}

  // first and last sample of every window; of positions the middle one as well
  std::vector<std::array<std::size_t, 2>> turns() const {
    std::vector<std::array<std::size_t, 2>> windows;
    if (gyro_.time_s.size() < 2 || attitude_.time_s.size() < 2) return windows;
    for (std::size_t i = 0, j; (j = after(attitude_, i, turn_s)) < attitude_.time_s.size(); i = j)
      if (near(attitude_, i, j, turn_s) && gyro_.whole(attitude_.time_s[i] - margin_s, attitude_.time_s[j] + margin_s))
        windows.push_back({i, j});
    return windows;
  }
  std::vector<std::array<std::size_t, 3>> ways() const {
    std::vector<std::array<std::size_t, 3>> windows;
    if (force_.time_s.size() < 2 || attitude_.time_s.size() < 2 || position_.time_s.size() < 2) return windows;
    for (std::size_t i = 0, j, k;
         (k = after(position_, j = after(position_, i, way_s), way_s)) < position_.time_s.size(); i = k)
      if (near(position_, i, j, way_s) && near(position_, j, k, way_s) &&
          force_.whole(position_.time_s[i] - margin_s, position_.time_s[k] + margin_s))
        windows.push_back({i, j, k});
    return windows;
  }
  double begins_s(const std::array<std::size_t, 2>& w) const { return attitude_.time_s[w[0]]; }
  double begins_s(const std::array<std::size_t, 3>& w) const { return position_.time_s[w[0]]; }

  // attitude that the gyroscope leads to, to the one that was logged
  Vector3 residual(const std::array<std::size_t, 2>& w, const SensorState& state) const {
    const SensorCorrection& c = state.corrects;
    Quaternion q = attitude(w[0], state);
    const double from_s = attitude_.time_s[w[0]] - c.pose_delay_s, to_s = attitude_.time_s[w[1]] - c.pose_delay_s;
    double t = from_s;
    Vector3 rate = rate_at(t, c);
    for (std::size_t k = gyro_.before(from_s) + 1; t < to_s; ++k) {
      const double next_s = k < gyro_.time_s.size() ? std::min(gyro_.time_s[k], to_s) : to_s;
      if (next_s <= t) continue;
      const Vector3 next = rate_at(next_s, c);
      q = turned(q, 0.5 * (next_s - t) * (rate + next));
      t = next_s, rate = next;
    }
    return turn_between(q, attitude(w[1], state));
  }

  // Change of the mean velocity beyond what the accelerometer felt: its integral, weighted by a triangle. Where the accelerometer is,
  // the vehicle's origin has moved with its turning.
  Vector3 residual(const std::array<std::size_t, 3>& w, const SensorState& state) const {
    std::array<Vector3, 3> at;
    std::array<double, 3> t;
    for (std::size_t i = 0; i < 3; ++i) {
      const Sample& sample = *position_.sample[w[i]];
      at[i] = sample.position_W_m + attitude_at(sample.time_s, state) * state.lever_B_m;
      t[i] = sample.time_s - state.corrects.pose_delay_s;
    }
    Vector3 felt = Vector3::Zero();
    const auto weighted = [&](double when_s) {
      const double weight = when_s < t[1] ? (when_s - t[0]) / (t[1] - t[0]) : (t[2] - when_s) / (t[2] - t[1]);
      return Vector3(std::max(0.0, weight) * (attitude_at(when_s + state.corrects.pose_delay_s, state) *
                                              (force_at(when_s) - state.force_bias_B_mps2)));
    };
    double when_s = t[0];
    Vector3 now = weighted(when_s);
    for (std::size_t k = force_.before(t[0]) + 1; when_s < t[2]; ++k) {
      const double next_s = k < force_.time_s.size() ? std::min(force_.time_s[k], t[2]) : t[2];
      if (next_s <= when_s) continue;
      const Vector3 next = weighted(next_s);
      felt += 0.5 * (next_s - when_s) * (now + next);
      when_s = next_s, now = next;
    }
    return (at[2] - at[1]) / (t[2] - t[1]) - (at[1] - at[0]) / (t[1] - t[0]) - felt +
           0.5 * (t[2] - t[0]) * gravity_mps2_ * Vector3::UnitZ();
  }

 private:
  static constexpr double margin_s = 0.02;  // for poses that are late

  static std::size_t after(const Stream& stream, std::size_t i, double by_s) {
    if (i >= stream.time_s.size()) return i;
    return static_cast<std::size_t>(
        std::lower_bound(stream.time_s.begin(), stream.time_s.end(), stream.time_s[i] + by_s - 1e-6) -
        stream.time_s.begin());
  }
  static bool near(const Stream& stream, std::size_t i, std::size_t j, double by_s) {
    return stream.time_s[j] - stream.time_s[i] <= longest_share * by_s;
  }
  Quaternion attitude(std::size_t i, const SensorState& state) const {
    return turned(attitude_.sample[i]->attitude_WB, -state.corrects.attitude_offset_B_rad);
  }
  Quaternion attitude_at(double logged_s, const SensorState& state) const {
    const std::size_t i = attitude_.before(logged_s);
    const double part = (logged_s - attitude_.time_s[i]) / (attitude_.time_s[i + 1] - attitude_.time_s[i]);
    return attitude(i, state).slerp(std::clamp(part, 0.0, 1.0), attitude(i + 1, state));
  }
  static Vector3 between(const Stream& stream, double t, Vector3 Sample::*what) {
    const std::size_t i = stream.before(t);
    const double part = std::clamp((t - stream.time_s[i]) / (stream.time_s[i + 1] - stream.time_s[i]), 0.0, 1.0);
    return (1.0 - part) * (stream.sample[i]->*what) + part * (stream.sample[i + 1]->*what);
  }
  Vector3 rate_at(double t, const SensorCorrection& c) const {
    return (between(gyro_, t, &Sample::body_rate_B_radps) - c.rate_bias_B_radps) / (1.0 + c.rate_scale);
  }
  Vector3 force_at(double t) const { return between(force_, t, &Sample::specific_force_B_mps2); }

  Stream gyro_, force_, attitude_, position_;
  double gravity_mps2_;
};

// y and what columns change of it, about the vehicle file's sensors: their numbers are small
template <class Window>
void compare(const Comparison& comparison, const std::vector<Window>& windows, Beside beside,
             const Catalogue& catalogue, int flight, SensorWindows& out) {
  const Eigen::VectorXd nominal = catalogue.nominal();
  const SensorState file = state_of(catalogue, nominal, flight);
  std::vector<SensorState> moved;
  constexpr double share = 0.1;  // of a natural size
  for (const int c : out.columns) {
    Eigen::VectorXd value = nominal;
    value[c] += share * catalogue.column(c).natural;
    moved.push_back(state_of(catalogue, value, flight));
  }
  for (const Window& w : windows) {
    SensorWindow& row = out.window.emplace_back(SensorWindow{
        beside, comparison.begins_s(w), comparison.residual(w, file), Eigen::Matrix3Xd(3, std::ssize(moved))});
    for (std::size_t j = 0; j < moved.size(); ++j)
      row.by.col(static_cast<Eigen::Index>(j)) = (row.y - comparison.residual(w, moved[j])) / share;
  }
}

Vector3 at_value(const SensorWindows& windows, const SensorWindow& window, const Catalogue& catalogue,
                 const Eigen::VectorXd& value) {
  Vector3 y = window.y;
  for (std::size_t j = 0; j < windows.columns.size(); ++j) {
    const int c = windows.columns[j];
    const Column& column = catalogue.column(c);
    y -= window.by.col(static_cast<Eigen::Index>(j)) * ((value[c] - column.nominal) / column.natural);
  }
  return y;
}

}  // namespace

SensorWindows sensor_windows(const FlightData& flight, int flight_index, const Catalogue& catalogue) {
  SensorWindows out;
  if (!flight.sensors) return out;
  for (int c = 0; c < catalogue.size(); ++c)
    if (is_of_sensors(catalogue, catalogue.column(c), flight_index)) out.columns.push_back(c);
  const Comparison comparison(*flight.sensors);
  compare(comparison, comparison.turns(), Beside::gyro, catalogue, flight_index, out);
  compare(comparison, comparison.ways(), Beside::accelerometer, catalogue, flight_index, out);
  std::ranges::stable_sort(out.window, {}, &SensorWindow::time_s);
  return out;
}

Whitened whiten_sensor_windows(const SensorWindows& windows, const std::vector<int>& columns,
                               const Catalogue& catalogue, const Eigen::VectorXd& value,
                               const SensorWindowVariance& variance) {
  Whitened out;
  out.rows.setZero(3 * std::ssize(windows.window), std::ssize(columns) + 1);
  Eigen::Index row = 0;
  for (const SensorWindow& window : windows.window) {
    const auto kind = static_cast<std::size_t>(window.beside);
    if (!(variance[kind] > 0.0)) continue;
    const double sd = std::sqrt(variance[kind]);
    auto rows = out.rows.middleRows<3>(row);
    for (std::size_t j = 0; j < windows.columns.size(); ++j)
      if (const auto to = std::ranges::find(columns, windows.columns[j]); to != columns.end())
        rows.col(to - columns.begin()) = window.by.col(static_cast<Eigen::Index>(j)) / sd;
    rows.col(std::ssize(columns)) = at_value(windows, window, catalogue, value) / sd;
    for (int axis = 0; axis < 3; ++axis, ++row) {
      out.time_s.push_back(window.time_s);
      out.channel.push_back(3 * static_cast<int>(kind) + axis);
      out.warm.push_back(true);
    }
  }
  out.rows.conservativeResize(row, Eigen::NoChange);
  return out;
}

SensorWindowVariance sensor_window_variance(const std::vector<SensorWindows>& flights, const Catalogue& catalogue,
                                            const Eigen::VectorXd& value) {
  SensorWindowVariance variance{};
  for (const Beside beside : {Beside::gyro, Beside::accelerometer}) {
    double squares = 0.0, of_sums = 0.0, count = 0.0;
    for (const SensorWindows& windows : flights) {
      Vector3 sum = Vector3::Zero();
      int together = 0;
      for (const SensorWindow& window : windows.window) {
        if (window.beside != beside) continue;
        const Vector3 left = at_value(windows, window, catalogue, value);
        squares += left.squaredNorm(), count += 3.0;
        sum += left;
        if (++together == clustered) of_sums += sum.squaredNorm(), sum.setZero(), together = 0;
      }
      of_sums += sum.squaredNorm();
    }
    if (count > 0.0) variance[static_cast<std::size_t>(beside)] = std::max(squares, of_sums) / count;
  }
  return variance;
}

}  // namespace gustlab::diagnosis
