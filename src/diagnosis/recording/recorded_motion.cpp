#include "diagnosis/recording/recorded_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/recording/flight_data.hpp"
#include "gustlab/errors.hpp"
#include "util/quantiles.hpp"
#include "util/rotations.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double slope_window_s = 0.15;

std::vector<Vector3> triple(const FlightLog& log, const std::array<const char*, 3>& names) {
  const auto *x = log.find(names[0]), *y = log.find(names[1]), *z = log.find(names[2]);
  std::vector<Vector3> result;
  if (!x || !y || !z) return result;
  for (std::size_t row = 0; row < log.rows(); ++row) result.emplace_back((*x)[row], (*y)[row], (*z)[row]);
  return result;
}

// White noise per axis, from what a parabola through three of four neighbouring samples says of the other one (robust): with even
// intervals third differences. at(row, of): sample `row` as seen from sample `of`.
template <class At>
double white_noise(const std::vector<double>& time_s, At at) {
  std::array<std::vector<double>, 3> left;
  for (std::size_t row = 3; row < time_s.size(); ++row) {
    Vector3 sum = Vector3::Zero();
    double square = 0.0;
    for (std::size_t i = row - 3; i <= row; ++i) {
      double weight = 1.0;
      for (std::size_t j = row - 3; j <= row; ++j)
        if (j != i) weight /= time_s[i] - time_s[j];
      sum += weight * at(i, row);
      square += weight * weight;
    }
    sum /= std::sqrt(square);
    if (!sum.allFinite()) continue;
    for (Eigen::Index axis = 0; axis < 3; ++axis) left[static_cast<std::size_t>(axis)].push_back(std::abs(sum[axis]));
  }
  double square = 0.0;
  for (std::vector<double>& axis : left) square += std::pow(median(std::move(axis)) / 0.6745, 2) / 3.0;
  return std::sqrt(square);
}

// samples of one column: the rows that hold one, and how far apart they usually are
struct Samples {
  const std::vector<double>* column = nullptr;
  std::vector<std::size_t> rows;
  double step_s = 0.0;
};

Samples samples_of(const std::vector<double>& time_s, const std::vector<double>& column) {
  Samples found{&column, {}, 0.0};
  std::vector<double> steps;
  for (std::size_t row = 0; row < column.size(); ++row) {
    if (!std::isfinite(column[row])) continue;
    if (!found.rows.empty()) steps.push_back(time_s[row] - time_s[found.rows.back()]);
    found.rows.push_back(row);
  }
  found.step_s = median(std::move(steps));
  return found;
}

// a column at other rows, between its neighbours; none where these are farther apart than its samples usually are
std::vector<double> between_neighbours(const std::vector<double>& time_s, const Samples& samples,
                                       const std::vector<std::size_t>& rows) {
  constexpr double least_farthest_s = 0.05;
  const double farthest_s = std::max(least_farthest_s, 1.6 * samples.step_s);
  std::vector<double> result;
  for (const std::size_t row : rows) {
    const auto after = std::lower_bound(samples.rows.begin(), samples.rows.end(), row);
    if (after != samples.rows.end() && *after == row) {
      result.push_back((*samples.column)[row]);
    } else if (after == samples.rows.begin() || after == samples.rows.end() ||
               time_s[*after] - time_s[*(after - 1)] > farthest_s) {
      result.push_back(std::nan(""));
    } else {
      const std::size_t before = *(after - 1);
      const double part = (time_s[row] - time_s[before]) / (time_s[*after] - time_s[before]);
      result.push_back((*samples.column)[before] + part * ((*samples.column)[*after] - (*samples.column)[before]));
    }
  }
  return result;
}

