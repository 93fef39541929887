#include "diagnosis/recording/sensor_latency.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/recording/recorded_motion.hpp"
#include "util/rotations.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double turn_s = 0.1, way_s = 0.2;        // windows of attitudes and of positions
constexpr double surely = 5.0, possibly = 2.0;     // standard errors
constexpr double least_s = 0.0005, most_s = 0.02;  // a filter's

// y = d x, about each flight's means, which hold the sensor's biases, and beside what would add any share of `scaled` to y: a scale of the sensor, or turns
// between rows
struct Window {
  Vector3 x = Vector3::Zero(), y = Vector3::Zero(), scaled = Vector3::Zero();
};

class Latency {
 public:
  void add(std::vector<Window> flight) {
    if (flight.size() < 2) return;
    for (const auto part : {&Window::x, &Window::y, &Window::scaled}) {
      Vector3 mean = Vector3::Zero();
      for (const Window& w : flight) mean += w.*part / static_cast<double>(flight.size());
      for (Window& w : flight) w.*part -= mean;
    }
    double ss = 0.0;
    for (const Window& w : flight) ss += w.scaled.squaredNorm();
    for (const auto part : {&Window::x, &Window::y}) {
      double along = 0.0;
      for (const Window& w : flight) along += w.scaled.dot(w.*part);
      for (Window& w : flight)
        if (ss > 0.0) w.*part -= along / ss * w.scaled;
    }
    for (const Window& w : flight) {
      xx_ += w.x.squaredNorm(), xy_ += w.x.dot(w.y), yy_ += w.y.squaredNorm();
      count_ += 3.0;
    }
  }
  bool sure(double latency_s) const {
    return xx_ > 0.0 && std::abs(xy_ / xx_ - latency_s) > surely * standard_error_s();
  }
  // what it is when it is sure not to be `expected_s`
  double seconds(double expected_s) const {
    if (!sure(expected_s)) return expected_s;
    const double latency_s = xy_ / xx_;
    return sure(0.0) && latency_s > least_s && latency_s < most_s ? latency_s : 0.0;
  }
  // by how much the other one may be later
  std::optional<double> earlier_at_most_s() const {
    if (xx_ == 0.0) return std::nullopt;
    return std::max(0.0, possibly * standard_error_s() - xy_ / xx_);
  }

 private:
  double standard_error_s() const { return std::sqrt(std::max(0.0, yy_ / xx_ - std::pow(xy_ / xx_, 2)) / count_); }
  double xx_ = 0.0, xy_ = 0.0, yy_ = 0.0, count_ = 0.0;
};

// first samples of windows of so many intervals, without a gap, with the sensor in every sample and the pose at both ends
std::vector<std::size_t> whole_windows(const FlightData& flight, std::size_t length, unsigned sensor, unsigned pose) {
  std::vector<std::size_t> windows;
  for (std::size_t first = 0; first + length < flight.samples.size(); first += length) {
    bool whole = (flight.samples[first].channels & flight.samples[first + length].channels & pose) == pose;
    for (std::size_t k = first; k <= first + length; ++k)
      whole =
          whole && (flight.samples[k].channels & sensor) == sensor && (k == first || !flight.samples[k].starts_segment);
    if (whole) windows.push_back(first);
  }
  return windows;
}

std::size_t samples_in(const FlightData& flight, double duration_s) {
  return static_cast<std::size_t>(std::max(1.0, std::round(duration_s / flight.sample_s)));
}

