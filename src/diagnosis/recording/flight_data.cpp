#include "diagnosis/recording/flight_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/recording/flight_labels.hpp"
#include "diagnosis/recording/log_filters.hpp"
#include "diagnosis/recording/rotor_answer.hpp"
#include "diagnosis/recording/row_intervals.hpp"
#include "diagnosis/recording/total_thrust.hpp"
#include "gustlab/errors.hpp"
#include "util/quantiles.hpp"
#include "util/rotations.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double grouped_s = 0.008;  // over which the fastest logs are averaged

// columns of one log by name; absent columns read as NaN
class Columns {
 public:
  Columns(const FlightLog& log, std::initializer_list<const char*> names) {
    for (const char* name : names) columns_.push_back(log.find(name));
  }
  bool complete() const {
    return std::all_of(columns_.begin(), columns_.end(), [](const auto* c) { return c != nullptr; });
  }
  Vector3 vector(std::size_t row) const { return {at(0, row), at(1, row), at(2, row)}; }
  double at(std::size_t column, std::size_t row) const {
    return columns_[column] ? (*columns_[column])[row] : std::nan("");
  }

 private:
  std::vector<const std::vector<double>*> columns_;
};

// Weighted least squares of a polynomial through a window of samples, as weights on them: coefficient d (of the power d of the time in windows)
// is the sum of by(d, k) value[k]. Windows in which samples lie alike (nearly all, where they are evenly spaced) share them.
template <int Degree>
class LocalWeights {
 public:
  using Powers = Eigen::Matrix<double, Degree + 1, 1>;

  // `time`: of the samples from the middle, in half windows
  const std::vector<Powers>& of(const std::vector<double>& time) {
    if (!alike(time)) fit(time);
    return by_;
  }

 private:
  bool alike(const std::vector<double>& time) const {
    constexpr double rounding = 1e-11;
    return std::ranges::equal(time, time_, [](double a, double b) { return std::abs(a - b) < rounding; });
  }

  void fit(const std::vector<double>& time) {
    time_ = time;
    by_.resize(time.size());
    Eigen::Matrix<double, Degree + 1, Degree + 1> gram = decltype(gram)::Zero();
    for (std::size_t k = 0; k < time.size(); ++k) {
      Powers powers = Powers::Ones();
      for (int d = 1; d <= Degree; ++d) powers[d] = powers[d - 1] * time[k];
      by_[k] = tricube(time[k]) * powers;
      gram += by_[k] * powers.transpose();
    }
    gram.diagonal().array() += 1e-12 * static_cast<double>(time.size());
    const auto factor = gram.ldlt();
    for (Powers& weight : by_) weight = factor.solve(weight).eval();
  }

  std::vector<double> time_;
  std::vector<Powers> by_;
};

// samples of one channel in one segment, and the local fits along them
struct Stream {
  std::vector<double> time_s;
  std::vector<Eigen::Vector4d> value;
  double step_s = 0.0;  // between samples, median

  void settle() {
    std::vector<double> steps;
    for (std::size_t k = 1; k < time_s.size(); ++k) steps.push_back(time_s[k] - time_s[k - 1]);
    step_s = median(std::move(steps));
  }
  bool can_fit(std::size_t least) const { return time_s.size() >= least; }
};

// Local polynomials along a stream: the window is half_s to either side, or wider where that holds too few samples. A sample's weight fades
// towards the ends: one that enters or leaves moves nothing.
template <int Degree>
class LocalFit {
 public:
  LocalFit(const Stream& stream, double half_s)
      : stream_(stream), half_s_(std::max(half_s, (0.5 * Degree + 2.1) * stream.step_s)) {}

  // coefficients at a time, of the powers of the time from there
  std::array<Eigen::Vector4d, Degree + 1> at(double at_s) {
    constexpr auto least = static_cast<std::size_t>(Degree + 2);
    const std::vector<double>& time_s = stream_.time_s;
    double half_s = half_s_;
    const auto bound = [&](double t) {
      return static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), t) - time_s.begin());
    };
    auto first = bound(at_s - half_s), last = bound(at_s + half_s);
    while (last - first < least && (first > 0 || last < time_s.size())) {
      const bool left = first > 0 && (last == time_s.size() || at_s - time_s[first - 1] < time_s[last] - at_s);
      half_s = 1.2 * std::abs(at_s - time_s[left ? --first : last++]);
    }
    time_.clear();
    for (std::size_t k = first; k < last; ++k) time_.push_back((time_s[k] - at_s) / half_s);
    const auto& weight = weights_.of(time_);
    Eigen::Matrix<double, 4, Degree + 1> sum = decltype(sum)::Zero();
    for (std::size_t k = first; k < last; ++k) sum += stream_.value[k] * weight[k - first].transpose();
    std::array<Eigen::Vector4d, Degree + 1> coefficients;
    double unit = 1.0;
    for (int d = 0; d <= Degree; ++d, unit *= half_s) coefficients[static_cast<std::size_t>(d)] = sum.col(d) / unit;
    return coefficients;
  }

 private:
  const Stream& stream_;
  const double half_s_;
  std::vector<double> time_;
  LocalWeights<Degree> weights_;
};

