#include "flight_log/checks.hpp"

#include <algorithm>
#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

namespace {

constexpr double window_s = 0.2;
constexpr double least_turn_rad = 0.1;  // windows that turn less are noise
constexpr std::size_t least_windows = 10;
constexpr double too_much = 0.5;  // share of the turn that disagrees
constexpr double clearly_better = 0.2;

// one reading of the eight columns
struct Convention {
  const char* says;
  bool scalar_last, world_to_body;
  double rate_scale;
};
constexpr Convention conventions[] = {
    {"", false, false, 1.0},
    {"the quaternion looks scalar-last", true, false, 1.0},
    {"the quaternion looks world-to-body", false, true, 1.0},
    {"the quaternion looks scalar-last and world-to-body", true, true, 1.0},
    {"the body rate looks like degrees per second", false, false, pi / 180.0},
    {"the quaternion looks scalar-last and the body rate like degrees per second", true, false, pi / 180.0},
};

Vector3 turn_of(const Quaternion& q) {
  const Eigen::AngleAxisd turn(q.w() < 0.0 ? Quaternion(-q.coeffs()) : q);
  return turn.angle() * turn.axis();
}

struct Disagreement {
  double share = 0.0;
  std::size_t windows = 0;
  std::optional<std::size_t> first_row;
};

class Judge {
 public:
  explicit Judge(const AttitudeColumns& columns) : columns_(columns) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < columns.time_s.size(); ++i) steps.push_back(columns.time_s[i] - columns.time_s[i - 1]);
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    step_s_ = steps[steps.size() / 2];
  }

  Disagreement judge(const Convention& convention) const {
    Disagreement result;
    double wrong = 0.0, all = 0.0;
    const std::size_t rows = columns_.time_s.size();
    const auto length = static_cast<std::size_t>(std::max(1.0, std::round(window_s / step_s_)));
    for (std::size_t begin = 0; begin + length < rows; begin += length) {
      Quaternion turned = Quaternion::Identity();
      bool usable = complete(begin), still = true;
      for (std::size_t i = begin; i < begin + length && usable; ++i) {
        const double dt = columns_.time_s[i + 1] - columns_.time_s[i];
        usable = complete(i + 1) && dt < 3.0 * step_s_;
        const Vector3 half = 0.25 * dt * convention.rate_scale * (rate(i) + rate(i + 1));
        turned = turned * Quaternion(1.0, half.x(), half.y(), half.z()).normalized();
        still = still && attitude(i, convention).coeffs() == attitude(i + 1, convention).coeffs();
      }
      // an attitude that is held or frozen is another finding
      if (!usable || still) continue;
      const Vector3 by_rate = turn_of(turned);
      const Vector3 by_attitude =
          turn_of(attitude(begin, convention).conjugate() * attitude(begin + length, convention));
      const double turn = std::max(by_rate.norm(), by_attitude.norm());
      if (turn < least_turn_rad) continue;
      const double error = (by_rate - by_attitude).norm();
      ++result.windows;
      if (!result.first_row && error > too_much * turn) result.first_row = begin;
      wrong += error * error;
      all += turn * turn;
    }
    result.share = all > 0.0 ? wrong / all : 0.0;
    return result;
  }

 private:
  bool complete(std::size_t row) const {
    double sum = 0.0;
    for (const auto* column : columns_.q) sum += (*column)[row];
    for (const auto* column : columns_.w) sum += (*column)[row];
    return !std::isnan(sum);
  }
  Vector3 rate(std::size_t row) const { return {(*columns_.w[0])[row], (*columns_.w[1])[row], (*columns_.w[2])[row]}; }
  Quaternion attitude(std::size_t row, const Convention& convention) const {
    double c[4];
    for (std::size_t i = 0; i < 4; ++i) c[i] = (*columns_.q[i])[row];
    const Quaternion q =
        convention.scalar_last ? Quaternion(c[3], c[0], c[1], c[2]) : Quaternion(c[0], c[1], c[2], c[3]);
    return convention.world_to_body ? q.conjugate() : q;
  }

  const AttitudeColumns& columns_;
  double step_s_ = 0.0;
};

}  // namespace

std::optional<Contradiction> find_contradiction(const AttitudeColumns& columns) {
  const Judge judge(columns);
  const Disagreement as_read = judge.judge(conventions[0]);
  if (as_read.windows < least_windows || as_read.share < too_much) return std::nullopt;
  Contradiction found{as_read.first_row.value_or(0), ""};
  double best = clearly_better * as_read.share;
  for (const Convention& convention : conventions) {
    const Disagreement other = judge.judge(convention);
    if (other.windows < least_windows || other.share >= best) continue;
    best = other.share;
    found.suggestion = convention.says;
  }
  return found;
}

}  // namespace gustlab