// q and -q are one attitude: of neighbouring samples the same sign is taken, so that there is something between them
void make_continuous(FlightLog& log) {
  std::array<std::vector<double>*, 4> q{};
  constexpr const char* names[] = {"qw", "qx", "qy", "qz"};
  for (std::size_t i = 0; i < q.size(); ++i)
    for (LogColumn& column : log.columns)
      if (column.name == names[i]) q[i] = &column.values;
  if (std::find(q.begin(), q.end(), nullptr) != q.end()) return;
  std::array<double, 4> last{};
  for (std::size_t row = 0; row < log.rows(); ++row) {
    double dot = 0.0;
    for (std::size_t i = 0; i < q.size(); ++i) dot += (*q[i])[row] * last[i];
    if (std::isnan(dot)) continue;
    for (std::size_t i = 0; i < q.size(); ++i) last[i] = dot < 0.0 ? (*q[i])[row] *= -1.0 : (*q[i])[row];
  }
}

}  // namespace

FlightLog with_shared_rows(const FlightLog& log) {
  std::vector<Samples> motion;
  for (const char* name : {"px", "vx", "qw", "wx"})
    if (const auto* column = log.find(name)) motion.push_back(samples_of(log.time_s, *column));
  std::erase_if(motion, [](const Samples& s) { return s.rows.empty(); });
  const auto fewer = [](const Samples& a, const Samples& b) { return a.rows.size() < b.rows.size(); };
  const auto slowest = std::min_element(motion.begin(), motion.end(), fewer);
  if (motion.empty() || slowest->rows.size() == log.rows()) return log;

  FlightLog continuous = log;
  make_continuous(continuous);
  FlightLog merged = continuous;
  merged.time_s.clear();
  const std::vector<std::size_t>& rows = slowest->rows;
  for (const std::size_t row : rows) merged.time_s.push_back(log.time_s[row]);
  for (std::size_t c = 0; c < log.columns.size(); ++c)
    merged.columns[c].values =
        between_neighbours(log.time_s, samples_of(log.time_s, continuous.columns[c].values), rows);
  return merged;
}

RecordedMotion::RecordedMotion(const FlightLog& log)
    : time_s_(log.time_s),
      position_(triple(log, {"px", "py", "pz"})),
      velocity_(triple(log, {"vx", "vy", "vz"})),
      rate_(triple(log, {"wx", "wy", "wz"})),
      complete_(log.rows(), true),
      stretch_(log.rows(), 0) {
  const std::vector<Vector3> vector_part = triple(log, {"qx", "qy", "qz"});
  const auto* scalar = log.find("qw");
  if (vector_part.empty() || !scalar)
    throw DataError(
        fmt::format("{}: cannot be replayed (a rollout starts from an attitude, and the log has none)", log.path));
  std::vector<double> steps;
  for (std::size_t row = 0; row < rows(); ++row) {
    const Vector3& v = vector_part[row];
    Quaternion q((*scalar)[row], v.x(), v.y(), v.z());
    complete_[row] = q.coeffs().allFinite();
    for (const auto* channel : {&position_, &velocity_, &rate_})
      if (!channel->empty()) complete_[row] = complete_[row] && (*channel)[row].allFinite();
    attitude_.push_back(q.normalized());
    if (row > 0) steps.push_back(time_s_[row] - time_s_[row - 1]);
  }
  sample_s_ = median(std::move(steps));
  for (std::size_t row = 1; row < rows(); ++row)
    stretch_[row] = follows(row - 1) && complete_[row - 1] ? stretch_[row - 1] : row;

  const auto noise_of = [&](const std::vector<Vector3>& series) {
    return series.empty() ? 0.0 : white_noise(time_s_, [&](std::size_t k, std::size_t) { return series[k]; });
  };
  const double attitude_noise =
      white_noise(time_s_, [&](std::size_t k, std::size_t of) { return turn_between(attitude_[of], attitude_[k]); });
  noise_ = {noise_of(position_), noise_of(velocity_), attitude_noise, noise_of(rate_)};
  if ((!has_position() || has_velocity()) && has_body_rate()) return;
  for (std::size_t row = 0; row < rows(); ++row)
    noise_gain_.push_back(slope(row, [](std::size_t) { return Vector3::Zero(); }).noise_gain);
  usual_gain_ = median(noise_gain_);
  if (!has_velocity()) noise_[1] = usual_gain_ * noise_[0];
  if (!has_body_rate()) noise_[3] = usual_gain_ * noise_[2];
}