// no quaternion has the other sign than the one before it
void make_attitude_continuous(FlightLog& log) {
  std::array<std::vector<double>*, 4> q{};
  for (LogColumn& column : log.columns) {
    const std::string_view names[] = {"qw", "qx", "qy", "qz"};
    for (std::size_t i = 0; i < 4; ++i)
      if (column.name == names[i]) q[i] = &column.values;
  }
  if (q[0] && q[1] && q[2] && q[3])
    for (std::size_t k = 0, last = 0; k < log.rows(); ++k) {
      double dot = 0.0;
      for (const auto* c : q) dot += (*c)[k] * (*c)[last];
      if (dot < 0.0)
        for (auto* c : q) (*c)[k] *= -1.0;
      if (!std::isnan(dot) || !std::isfinite((*q[0])[last])) last = k;
    }
}

// every sampled column once more through one zero-phase Gaussian
FlightLog filtered_alike(FlightLog log, double sd_s) {
  make_attitude_continuous(log);
  const auto& time = log.time_s;
  std::vector<double> raw;
  for (LogColumn& column : log.columns) {
    raw = column.values;
    std::size_t first = 0;
    for (std::size_t k = 0; k < log.rows(); ++k) {
      while (time[k] - time[first] > 4.0 * sd_s) ++first;
      double sum = 0.0, weight = 0.0;
      for (std::size_t j = first; j < log.rows() && time[j] - time[k] <= 4.0 * sd_s; ++j) {
        if (!std::isfinite(raw[j])) continue;
        const double u = (time[j] - time[k]) / sd_s, w = std::exp(-0.5 * u * u);
        sum += w * raw[j];
        weight += w;
      }
      if (std::isfinite(raw[k])) column.values[k] = sum / weight;
    }
  }
  return log;
}

// intervals between the rows for which `has` holds
template <class Has>
std::vector<double> steps_between(const std::vector<double>& time_s, const Has& has) {
  std::vector<double> steps;
  double last_s = std::nan("");
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    if (!has(k)) continue;
    if (std::isfinite(last_s)) steps.push_back(time_s[k] - last_s);
    last_s = time_s[k];
  }
  return steps;
}

// intervals of the fastest sensor: where columns have rates and rows of their own, rows are closer than any of them
std::vector<double> fastest_steps(const FlightLog& log) {
  std::vector<double> fastest;
  for (const char* name : {"px", "vx", "qw", "wx", "ax"}) {
    const auto* column = log.find(name);
    if (!column) continue;
    std::vector<double> steps = steps_between(log.time_s, [&](std::size_t k) { return std::isfinite((*column)[k]); });
    if (steps.size() > fastest.size()) fastest = std::move(steps);
  }
  return fastest;
}

struct Sensor {
  std::vector<const std::vector<double>*> columns;
  double least_s = 0.0;                                      // between samples that are read
  double last_s = -std::numeric_limits<double>::infinity();  // the last of them
  bool has(std::size_t row) const {
    return std::any_of(columns.begin(), columns.end(), [row](const auto* c) { return c && std::isfinite((*c)[row]); });
  }
};
Sensor pose_of(const FlightLog& log) { return {{log.find("px"), log.find("vx"), log.find("qw")}}; }
Sensor inertial_of(const FlightLog& log) { return {{log.find("wx"), log.find("ax")}}; }

// Slower sensors are read whole. What one estimator writes on every row moves together, and its errors last.
double least_coarse_hz(const FlightLog& log) {
  constexpr double of_sensors = 325.0, of_an_estimator = 235.0, nearly_all = 0.95;
  const Sensor pose = pose_of(log), inertial = inertial_of(log);
  double rows = 0.0, both = 0.0;
  for (std::size_t k = 0; k < log.rows(); ++k)
    if (inertial.has(k)) rows += 1.0, both += pose.has(k) ? 1.0 : 0.0;
  return rows > 0.0 && both >= nearly_all * rows ? of_an_estimator : of_sensors;
}

// samples of a log or a sensor between two that are read, itself counted
long stride_of(double step_s, const ReadingOptions& options) {
  const auto at = [step_s](double rate_hz) { return std::max(1L, std::lround(1.0 / (step_s * rate_hz))); };
  if (!(step_s > 0.0)) return 1;
  if (options.coarse_rate_hz > 0.0 && step_s * options.least_coarse_hz <= 1.0) return at(options.coarse_rate_hz);
  return at(options.max_rate_hz);
}

