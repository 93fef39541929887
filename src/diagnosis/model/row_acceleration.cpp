#include "diagnosis/model/row_acceleration.hpp"

#include <algorithm>
#include <utility>

namespace gustlab::diagnosis {

namespace {

using Pairs = std::vector<std::pair<double, double>>;  // by the rotors, by the body's rates

AccelerationLeft left_of(const Pairs& pairs) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (const auto& [a, b] : pairs) x += a, y += b, xx += a * a, xy += a * b, yy += b * b;
  const double n = static_cast<double>(pairs.size());
  xx -= x * x / n, xy -= x * y / n, yy -= y * y / n;
  AccelerationLeft left{1.0, n};
  if (!(xx > 0.0 && yy > 0.0)) return left;
  left.share = 1.0 - xy * xy / (xx * yy);
  double before = 0.0, squares = 0.0, products = 0.0;
  for (const auto& [a, b] : pairs) {
    const double rest = b - y / n - xy / xx * (a - x / n);
    squares += rest * rest, products += rest * before;
    before = rest;
  }
  const double alike = std::max(0.0, products / std::max(squares, 1e-300));
  left.rows *= (1.0 - alike) / (1.0 + alike);
  return left;
}

}  // namespace

std::array<AccelerationLeft, 2> acceleration_left(const std::vector<FlightData>& flights,
                                                  const std::vector<std::vector<Eigen::Vector4d>>& rotors,
                                                  double kept) {
  Pairs roll, pitch;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const std::vector<Sample>& samples = flights[f].samples;
    Vector3 turned = Vector3::Zero(), pushed = Vector3::Zero();
    for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
      const Sample &now = samples[k], &next = samples[k + 1];
      if (next.starts_segment) turned.setZero(), pushed.setZero();
      if (!has_rates(now, next)) continue;
      turned = kept * turned + (next.body_rate_B_radps - now.body_rate_B_radps) / (next.time_s - now.time_s);
      pushed = kept * pushed + rotors[f][k].head<3>();
      roll.emplace_back(pushed.x(), turned.x());
      pitch.emplace_back(pushed.y(), turned.y());
    }
  }
  return {left_of(roll), left_of(pitch)};
}

}  // namespace gustlab::diagnosis