std::size_t RecordedMotion::nearest(double time_s) const {
  const double wanted = time_s + time_s_.front();
  const auto after =
      static_cast<std::size_t>(std::lower_bound(time_s_.begin(), time_s_.end(), wanted) - time_s_.begin());
  if (after == 0) return 0;
  if (after == rows()) return rows() - 1;
  return wanted - time_s_[after - 1] <= time_s_[after] - wanted ? after - 1 : after;
}

// least-squares parabola through the samples of the last stretch of time; its slope at the row
template <class Value>
RecordedMotion::Slope RecordedMotion::slope(std::size_t row, Value value) const {
  std::size_t first = row;
  while (first > stretch_[row] && (row - first < 2 || time_s_[row] - time_s_[first - 1] <= slope_window_s)) --first;
  Slope result;
  if (first == row) return result;
  const bool line = row - first < 2;
  Matrix3 gram = Matrix3::Zero();
  Matrix3 right = Matrix3::Zero();
  for (std::size_t k = first; k <= row; ++k) {
    const double s = (time_s_[k] - time_s_[row]) / slope_window_s;
    const Vector3 powers(1.0, s, line ? 0.0 : s * s);
    gram += powers * powers.transpose();
    right += powers * value(k).transpose();
  }
  if (line) gram(2, 2) = 1.0;
  const Matrix3 inverse = gram.inverse();
  result.value = (inverse * right).row(1).transpose() / slope_window_s;
  result.noise_gain = std::sqrt(inverse(1, 1)) / slope_window_s;
  return result;
}

bool RecordedMotion::can_start(std::size_t row) const {
  constexpr double most_gain = 2.0;  // of the usual
  return complete_[row] && (noise_gain_.empty() || (time_s_[row] - time_s_[stretch_[row]] >= slope_window_s - 1e-9 &&
                                                    noise_gain_[row] <= most_gain * usual_gain_));
}

Vector3 RecordedMotion::velocity_W_mps(std::size_t row) const {
  if (has_velocity()) return velocity_[row];
  if (!has_position()) return Vector3::Zero();
  return slope(row, [this](std::size_t k) { return position_[k]; }).value;
}

Vector3 RecordedMotion::body_rate_B_radps(std::size_t row) const {
  if (has_body_rate()) return rate_[row];
  return slope(row, [this, row](std::size_t k) { return turn_between(attitude_[row], attitude_[k]); }).value;
}

Vector3 RecordedMotion::body_rate_at(double time_s) const {
  const std::size_t row = nearest(time_s);
  const double late = time_s - this->time_s(row);
  const std::size_t other = late >= 0.0 ? std::min(row + 1, rows() - 1) : row - (row > 0 ? 1 : 0);
  if (other == row || late == 0.0) return body_rate_B_radps(row);
  const double part = late / (this->time_s(other) - this->time_s(row));
  return body_rate_B_radps(row) + part * (body_rate_B_radps(other) - body_rate_B_radps(row));
}

Quaternion RecordedMotion::attitude_at(double time_s) const {
  const std::size_t row = nearest(time_s);
  const double late = time_s - this->time_s(row);
  const std::size_t other = late >= 0.0 ? std::min(row + 1, rows() - 1) : row - (row > 0 ? 1 : 0);
  if (other == row || late == 0.0) return attitude_[row];
  return attitude_[row].slerp(late / (this->time_s(other) - this->time_s(row)), attitude_[other]);
}

}  // namespace gustlab::diagnosis