// Each sample of a pose that is read at a third of its rate or less is the mean of it and its two neighbours.
FlightLog with_mean_poses(FlightLog log, const ReadingOptions& options) {
  make_attitude_continuous(log);
  for (LogColumn& column : log.columns) {
    if (column.name.size() != 2 || std::string_view("pvq").find(column.name.front()) == std::string_view::npos)
      continue;
    std::vector<std::size_t> rows;
    for (std::size_t k = 0; k < log.rows(); ++k)
      if (std::isfinite(column.values[k])) rows.push_back(k);
    const double step_s =
        interval_s(steps_between(log.time_s, [&](std::size_t row) { return std::isfinite(column.values[row]); }));
    if (stride_of(step_s, options) < 3) continue;
    const std::vector<double> raw = column.values;
    for (std::size_t i = 1; i + 1 < rows.size(); ++i)
      if (log.time_s[rows[i + 1]] - log.time_s[rows[i - 1]] < 2.5 * step_s)
        column.values[rows[i]] = (raw[rows[i - 1]] + raw[rows[i]] + raw[rows[i + 1]]) / 3.0;
  }
  return log;
}

// Rows that are read: of every sensor at most so many samples a second, and each of a slower one's.
std::vector<std::size_t> rows_read(const FlightLog& log, const ReadingOptions& options) {
  std::array<Sensor, 2> sensors{pose_of(log), inertial_of(log)};
  for (Sensor& sensor : sensors) {
    const double step_s = interval_s(steps_between(log.time_s, [&sensor](std::size_t row) { return sensor.has(row); }));
    const long stride = stride_of(step_s, options);
    if (stride > 1) sensor.least_s = (static_cast<double>(stride) - 0.5) * step_s;
  }
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < log.rows(); ++k) {
    const auto due = [&](const Sensor& s) { return s.has(k) && log.time_s[k] - s.last_s >= s.least_s; };
    if (std::none_of(sensors.begin(), sensors.end(), due)) continue;
    for (Sensor& sensor : sensors)
      if (sensor.has(k)) sensor.last_s = log.time_s[k];
    rows.push_back(k);
  }
  return rows;
}

// body rate of a quaternion and its derivative: ω = 2 vec(q⁻¹ q̇)
Vector3 rate_of(const Quaternion& q, const Eigen::Vector4d& derivative) {
  const Quaternion dq(derivative[3], derivative[0], derivative[1], derivative[2]);
  return 2.0 * (q.conjugate() * dq).vec();
}

// Of each row, the last value that was measured until then; before the first one that one, where there is none at all `otherwise`.
std::vector<double> last_known(const std::vector<double>& measured, double otherwise) {
  const auto is_known = [](double value) { return std::isfinite(value); };
  const auto first = std::find_if(measured.begin(), measured.end(), is_known);
  double last = first == measured.end() ? otherwise : *first;
  std::vector<double> known;
  known.reserve(measured.size());
  for (const double value : measured) known.push_back(last = is_known(value) ? value : last);
  return known;
}

}  // namespace

double FlightData::flown_s() const {
  double flown_s = duration_s();
  for (std::size_t k = 1; k < samples.size(); ++k)
    flown_s -= std::max(0.0, samples[k].time_s - samples[k - 1].time_s - longest_walk_s);
  return flown_s;
}

double third_difference_noise(const std::vector<double>& y) {
  std::vector<double> d;
  for (std::size_t k = 3; k < y.size(); ++k) {
    const double third = y[k] - 3.0 * y[k - 1] + 3.0 * y[k - 2] - y[k - 3];
    if (std::isfinite(third)) d.push_back(std::abs(third));
  }
  return median(std::move(d)) / (0.6745 * std::sqrt(20.0));
}

std::vector<std::pair<std::size_t, std::size_t>> pose_gaps(const std::vector<double>& time_s,
                                                           const std::vector<double>& values) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<double> steps;
  std::size_t last = values.size();
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    if (last < values.size()) pairs.emplace_back(last, k), steps.push_back(time_s[k] - time_s[last]);
    last = k;
  }
  const double longest_s = std::max(0.1, 5.0 * median(std::move(steps)));
  std::erase_if(pairs, [&](const auto& p) { return time_s[p.second] - time_s[p.first] <= longest_s; });
  return pairs;
}

CommandRecord::CommandRecord(std::vector<double> time_s, std::vector<RotorArray> speed_radps, bool linear)
    : time_s_(std::move(time_s)), value_(std::move(speed_radps)), integral_(value_.size()), linear_(linear) {
  for (std::size_t k = 1; k < value_.size(); ++k)
    for (std::size_t i = 0; i < max_rotors; ++i)
      integral_[k][i] =
          integral_[k - 1][i] +
          (time_s_[k] - time_s_[k - 1]) * (linear_ ? 0.5 * (value_[k - 1][i] + value_[k][i]) : value_[k - 1][i]);
}

