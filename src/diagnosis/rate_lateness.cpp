#include "diagnosis/rate_lateness.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/recorded_motion.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double window_s = 0.1;
constexpr double surely = 5.0;                      // standard errors
constexpr double least_s = 0.0005, most_s = 0.02;   // a filter's

}  // namespace

double rate_lateness_s(const std::vector<FlightData>& flights) {
  // sums of x², x y and y² about each flight's means, which hold the gyro's biases; x: change of the rate, y: turn that the gyro misses
  double xx = 0.0, xy = 0.0, yy = 0.0, count = 0.0;
  for (const FlightData& flight : flights) {
    const auto length = static_cast<std::size_t>(std::max(1.0, std::round(window_s / flight.sample_s)));
    std::vector<Vector3> x, y;
    for (std::size_t first = 0; first + length < flight.samples.size(); first += length) {
      Quaternion by_gyro = flight.samples[first].attitude_WB;
      bool whole = true;
      for (std::size_t k = first; k <= first + length; ++k) {
        const Sample& now = flight.samples[k];
        whole = whole && (now.channels & has_rate) && (k == first || !now.starts_segment);
        if (k == first) continue;
        const Sample& before = flight.samples[k - 1];
        by_gyro = turned(by_gyro, 0.5 * (now.time_s - before.time_s) * (before.body_rate_B_radps + now.body_rate_B_radps));
      }
      const Sample &from = flight.samples[first], &to = flight.samples[first + length];
      if (!whole || !(from.channels & to.channels & has_attitude)) continue;
      x.push_back(to.body_rate_B_radps - to.attitude_WB.conjugate() * (from.attitude_WB * from.body_rate_B_radps));
      y.push_back(turn_between(by_gyro, to.attitude_WB));
    }
    if (x.size() < 2) continue;
    Vector3 mean_x = Vector3::Zero(), mean_y = Vector3::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) mean_x += x[i] / static_cast<double>(x.size()), mean_y += y[i] / static_cast<double>(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      xx += (x[i] - mean_x).squaredNorm();
      xy += (x[i] - mean_x).dot(y[i] - mean_y);
      yy += (y[i] - mean_y).squaredNorm();
      count += 3.0;
    }
  }
  if (xx <= 0.0) return 0.0;
  const double late_s = xy / xx, deviation_s = std::sqrt(std::max(0.0, yy / xx - late_s * late_s) / count);
  return late_s > std::max(least_s, surely * deviation_s) && late_s < most_s ? late_s : 0.0;
}

}  // namespace gustlab::diagnosis
