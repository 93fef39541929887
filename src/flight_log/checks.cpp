#include "flight_log/checks.hpp"

#include <algorithm>
#include <cmath>

#include "gustlab/types.hpp"
#include "util/quantiles.hpp"

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

// Rows in which every one of some columns has a sample, and the usual step from one to the next.
struct Samples {
  std::vector<std::size_t> rows;
  double step_s = 0.0;
};

template <std::size_t n>
Samples samples_of(const std::vector<double>& time_s, const std::vector<double>* const (&columns)[n]) {
  Samples samples;
  for (std::size_t row = 0; row < time_s.size(); ++row) {
    double sum = 0.0;
    for (const auto* column : columns) sum += (*column)[row];
    if (!std::isnan(sum)) samples.rows.push_back(row);
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < samples.rows.size(); ++i)
    steps.push_back(time_s[samples.rows[i]] - time_s[samples.rows[i - 1]]);
  if (steps.empty()) return {};
  samples.step_s = median(std::move(steps));
  return samples;
}

// Attitude and body rate each have samples of their own, at their own rates.
class Judge {
 public:
  using Sums = AttitudeCheck::Sums;
  explicit Judge(const AttitudeColumns& columns)
      : columns_(columns), q_(samples_of(columns.time_s, columns.q)), w_(samples_of(columns.time_s, columns.w)) {}

  // first_row: where it shows first
  Sums judge(const Convention& convention, std::optional<std::size_t>& first_row) const {
    Sums result;
    if (q_.rows.empty() || w_.rows.empty()) return result;
    // a step may be next to nothing, and no window is longer than the log
    const auto length = static_cast<std::size_t>(
        std::clamp(std::round(window_s / q_.step_s), 1.0, static_cast<double>(q_.rows.size())));
    std::size_t before = 0;  // the last rate at or before the window's begin
    for (std::size_t k = 0; k + length < q_.rows.size(); k += length) {
      const std::size_t begin = q_.rows[k], end = q_.rows[k + length];
      while (before + 1 < w_.rows.size() && w_.rows[before + 1] <= begin) ++before;
      bool still = true, whole = true;
      for (std::size_t i = k; i < k + length; ++i) {
        whole = whole && time(q_.rows[i + 1]) - time(q_.rows[i]) < 3.0 * q_.step_s;
        still = still && attitude(q_.rows[i], convention).coeffs() == attitude(q_.rows[i + 1], convention).coeffs();
      }
      Quaternion turned;
      // an attitude that is held or frozen is another finding
      if (!whole || still || !integrate(before, begin, end, convention.rate_scale, turned)) continue;
      const Vector3 by_rate = turn_of(turned);
      const Vector3 by_attitude = turn_of(attitude(begin, convention).conjugate() * attitude(end, convention));
      const double turn = std::max(by_rate.norm(), by_attitude.norm());
      if (turn < least_turn_rad) continue;
      const double error = (by_rate - by_attitude).norm();
      ++result.windows;
      if (!first_row && error > too_much * turn) first_row = begin;
      result.wrong += error * error;
      result.all += turn * turn;
    }
    return result;
  }

 private:
  // The turn between two rows by the rate, linear between its samples, from sample number `first` on; false across a gap of it, or
  // where it begins later or ends earlier.
  bool integrate(std::size_t first, std::size_t begin, std::size_t end, double scale, Quaternion& turned) const {
    turned = Quaternion::Identity();
    if (w_.rows[first] > begin) return false;
    for (std::size_t i = first; w_.rows[i] < end; ++i) {
      if (i + 1 == w_.rows.size()) return false;
      const double from_s = time(w_.rows[i]), to_s = time(w_.rows[i + 1]);
      if (to_s - from_s >= 3.0 * w_.step_s) return false;
      const double a_s = std::max(from_s, time(begin)), b_s = std::min(to_s, time(end));
      const Vector3 a = rate_between(i, a_s), b = rate_between(i, b_s), half = 0.25 * (b_s - a_s) * scale * (a + b);
      turned = turned * Quaternion(1.0, half.x(), half.y(), half.z()).normalized();
    }
    return true;
  }
  // between samples i and i + 1
  Vector3 rate_between(std::size_t i, double time_s) const {
    const double from_s = time(w_.rows[i]), to_s = time(w_.rows[i + 1]);
    if (time_s <= from_s) return rate(w_.rows[i]);
    if (time_s >= to_s) return rate(w_.rows[i + 1]);
    const double share = (time_s - from_s) / (to_s - from_s);
    return (1.0 - share) * rate(w_.rows[i]) + share * rate(w_.rows[i + 1]);
  }
  double time(std::size_t row) const { return columns_.time_s[row]; }
  Vector3 rate(std::size_t row) const { return {(*columns_.w[0])[row], (*columns_.w[1])[row], (*columns_.w[2])[row]}; }
  Quaternion attitude(std::size_t row, const Convention& convention) const {
    double c[4];
    for (std::size_t i = 0; i < 4; ++i) c[i] = (*columns_.q[i])[row];
    const Quaternion q =
        convention.scalar_last ? Quaternion(c[3], c[0], c[1], c[2]) : Quaternion(c[0], c[1], c[2], c[3]);
    return convention.world_to_body ? q.conjugate() : q;
  }

  const AttitudeColumns& columns_;
  Samples q_, w_;
};

}  // namespace

void AttitudeCheck::Sums::add(const Sums& other) {
  wrong += other.wrong;
  all += other.all;
  windows += other.windows;
}

std::optional<std::size_t> AttitudeCheck::add(const AttitudeColumns& columns) {
  static_assert(std::size(gustlab::conventions) == conventions);
  const Judge judge(columns);
  std::optional<std::size_t> first_row, unused;
  const Sums as_read = judge.judge(gustlab::conventions[0], first_row);
  as_read_.add(as_read);
  if (as_read.windows > 0 && as_read.share() >= too_much)
    for (std::size_t i = 0; i < conventions; ++i)
      doubted_[i].add(i == 0 ? as_read : judge.judge(gustlab::conventions[i], unused));
  if (shown_ || !first_row) return std::nullopt;
  shown_ = true;
  return first_row;
}

bool AttitudeCheck::contradicts() const { return as_read_.windows >= least_windows && as_read_.share() >= too_much; }

std::string AttitudeCheck::suggestion() const {
  std::string says;
  double best = clearly_better * doubted_[0].share();
  for (std::size_t i = 0; i < conventions; ++i) {
    if (doubted_[i].windows < least_windows || doubted_[i].share() >= best) continue;
    best = doubted_[i].share();
    says = gustlab::conventions[i].says;
  }
  return says;
}

}  // namespace gustlab