// the last row not later, or the first: near where it would be of even rows, or searched for
std::size_t CommandRecord::row_at(double time_s) const {
  const std::size_t last = time_s_.size() - 1;
  const double share = (time_s - time_s_.front()) / std::max(1e-9, time_s_.back() - time_s_.front());
  const auto even = static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * static_cast<double>(last));
  for (std::size_t k = even > 0 ? even - 1 : 0; k < std::min(even + 2, last); ++k)
    if (time_s_[k] <= time_s && time_s < time_s_[k + 1]) return k;
  const auto next = std::upper_bound(time_s_.begin(), time_s_.end(), time_s);
  return next == time_s_.begin() ? 0 : static_cast<std::size_t>(next - time_s_.begin()) - 1;
}

RotorArray CommandRecord::integral(double time_s) const {
  const std::size_t k = row_at(time_s);
  const double dt = time_s - time_s_[k];
  RotorArray result = integral_[k];
  const bool inside = linear_ && dt > 0.0 && k + 1 < value_.size();
  const double slope_time = inside ? 0.5 * dt * dt / (time_s_[k + 1] - time_s_[k]) : 0.0;
  for (std::size_t i = 0; i < max_rotors; ++i) {
    result[i] += dt * value_[k][i];
    if (inside) result[i] += slope_time * (value_[k + 1][i] - value_[k][i]);
  }
  return result;
}

void CommandRecord::delay(double by_s) {
  for (double& t : time_s_) t += by_s;
}

void CommandRecord::smooth(double variance_s2) { smoothed_s2_ += variance_s2; }

RotorArray CommandRecord::mean(double from_s, double to_s) const {
  RotorArray result = plain_mean(from_s, to_s);
  if (smoothed_s2_ == 0.0) return result;
  // three points have any small variance
  constexpr double apart_s = 0.03;
  const RotorArray before = plain_mean(from_s - apart_s, to_s - apart_s),
                   after = plain_mean(from_s + apart_s, to_s + apart_s);
  for (std::size_t i = 0; i < max_rotors; ++i)
    result[i] += 0.5 * smoothed_s2_ / (apart_s * apart_s) * (before[i] - 2.0 * result[i] + after[i]);
  return result;
}

RotorArray CommandRecord::plain_mean(double from_s, double to_s) const {
  RotorArray a = integral(from_s), b = integral(to_s);
  for (std::size_t i = 0; i < max_rotors; ++i) b[i] = (b[i] - a[i]) / (to_s - from_s);
  return b;
}