// of the gyro behind the attitudes
Latency rate_latency(const std::vector<FlightData>& flights, const std::vector<std::vector<Vector3>>& further = {}) {
  Latency latency;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const FlightData& flight = flights[f];
    const std::size_t length = samples_in(flight, turn_s);
    std::vector<Window> windows;
    for (const std::size_t first : whole_windows(flight, length, has_rate, has_attitude)) {
      const Sample &from = flight.samples[first], &to = flight.samples[first + length];
      Quaternion by_gyro = from.attitude_WB;
      for (std::size_t k = first + 1; k <= first + length; ++k) {
        const Sample &before = flight.samples[k - 1], &now = flight.samples[k];
        by_gyro =
            turned(by_gyro, 0.5 * (now.time_s - before.time_s) * (before.body_rate_B_radps + now.body_rate_B_radps));
      }
      Vector3 turns = Vector3::Zero();
      for (std::size_t k = first; k < first + length && !further.empty(); ++k) turns += further[f][k];
      windows.push_back(
          {to.body_rate_B_radps - to.attitude_WB.conjugate() * (from.attitude_WB * from.body_rate_B_radps),
           turn_between(by_gyro, to.attitude_WB), turns});
    }
    latency.add(std::move(windows));
  }
  return latency;
}

}  // namespace

SensorLatency sensor_latency(const std::vector<FlightData>& flights, const std::vector<std::vector<Vector3>>& further) {
  const double rate_s = rate_latency_s(flights, further);
  return {rate_s, force_latency_s(flights, rate_s)};
}

double rate_latency_s(const std::vector<FlightData>& flights, const std::vector<std::vector<Vector3>>& further) {
  return rate_latency(flights, further).seconds(0.0);
}

std::optional<double> most_pose_latency_s(const std::vector<FlightData>& flights) {
  return rate_latency(flights).earlier_at_most_s();
}

bool steps_velocities_first(const std::vector<FlightData>& as_recorded, double rate_s) {
  Latency latency;
  bool recorded = false;
  for (const FlightData& flight : as_recorded) {
    const std::size_t length = samples_in(flight, turn_s);
    std::vector<Window> windows;
    for (const std::size_t first : whole_windows(flight, length, has_velocity, has_position)) {
      recorded = true;
      const Sample &from = flight.samples[first], &to = flight.samples[first + length];
      Window w;
      w.x = to.velocity_W_mps - from.velocity_W_mps;
      w.y = to.position_W_m - from.position_W_m;
      for (std::size_t k = first + 1; k <= first + length; ++k) {
        const Sample &before = flight.samples[k - 1], &now = flight.samples[k];
        w.y -= 0.5 * (now.time_s - before.time_s) * (before.velocity_W_mps + now.velocity_W_mps);
      }
      windows.push_back(w);
    }
    latency.add(std::move(windows));
  }
  return recorded && latency.seconds(rate_s) >= 0.5 * rate_s;
}

double force_latency_s(const std::vector<FlightData>& flights, double rate_s) {
  Latency latency;
  bool recorded = false;
  for (const FlightData& flight : flights) {
    for (const Sample& sample : flight.samples) recorded = recorded || (sample.channels & has_force);
    const std::size_t half = samples_in(flight, 0.5 * way_s);
    std::vector<Window> windows;
    for (const std::size_t first : whole_windows(flight, 2 * half, has_force | has_attitude | has_rate, has_position)) {
      const Sample& middle = flight.samples[first + half];
      if (!(middle.channels & has_position)) continue;
      Window w;
      // a second difference is the acceleration weighed by a triangle; x is what changes in B, weighed alike, by parts
      for (std::size_t k = first; k <= first + 2 * half; ++k) {
        const Sample& sample = flight.samples[k];
        const Vector3 force = sample.attitude_WB * sample.specific_force_B_mps2;
        const Vector3 turns = sample.attitude_WB * sample.body_rate_B_radps.cross(sample.specific_force_B_mps2);
        const double weight_s = (k == first || k == first + 2 * half ? 0.5 : 1.0) * flight.sample_s;
        const double triangle_s = static_cast<double>(half) * flight.sample_s - std::abs(sample.time_s - middle.time_s);
        w.scaled += weight_s * triangle_s * force;
        w.x -= weight_s * triangle_s * turns;
        if (k != first + half) w.x += (k > first + half ? weight_s : -weight_s) * force;
      }
      w.y = flight.samples[first].position_W_m - 2.0 * middle.position_W_m +
            flight.samples[first + 2 * half].position_W_m - w.scaled;
      windows.push_back(w);
    }
    latency.add(std::move(windows));
  }
  return recorded ? latency.seconds(rate_s) : 0.0;
}

}  // namespace gustlab::diagnosis