namespace {

// what the log says of its surroundings goes before what the vehicle file says
void see_surroundings(const Environment& seen, Environment& around) {
  if (seen.ground_z_m) around.ground_z_m = seen.ground_z_m;
  if (seen.ceiling_z_m) around.ceiling_z_m = seen.ceiling_z_m;
  if (!seen.walls.empty()) around.walls = seen.walls;
}

// Rotor speeds of the rows that have all of them (`prefix`1…N), at their full rate; empty: the log has no such columns.
CommandRecord speeds_recorded(const FlightLog& log, const VehicleModel& vehicle, const char* prefix, ActuatorKind kind,
                              bool interpolated) {
  std::vector<const std::vector<double>*> columns;
  const int wanted = kind == ActuatorKind::collective_thrust ? 1 : vehicle.rotor_count;
  for (int i = 1; i <= wanted; ++i) columns.push_back(log.find(fmt::format("{}{}", prefix, i)));
  if (columns.empty() || std::find(columns.begin(), columns.end(), nullptr) != columns.end()) return {};
  std::vector<double> at;
  std::vector<RotorArray> speed;
  for (std::size_t k = 0; k < log.rows(); ++k) {
    RotorArray row{};
    bool finite = true;
    for (std::size_t i = 0; i < static_cast<std::size_t>(vehicle.rotor_count); ++i) {
      const double input = (*columns[std::min(i, columns.size() - 1)])[k];
      finite = finite && std::isfinite(input);
      if (finite) row[i] = rotor_speed_radps(vehicle, vehicle.rotors[i], kind, input);
    }
    if (!finite) continue;
    at.push_back(log.time_s[k]);
    speed.push_back(row);
  }
  return at.size() < 2 ? CommandRecord{} : CommandRecord(std::move(at), std::move(speed), interpolated);
}

// Rows that become samples: each the mean of `size` rows from one of `first` on.
struct Groups {
  std::vector<std::size_t> first;
  std::size_t size = 1;
  std::size_t stride = 1;  // rows of the log between two samples
};

// Faster logs are read more slowly: every so many samples of each sensor, but not by much, since what the vehicle did between two samples
// has already changed its commands, and would bias what answers to them. Of the fastest, means over 8 ms take vibration out (over longer
// ones they would blur what the vehicle did).
Groups groups_read(const FlightLog& log, double log_step_s, const ReadingOptions& options) {
  const bool grouped = options.common_filter_s == 0.0 && log_step_s <= 0.0016 && log_step_s * options.max_rate_hz < 0.7;
  Groups groups;
  groups.stride = static_cast<std::size_t>(grouped ? std::max(1L, std::lround(grouped_s / log_step_s))
                                                   : stride_of(log_step_s, options));
  if (!grouped) {
    groups.first = rows_read(log, options);
    return groups;
  }
  // an odd number of rows, so that the middle of a group is a row and substeps begin where commands change
  if (groups.stride % 2 == 0) ++groups.stride;
  groups.size = groups.stride;
  for (std::size_t first = 0; first + groups.size <= log.rows(); first += groups.stride) groups.first.push_back(first);
  return groups;
}

// to where it was when velocity and rate were as they are
void put_pose_back(Sample& sample, double ahead_s) {
  if (sample.channels & has_velocity) sample.position_W_m -= ahead_s * sample.velocity_W_mps;
  if (sample.channels & has_rate) sample.attitude_WB = turned(sample.attitude_WB, -ahead_s * sample.body_rate_B_radps);
}

std::vector<Sample> samples_of(const FlightLog& log, const Groups& groups, double nominal_voltage_V,
                               const ReadingOptions& options) {
  const Columns p(log, {"px", "py", "pz"}), v(log, {"vx", "vy", "vz"}), w(log, {"wx", "wy", "wz"}),
      a(log, {"ax", "ay", "az"}), q(log, {"qw", "qx", "qy", "qz"});
  const auto* voltage = log.find("vbat");
  const std::vector<double> volts = voltage ? last_known(*voltage, nominal_voltage_V) : std::vector<double>();
  const auto size = static_cast<double>(groups.size);
  Quaternion previous = Quaternion::Identity();
  std::vector<Sample> samples;
  for (const std::size_t first : groups.first) {
    Sample sample;
    Eigen::Vector4d attitude = Eigen::Vector4d::Zero();
    sample.channels = has_position | has_velocity | has_attitude | has_rate | has_force;
    for (std::size_t k = first; k < first + groups.size; ++k) {
      const auto add = [&](const Columns& columns, Vector3& sum, unsigned channel) {
        const Vector3 value = columns.vector(k);
        if (value.allFinite()) sum += value / size;
        else sample.channels &= ~channel;
      };
      sample.time_s += log.time_s[k] / size;
      add(p, sample.position_W_m, has_position);
      add(v, sample.velocity_W_mps, has_velocity);
      add(w, sample.body_rate_B_radps, has_rate);
      add(a, sample.specific_force_B_mps2, has_force);
      Quaternion one(q.at(0, k), q.at(1, k), q.at(2, k), q.at(3, k));
      if (one.coeffs().allFinite()) {
        if (one.coeffs().dot(previous.coeffs()) < 0.0) one.coeffs() *= -1.0;
        previous = one;
        attitude += one.coeffs();
      } else {
        sample.channels &= ~has_attitude;
      }
      if (voltage) sample.voltage_V += volts[k] / size;
    }
    if (sample.channels & has_attitude) sample.attitude_WB.coeffs() = attitude.normalized();
    put_pose_back(sample, options.late.pose_ahead_s);
    if (options.forces_only && (sample.channels & has_position)) sample.channels &= ~(has_rate | has_force);
    // derived from the position
    if ((sample.channels & has_position) && !options.as_recorded) sample.channels &= ~has_velocity;
    samples.push_back(sample);
  }
  return samples;
}

// where the pose is missing, there is nothing to linearise about
void leave_out_gaps(const FlightLog& log, std::vector<Sample>& samples) {
  const auto* pose = log.find("px") ? log.find("px") : log.find("qw");
  if (!pose) return;
  for (const auto& [last, next] : pose_gaps(log.time_s, *pose))
    std::erase_if(samples, [from_s = log.time_s[last], to_s = log.time_s[next]](const Sample& s) {
      return s.time_s > from_s && s.time_s < to_s;
    });
}

// when the flight starts, the interval of its samples, and where a longer one begins a segment anew
void find_segments(FlightData& flight) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < flight.samples.size(); ++k)
    steps.push_back(flight.samples[k].time_s - flight.samples[k - 1].time_s);
  flight.sample_s = interval_s(steps);
  const double longest_s = longest_interval_s(steps);
  for (std::size_t k = 0; k < flight.samples.size(); ++k)
    flight.samples[k].starts_segment = k == 0 || steps[k - 1] > longest_s;
  flight.start_s = flight.samples.empty() ? 0.0 : flight.samples.front().time_s;
}

// commands at a limit say nothing of the small signal
void find_saturation(FlightData& flight) {
  const CommandRecord& inputs = flight.rotor_record();
  for (std::size_t k = 1; k < flight.samples.size(); ++k) {
    const RotorArray mean = inputs.mean(flight.samples[k].time_s - flight.sample_s, flight.samples[k].time_s);
    for (std::size_t i = 0; i < static_cast<std::size_t>(flight.vehicle.rotor_count); ++i)
      flight.samples[k].saturated = flight.samples[k].saturated || mean[i] > 1.001 * flight.vehicle.max_speed_radps;
  }
}

FlightData sensors_alone(const FlightLog& log, const VehicleModel& vehicle, const SensorLatency& late) {
  FlightData flight;
  flight.vehicle = vehicle;
  flight.late = late;
  ReadingOptions options;
  options.late = late;
  flight.samples =
      samples_of(log, groups_read(log, interval_s(fastest_steps(log)), options), vehicle.nominal_voltage_V, options);
  return flight;
}

// From the command of each row to the speed that the next one measures. Empty where the two have other rows.
CommandRecord from_commands(const CommandRecord& commands, const CommandRecord& measured) {
  constexpr double jump_s = 1e-6;
  if (commands.time_s() != measured.time_s()) return {};
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  for (std::size_t k = 0; k < commands.time_s().size(); ++k) {
    if (k > 0) time_s.push_back(commands.time_s()[k] - jump_s), speed.push_back(measured.speed_radps()[k]);
    time_s.push_back(commands.time_s()[k]), speed.push_back(commands.speed_radps()[k]);
  }
  return {std::move(time_s), std::move(speed), true};
}

// From each measured speed to the next along the lag of the vehicle file: at once where it has none.
CommandRecord as_answered(const CommandRecord& measured, const VehicleModel& vehicle) {
  constexpr double at_once_s = 1e-6;
  constexpr int parts = 4;  // of a row, straight lines
  const RotorAnswer answer(vehicle);
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  for (std::size_t k = 0; k < measured.time_s().size(); ++k) {
    const RotorArray& from = measured.speed_radps()[k];
    time_s.push_back(measured.time_s()[k]), speed.push_back(from);
    if (k + 1 == measured.time_s().size()) break;
    const RotorArray& to = measured.speed_radps()[k + 1];
    const double row_s = measured.time_s()[k + 1] - measured.time_s()[k];
    const RotorArray reached = answer.after(row_s, from, to);
    for (int part = 0; part < parts; ++part) {
      const double after_s = part == 0 ? at_once_s : row_s * part / parts;
      const RotorArray on_its_way = answer.after(after_s, from, to);
      RotorArray& now = speed.emplace_back(from);
      time_s.push_back(measured.time_s()[k] + after_s);
      for (std::size_t i = 0; i < max_rotors; ++i)
        if (reached[i] != from[i]) now[i] += (to[i] - from[i]) * (on_its_way[i] - from[i]) / (reached[i] - from[i]);
    }
  }
  return {std::move(time_s), std::move(speed), true};
}

// one log, as the options say; without `each_rotor` and `sensors`
FlightData read_alone(const FlightLog& original, const VehicleModel& vehicle, ReadingOptions options) {
  options.least_coarse_hz = least_coarse_hz(original);
  const bool filters = options.common_filter_s > 0.0, averages = !filters && options.coarse_rate_hz > 0.0;
  const FlightLog changed = filters    ? filtered_alike(original, options.common_filter_s)
                            : averages ? with_mean_poses(original, options)
                                       : FlightLog{};
  const FlightLog& log = filters || averages ? changed : original;
  FlightData flight;
  flight.file = log.path;
  flight.label = label_of(log.path);
  flight.vehicle = vehicle;
  see_surroundings(log.meta.environment, flight.vehicle.environment);
  flight.late = options.late;
  flight.as_recorded = options.as_recorded;
  flight.commands_filtered = commands_filtered(original);
  flight.collective_only = options.forces_only || log.meta.actuator == ActuatorKind::collective_thrust;
  flight.hold_known = log.meta.hold == Hold::zoh;
  const bool linear =
      log.meta.hold == Hold::linear || (log.meta.hold == Hold::unknown && options.linear_hold.value_or(false));
  flight.commands = speeds_recorded(log, vehicle, "u", log.meta.actuator, linear);
  flight.measured_speed = speeds_recorded(log, vehicle, "rotor", ActuatorKind::rotor_speed, true);
  flight.loop_goes_on = log.meta.between_rows == BetweenRows::loop_goes_on;
  if (log.meta.between_rows == BetweenRows::from_command_to_speed)
    flight.jumping_speed = from_commands(flight.commands, flight.measured_speed);
  if (log.meta.between_rows == BetweenRows::as_answered)
    flight.jumping_speed = as_answered(flight.measured_speed, vehicle);
  if (flight.commands.empty() && flight.measured_speed.empty())
    throw DataError(fmt::format("{}: no actuator input for {} rotors (u1…u{} or rotor1…rotor{} is needed)", log.path,
                                vehicle.rotor_count, vehicle.rotor_count, vehicle.rotor_count));
  flight.has_voltage = log.find("vbat") != nullptr;
  const double log_step_s = interval_s(fastest_steps(log));
  const Groups groups = groups_read(log, log_step_s, options);
  flight.read_slower = groups.stride > 1;
  flight.substeps = static_cast<int>(groups.stride) *
                    static_cast<int>(std::max(1.0, std::ceil(log_step_s / options.substep_s - 1e-6)));
  flight.samples = samples_of(log, groups, vehicle.nominal_voltage_V, options);
  leave_out_gaps(log, flight.samples);
  find_segments(flight);
  find_saturation(flight);
  smooth_motion(flight, {});
  return flight;
}

}  // namespace

FlightData prepare_flight(const FlightLog& log, const VehicleModel& vehicle, const ReadingOptions& options) {
  FlightData flight = read_alone(options.total_thrust ? with_total_thrust(log, vehicle) : log, vehicle, options);
  const bool posed = log.find("qw") != nullptr;
  if (options.total_thrust && log.meta.actuator != ActuatorKind::collective_thrust && posed)
    flight.each_rotor = std::make_shared<FlightData>(read_alone(log, vehicle, options));
  if ((options.forces_only || options.common_filter_s > 0.0) && posed && log.find("wx") != nullptr)
    flight.sensors = std::make_shared<FlightData>(sensors_alone(log, vehicle, options.late));
  flight.inertial_unused =
      options.forces_only && !flight.sensors && log.find("px") != nullptr && log.find("ax") != nullptr;
  return flight;
}

namespace {

// The commands before which none is known for a while: the first, and the first after a gap.
std::vector<double> first_commands_s(const FlightData& flight) {
  const std::vector<double>& at_s = flight.commands.time_s();
  std::vector<double> steps, first;
  for (std::size_t k = 1; k < at_s.size(); ++k) steps.push_back(at_s[k] - at_s[k - 1]);
  const double longest_s = std::max(spin_up_s, longest_interval_s(steps));
  for (std::size_t k = 0; k < at_s.size(); ++k)
    if (k == 0 || steps[k - 1] > longest_s) first.push_back(at_s[k]);
  return first;
}

template <class Value>
void keep(const std::vector<bool>& kept, std::vector<Value>& values) {
  if (values.size() != kept.size()) return;
  std::size_t to = 0;
  for (std::size_t k = 0; k < kept.size(); ++k)
    if (kept[k]) values[to++] = std::move(values[k]);
  values.resize(to);
}

}  // namespace

bool makes_rotors_late(const EffectRow& row) { return row.place == Place::actuation && row.latency != Latency::none; }

bool rotors_are_late(const VehicleModel& vehicle) {
  return std::ranges::any_of(vehicle.effects,
                             [](const EffectSpec& effect) { return makes_rotors_late(*find_effect(effect.type)); });
}

FlightData without_spin_up(FlightData flight, double spin_up) {
  if (flight.each_rotor) flight.each_rotor = std::make_shared<FlightData>(without_spin_up(*flight.each_rotor, spin_up));
  if (!flight.measured_speed.empty()) return flight;
  std::vector<bool> kept(flight.samples.size(), true);
  for (const double from_s : first_commands_s(flight))
    for (std::size_t k = 0; k < kept.size(); ++k)
      if (const double after_s = flight.samples[k].time_s - from_s; after_s >= 0.0 && after_s < spin_up)
        kept[k] = false;
  for (std::size_t k = 1; k < kept.size(); ++k)
    if (kept[k] && !kept[k - 1]) flight.samples[k].starts_segment = true;
  keep(kept, flight.motion);
  keep(kept, flight.gyro);
  keep(kept, flight.samples);
  return flight;
}

double rate_half_window_s(const FlightData& flight) {
  return std::max(flight.as_recorded ? 0.0 : 0.063, 3.1 * flight.sample_s);
}

namespace {

// The channels of one segment, effects of the pose taken out: a late one belongs to an earlier time.
struct Streams {
  Stream position, velocity, attitude, rate;

  Streams(const Sample* begin, const Sample* end, const SensorCorrection& correction) {
    const auto put = [](Stream& stream, double time_s, const Vector3& value) {
      stream.time_s.push_back(time_s);
      stream.value.emplace_back(value.x(), value.y(), value.z(), 0.0);
    };
    const Vector3 back = -correction.attitude_offset_B_rad;
    for (const Sample* s = begin; s != end; ++s) {
      const double pose_time_s = s->time_s - correction.pose_delay_s;
      if (s->channels & has_position) put(position, pose_time_s, s->position_W_m);
      if (s->channels & has_velocity) put(velocity, pose_time_s, s->velocity_W_mps);
      if (s->channels & has_rate) put(rate, s->time_s, s->body_rate_B_radps);
      if (s->channels & has_attitude) {
        attitude.time_s.push_back(pose_time_s);
        attitude.value.push_back(turned(s->attitude_WB, back).coeffs());
      }
    }
    for (Stream* stream : {&position, &velocity, &attitude, &rate}) stream->settle();
  }
};

// half widths of the local fits
struct HalfWindows {
  double pose_s, rate_s, acceleration_s;
};

// the local fits of one segment, and what they say of one moment; nothing where they cannot
class LocalFits {
 public:
  LocalFits(const Streams& seen, const HalfWindows& half)
      : seen_(seen),
        position_(seen.position, half.pose_s),
        curvature_(seen.position, half.acceleration_s),
        velocity_(seen.velocity, half.pose_s),
        attitude_(seen.attitude, half.pose_s),
        rate_(seen.rate, half.rate_s) {}

  void see_path(double t, Motion& motion) {
    if (seen_.position.can_fit(5)) {
      const auto c = position_.at(t);
      motion.position_W_m = c[0].head<3>();
      motion.velocity_W_mps = c[1].head<3>();
      motion.acceleration_W_mps2 = 2.0 * curvature_.at(t)[2].head<3>();
    }
    if (seen_.velocity.can_fit(5)) {
      const auto c = velocity_.at(t);
      motion.velocity_W_mps = c[0].head<3>();
      motion.acceleration_W_mps2 = c[1].head<3>();
    }
  }

  void see_attitude(double t, Motion& motion) {
    if (!seen_.attitude.can_fit(5)) return;
    const auto c = attitude_.at(t);
    motion.attitude_WB.coeffs() = c[0].normalized();
    motion.body_rate_B_radps = rate_of(motion.attitude_WB, c[1] / c[0].norm());
  }

  GyroFit gyro_at(double t) {
    GyroFit gyro;
    gyro.attitude_known = seen_.attitude.can_fit(5);
    gyro.known = seen_.rate.can_fit(5);
    if (!gyro.known) return gyro;
    const auto c = rate_.at(t);
    gyro.rate_B_radps = c[0].head<3>();
    gyro.acceleration_B_radps2 = c[1].head<3>();
    return gyro;
  }

 private:
  const Streams& seen_;
  LocalFit<3> position_, curvature_, velocity_, attitude_;
  LocalFit<2> rate_;
};

// the first sample of the next segment
std::size_t end_of_segment(const std::vector<Sample>& samples, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < samples.size() && !samples[end].starts_segment) ++end;
  return end;
}

// `attitude_only`: nothing else has changed since
void fit_streams(FlightData& flight, const SensorCorrection& correction, bool attitude_only) {
  const auto& samples = flight.samples;
  const HalfWindows half{flight.as_recorded ? 0.0 : 0.095, rate_half_window_s(flight),
                         std::max(0.147, 4.3 * flight.sample_s)};
  if (!attitude_only) {
    flight.motion.assign(samples.size(), Motion{});
    flight.gyro.assign(samples.size(), GyroFit{});
  }
  for (std::size_t begin = 0, end; begin < samples.size(); begin = end) {
    end = end_of_segment(samples, begin);
    const Streams seen(&samples[begin], samples.data() + end, correction);
    LocalFits fits(seen, half);
    for (std::size_t k = begin; k < end; ++k) {
      fits.see_attitude(samples[k].time_s, flight.motion[k]);
      if (attitude_only) continue;
      fits.see_path(samples[k].time_s, flight.motion[k]);
      flight.gyro[k] = fits.gyro_at(samples[k].time_s);
    }
  }
}

}  // namespace

void smooth_motion(FlightData& flight, const SensorCorrection& correction) {
  const auto& samples = flight.samples;
  const bool anew = flight.gyro.size() != samples.size() || correction.pose_delay_s != flight.corrected.pose_delay_s;
  if (anew || correction.attitude_offset_B_rad != flight.corrected.attitude_offset_B_rad)
    fit_streams(flight, correction, !anew);
  flight.corrected = correction;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const GyroFit& gyro = flight.gyro[k];
    if (!gyro.known) continue;
    flight.motion[k].body_rate_B_radps =
        (gyro.rate_B_radps - correction.rate_bias_B_radps) / (1.0 + correction.rate_scale);
    flight.motion[k].angular_acceleration_B_radps2 = gyro.acceleration_B_radps2 / (1.0 + correction.rate_scale);
  }
  for (std::size_t k = 1; k < samples.size(); ++k) {
    if (samples[k].starts_segment) continue;
    const Motion& before = flight.motion[k - 1];
    // without attitude the rate is integrated; torques and body forces do not depend on it
    if (!flight.gyro[k].attitude_known)
      flight.motion[k].attitude_WB =
          turned(before.attitude_WB, before.body_rate_B_radps * (samples[k].time_s - samples[k - 1].time_s));
    else if (!flight.gyro[k].known && k + 1 < samples.size() && !samples[k + 1].starts_segment)
      flight.motion[k].angular_acceleration_B_radps2 =
          (flight.motion[k + 1].body_rate_B_radps - before.body_rate_B_radps) /
          (samples[k + 1].time_s - samples[k - 1].time_s);
  }
}

}  // namespace gustlab::diagnosis
