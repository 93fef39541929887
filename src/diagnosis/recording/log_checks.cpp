#include "diagnosis/recording/log_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/recording/clock_checks.hpp"
#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/recording/flight_labels.hpp"
#include "diagnosis/recording/force_checks.hpp"
#include "diagnosis/recording/row_intervals.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degrees_per_radian = 180.0 / pi;

double median_step(const std::vector<double>& time) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < time.size(); ++k) steps.push_back(time[k] - time[k - 1]);
  if (steps.empty()) return 0.01;
  return median(std::move(steps));
}

// one flight while it is looked at
class Checker {
  using Names = std::vector<const char*>;

 public:
  Checker(FlightLog& log, const VehicleModel& vehicle)
      : log_(log), vehicle_(vehicle), label_(label_of(log.path)), step_s_(median_step(log.time_s)) {}

  std::vector<LogFinding> run() {
    for (const LogRepair& repair : log_.repairs)
      if (repair.kind == "duplicate") add("*", "duplicate", 0, log_.rows(), repair.says);
    gaps();
    actuator();
    if (aside_) return std::move(found_);
    ground();
    if (aside_) return std::move(found_);
    for (const char* name : {"px", "py", "pz"}) leaps(name);
    if (aside_) return std::move(found_);
    for (const Names& names :
         {Names{"px", "py", "pz"}, Names{"qw", "qx", "qy", "qz"}, Names{"wx", "wy", "wz"}, Names{"ax", "ay", "az"}}) {
      for (const char* name : names) frozen(name, names);
      held(names);
    }
    voltage();
    sensors();
    return std::move(found_);
  }

 private:
  void add(const std::string& column, const std::string& kind, std::size_t first, std::size_t last,
           const std::string& says, bool flight_aside = false) {
    LogFinding f;
    f.file = label_;
    f.column = column;
    f.kind = kind;
    f.from_s = log_.rows() ? log_.time_s[std::min(first, log_.rows() - 1)] : 0.0;
    f.to_s = log_.rows() ? log_.time_s[std::min(last, log_.rows()) - (last > 0 ? 1 : 0)] : 0.0;
    f.says = says;
    f.sets_flight_aside = flight_aside;
    aside_ = aside_ || flight_aside;
    found_.push_back(f);
  }
  std::vector<double>* column(std::string_view name) {
    for (LogColumn& c : log_.columns)
      if (c.name == name) return &c.values;
    return nullptr;
  }
  void drop(const char* a, const char* b, const char* c) {
    for (const char* name : {a, b, c})
      if (auto* v = column(name)) std::fill(v->begin(), v->end(), nan);
  }

  void gaps() {
    for (std::size_t k = 1; k < log_.rows(); ++k) {
      const double step = log_.time_s[k] - log_.time_s[k - 1];
      if (step > std::max(0.1, 5.0 * step_s_))
        add("time_s", "gap", k - 1, k + 1, fmt::format("no sample for {:.2f} s", step));
    }
    const auto* pose = column("px") ? column("px") : column("qw");
    if (!pose) return;
    for (const auto& [last, next] : pose_gaps(log_.time_s, *pose))
      if (log_.time_s[last + 1] < log_.time_s[next])
        add("px…qz", "gap", last, next + 1,
            fmt::format("no pose for {:.2f} s: this part is left out", log_.time_s[next] - log_.time_s[last]));
  }

  std::vector<std::vector<double>*> inputs(const char* prefix) {
    std::vector<std::vector<double>*> result;
    for (int i = 1; i <= vehicle_.rotor_count; ++i)
      if (auto* c = column(fmt::format("{}{}", prefix, i))) result.push_back(c);
    return result;
  }

  // 1.3 times the fastest that the vehicle file knows; a thrust that it does not bound may be ten times the weight
  double most_input(ActuatorKind kind) const {
    constexpr double beyond = 1.3, weights = 10.0;
    if (kind == ActuatorKind::pwm) return full_pwm;
    if (kind == ActuatorKind::throttle) return 1.0;
    if (kind == ActuatorKind::rotor_speed) return beyond * vehicle_.max_speed_radps;
    double most = 0.0, sum = 0.0;
    for (const Rotor& rotor : vehicle_.rotors) {
      const double thrust = rotor.thrust_coefficient_Ns2 * std::pow(beyond * vehicle_.max_speed_radps, 2);
      most = std::max(most, thrust), sum += thrust;
    }
    return std::max(weights * vehicle_.weight_N(), kind == ActuatorKind::thrust ? most : sum);
  }

  // ranges of the input, copies, straight lines (interpolated over a loss of telemetry)
  void actuator() {
    const ActuatorKind kind = log_.meta.actuator;
    const double top = most_input(kind);
    const auto u = inputs("u");
    const bool scale_unknown = !vehicle_.rotor_speed_known && log_.meta.source == "recording";
    if (scale_unknown && !inputs("rotor").empty()) {
      for (auto* c : inputs("rotor")) std::fill(c->begin(), c->end(), nan);
      add("rotor1…rotorN", "unit", 0, log_.rows(),
          "measured rotor speeds are not used: the vehicle file has hover in place of a thrust coefficient");
    }
    if (scale_unknown && kind == ActuatorKind::rotor_speed && !u.empty())
      add("u1…uN", "unit", 0, log_.rows(),
          "the inputs are rotor speeds, and hover of the vehicle file is another input: write it in rad/s, or a "
          "coefficient",
          true);
    if (u.empty()) return;
    if (!in_range(u, top)) return;
    std::size_t still = 0;
    Stretch straight;
    for (const auto* c : u) {
      still += never_changes(*c) ? 1 : 0;
      double most = top;  // without one in the vehicle file the largest input that was given
      if (!std::isfinite(top)) {
        most = 0.0;
        for (const double value : *c) most = std::abs(value) > most ? std::abs(value) : most;
      }
      straight = std::max(straight, straight_line(*c, 1e-9 * most));
    }
    if (still > 0) {
      add("u1…uN", "frozen", 0, log_.rows(),
          fmt::format("{} of {} inputs never change: the flight is set aside", still, u.size()), true);
    } else if (straight.lasts_s > 0.5) {
      add("u1…uN", "inconsistent", straight.first, straight.last + 1,
          fmt::format(
              "the inputs are a straight line for {:.1f} s (interpolated over lost telemetry): the flight is set aside",
              straight.lasts_s),
          true);
    }
  }

  bool in_range(const std::vector<std::vector<double>*>& u, double top) {
    std::size_t outside = 0, count = 0, first = log_.rows(), last = 0;
    for (const auto* c : u)
      for (std::size_t k = 0; k < c->size(); ++k) {
        count += std::isfinite((*c)[k]) ? 1 : 0;
        if (!((*c)[k] < -1e-6 * top || (*c)[k] > 1.0001 * top)) continue;
        ++outside;
        first = std::min(first, k);
        last = std::max(last, k + 1);
      }
    if (outside > 0)
      add("u1…uN", "out_of_range", first, last,
          fmt::format("{:.1f} % of the inputs are outside 0…{:g}{}: the flight is set aside",
                      100.0 * static_cast<double>(outside) / static_cast<double>(count), top,
                      2 * outside > count ? " (another vehicle's, or in another unit?)" : ""),
          true);
    return outside == 0;
  }

  // from one row to another
  struct Stretch {
    double lasts_s = 0.0;
    std::size_t first = 0, last = 0;
    bool operator<(const Stretch& other) const { return lasts_s < other.lasts_s; }
  };
  Stretch between(std::size_t first, std::size_t last) const {
    return {log_.time_s[last] - log_.time_s[first], first, last};
  }

  static bool never_changes(const std::vector<double>& values) {
    const std::vector<std::size_t> rows = sampled_rows(values);
    return !rows.empty() &&
           std::all_of(rows.begin(), rows.end(), [&](std::size_t k) { return values[k] == values[rows.front()]; });
  }

  // The longest part of a column that rises or falls by the same from sample to sample. Of coarse pulses a few do by chance, and what a
  // smooth simulation asks of its rotors bends little, but by far more of its slope.
  Stretch straight_line(const std::vector<double>& values, double same) const {
    constexpr std::size_t fewest_bends = 10;
    constexpr double least_bend = 1e-5;  // over the slope, from sample to sample
    const std::vector<std::size_t> rows = sampled_rows(values);
    Stretch longest;
    std::size_t run = 0;
    for (std::size_t i = 2; i < rows.size(); ++i) {
      const double now = values[rows[i]], last = values[rows[i - 1]], before = values[rows[i - 2]];
      run = std::abs(now - 2.0 * last + before) < std::min(same, least_bend * std::abs(now - last)) ? run + 1 : 0;
      if (run >= fewest_bends) longest = std::max(longest, between(rows[i - run], rows[i]));
    }
    return longest;
  }

  // rows before take-off, after landing and of a stop between: rotors that cannot carry the weight
  void ground() {
    const auto u = inputs("u"), measured = inputs("rotor");
    const auto& speed = measured.empty() ? u : measured;
    if (speed.empty() || (measured.empty() && (log_.meta.actuator == ActuatorKind::throttle))) return;
    const double hover = vehicle_.hover_speed_radps();
    constexpr double shortest_stop_s = 1.0;
    std::vector<bool> off(log_.rows(), false);
    const FlightData data = prepare_flight(log_, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
    const CommandRecord& record = data.rotor_record();
    for (std::size_t k = 0; k < log_.rows(); ++k) {
      const RotorArray mean = record.mean(log_.time_s[k] - 0.15, log_.time_s[k] + 0.15);
      double thrust = 0.0;
      for (int i = 0; i < vehicle_.rotor_count; ++i)
        thrust += std::pow(mean[static_cast<std::size_t>(i)] / hover, 2) / vehicle_.rotor_count;
      off[k] = thrust < 0.35;
    }
    // in between, a moment of falling is flight, and so is what moves
    double left_out_s = 0.0;
    for (std::size_t first = 0, last = 0; first < off.size(); first = last) {
      for (last = first; last < off.size() && off[last] == off[first];) ++last;
      const bool inside = first > 0 && last < off.size();
      if (off[first] && inside &&
          (log_.time_s[last] - log_.time_s[first] < shortest_stop_s ||
           moves(data, log_.time_s[first], log_.time_s[last])))
        std::fill(off.begin() + static_cast<std::ptrdiff_t>(first), off.begin() + static_cast<std::ptrdiff_t>(last),
                  false);
      if (off[first]) left_out_s += log_.time_s[last - 1] - log_.time_s[first] + step_s_;
    }
    if (left_out_s > 0.0) {
      add("*", "out_of_range", 0, log_.rows(),
          fmt::format("{:.1f} s with rotors too slow to fly (on the ground) are left out", left_out_s));
      const auto keep = [&](std::vector<double>& v) {
        std::size_t to = 0;
        for (std::size_t k = 0; k < off.size(); ++k)
          if (!off[k]) v[to++] = v[k];
        v.resize(to);
      };
      keep(log_.time_s);
      for (LogColumn& c : log_.columns) keep(c.values);
    }
    if (log_.rows() < 50) {
      add("*", "out_of_range", 0, log_.rows(), "fewer than 50 samples in the air: the flight is set aside", true);
      return;
    }
    judge_forces_ = true;
  }

  // mean speed of the pose between two times
  bool moves(const FlightData& data, double from_s, double to_s) const {
    constexpr double clearly_mps = 1.0;
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < data.samples.size(); ++k) {
      if (data.samples[k].time_s < from_s || data.samples[k].time_s >= to_s) continue;
      sum += data.motion[k].velocity_W_mps.norm();
      count += 1.0;
    }
    return sum > clearly_mps * count;
  }

  // a position that leaps faster than anything flies: a few samples are not used; many are another unit
  void leaps(const char* name) {
    constexpr double fastest_mps = 150.0;
    auto* c = column(name);
    if (!c) return;
    std::size_t leapt = 0, valid = 0, before = 0, first = 0, last = 0;
    for (std::size_t k = 0; k < c->size(); ++k) {
      if (!std::isfinite((*c)[k])) continue;
      if (valid++ > 0 && std::abs((*c)[k] - (*c)[before]) > fastest_mps * (log_.time_s[k] - log_.time_s[before])) {
        first = leapt++ == 0 ? k : first;
        last = k + 1;
        (*c)[k] = nan;
      } else {
        before = k;
      }
    }
    if (leapt == 0) return;
    const bool many = leapt * 10 > valid;
    add(name, many ? "unit" : "out_of_range", first, last,
        many ? fmt::format("moves faster than {:g} m/s: is it in metres? The flight is set aside", fastest_mps)
             : fmt::format("{} samples leap faster than {:g} m/s: they are not used", leapt, fastest_mps),
        many);
  }

  // the step to which the sensor or the log rounded its values: small changes are multiples of the smallest; otherwise 0
  static double coarse_step(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
    constexpr double most_steps = 20.0, same = 0.02;
    constexpr int fewest = 20;
    std::vector<double> moved;
    for (std::size_t i = 1; i < rows.size(); ++i)
      if (values[rows[i]] != values[rows[i - 1]]) moved.push_back(std::abs(values[rows[i]] - values[rows[i - 1]]));
    if (moved.empty()) return 0.0;
    const double step = *std::min_element(moved.begin(), moved.end());
    int small = 0, multiples = 0;
    for (const double m : moved) {
      if (m > most_steps * step) continue;
      ++small;
      multiples += std::abs(m / step - std::round(m / step)) < same ? 1 : 0;
    }
    return small >= fewest && multiples > 0.95 * small ? step : 0.0;
  }

  // a column that never moves is no sample at all, one that stands still is none there; of coarse values only with all of its sensor
  void frozen(const char* name, const Names& names) {
    auto* c = column(name);
    if (!c) return;
    const std::vector<std::size_t> rows = sampled_rows(*c);
    if (rows.size() <= 20) return;
    const bool alone = coarse_step(*c, rows) == 0.0;
    const auto stand = [&](std::size_t before, std::size_t now) {
      return std::all_of(names.begin(), names.end(), [&](const char* other) {
        const auto* o = alone ? c : column(other);
        return !o || (*o)[before] == (*o)[now];
      });
    };
    constexpr std::size_t fewest_repeats = 5;  // coarse values of a slow column repeat by chance
    std::size_t repeats = 0, run = 0;
    Stretch still;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const bool same = (*c)[rows[i]] == (*c)[rows[i - 1]];
      repeats += same ? 1 : 0;
      run = same && stand(rows[i - 1], rows[i]) ? run + 1 : 0;
      if (run >= fewest_repeats) still = std::max(still, between(rows[i - run], rows[i]));
    }
    if (static_cast<double>(repeats) > 0.999 * static_cast<double>(rows.size() - 1)) {
      add(name, "frozen", 0, c->size(), "never changes: not used");
      std::fill(c->begin(), c->end(), nan);
    } else if (still.lasts_s > 0.25) {
      add(name, "frozen", still.first, still.last + 1,
          fmt::format("stands still for {:.2f} s: not used there", still.lasts_s));
      double last = nan;
      for (const std::size_t k : rows) {
        const double now = (*c)[k];
        if (now == last) (*c)[k] = nan;
        last = now;
      }
    }
  }

  // whether coarse columns of a sensor, in the median, change by one step at a time: then a slow motion repeats its values
  static bool moves_by_single_steps(const std::vector<std::vector<double>*>& columns,
                                    const std::vector<std::size_t>& rows) {
    std::vector<double> usual_steps;
    for (const auto* c : columns) {
      const double step = coarse_step(*c, rows);
      std::vector<double> steps;
      for (std::size_t i = 1; step > 0.0 && i < rows.size(); ++i)
        if (const double moved = std::abs((*c)[rows[i]] - (*c)[rows[i - 1]]); moved > 0.0)
          steps.push_back(moved / step);
      if (!steps.empty()) usual_steps.push_back(median(std::move(steps)));
    }
    return !usual_steps.empty() && median(std::move(usual_steps)) < 1.5;
  }

  // forward-filled samples are no samples: all columns of a sensor repeat at once, while coarse values repeat one by one
  void held(const Names& names) {
    std::vector<std::vector<double>*> columns;
    for (const char* name : names)
      if (auto* c = column(name); c && !sampled_rows(*c).empty()) columns.push_back(c);
    if (columns.empty()) return;
    const auto all = [&](const auto& holds) { return std::all_of(columns.begin(), columns.end(), holds); };
    std::vector<std::size_t> rows, repeated;
    for (std::size_t k = 0; k < log_.rows(); ++k) {
      if (!all([&](const auto* c) { return std::isfinite((*c)[k]); })) continue;
      if (!rows.empty() && all([&](const auto* c) { return (*c)[k] == (*c)[rows.back()]; })) repeated.push_back(k);
      rows.push_back(k);
    }
    const double share = static_cast<double>(repeated.size()) / static_cast<double>(rows.size());
    if (rows.size() <= 20 || share <= 0.25 || moves_by_single_steps(columns, rows)) return;
    for (const char* name : names)
      if (column(name))
        add(name, "held", 0, log_.rows(),
            fmt::format("{:.0f} % of its samples repeat the one before (forward-filled): only new ones are used",
                        100.0 * share));
    for (auto* c : columns)
      for (const std::size_t k : repeated) (*c)[k] = nan;
  }

  void voltage() {
    auto* c = column("vbat");
    if (!c) return;
    double low = 1e9, high = -1e9;
    for (const double v : *c)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    if (high - low > 1e-3 * std::max(1.0, high)) return;
    add("vbat", "frozen", 0, c->size(), "battery voltage never changes: what falls with it can only be told by time");
    std::erase_if(log_.columns, [](const LogColumn& column) { return column.name == "vbat"; });
  }

  // gyro against attitude, velocity against position, accelerometer and inputs against the motion that these measure
  void sensors() {
    if (column("wx") && column("wy") && column("wz") && column("qw") && column("qx") && column("qy") && column("qz"))
      gyro();
    velocity_frame();
    if (judge_forces_)
      for (const ForceFault& fault : check_forces(log_, vehicle_)) {
        add(fault.column, fault.kind, 0, log_.rows(), fault.says);
        if (fault.sets_column_aside) drop("ax", "ay", "az");
      }
  }

  // the log without some columns, read at its own rate
  FlightData without(std::initializer_list<std::string_view> names) const {
    FlightLog rest = log_;
    std::erase_if(rest.columns,
                  [&](const LogColumn& c) { return std::find(names.begin(), names.end(), c.name) != names.end(); });
    return prepare_flight(rest, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
  }

  // three columns per sample of a reading of the log at its own rate, which leaves out rows without a pose
  static std::vector<Vector3> at_samples(const FlightLog& log, const FlightData& data, const char* x, const char* y,
                                         const char* z) {
    const auto &of_x = *log.find(x), &of_y = *log.find(y), &of_z = *log.find(z);
    std::vector<Vector3> values;
    std::size_t row = 0;
    for (const Sample& sample : data.samples) {
      while (log.time_s[row] < sample.time_s) ++row;
      values.emplace_back(of_x[row], of_y[row], of_z[row]);
    }
    return values;
  }
  static std::vector<Vector3> gyro_of(const FlightLog& log, const FlightData& data) {
    return at_samples(log, data, "wx", "wy", "wz");
  }

  // which samples are no further from one with a channel than those are from each other
  static std::vector<bool> near(const FlightData& data, Channel channel) {
    std::vector<double> at_s, steps_s;
    for (const Sample& sample : data.samples)
      if (sample.channels & channel) {
        if (!at_s.empty()) steps_s.push_back(sample.time_s - at_s.back());
        at_s.push_back(sample.time_s);
      }
    const double far_s = longest_interval_s(steps_s);
    std::vector<bool> result;
    for (const Sample& sample : data.samples) {
      const auto next = std::lower_bound(at_s.begin(), at_s.end(), sample.time_s);
      result.push_back((next != at_s.end() && *next - sample.time_s <= far_s) ||
                       (next != at_s.begin() && sample.time_s - *(next - 1) <= far_s));
    }
    return result;
  }

  void gyro() {
    const FlightData data = without({"wx", "wy", "wz"});
    const std::vector<Vector3> rates = gyro_of(log_, data);
    const std::vector<bool> measured = near(data, has_attitude);
    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
    Vector3 rate_energy = Vector3::Zero(), gyro_energy = Vector3::Zero();
    double count = 0.0;
    for (std::size_t k = 0; k < rates.size(); ++k) {
      if (!rates[k].allFinite() || !measured[k]) continue;
      const Vector3& rate = data.motion[k].body_rate_B_radps;
      cross += rates[k] * rate.transpose();
      rate_energy += rate.cwiseAbs2();
      gyro_energy += rates[k].cwiseAbs2();
      count += 1.0;
    }
    bool wrong = false;
    for (int i = 0; i < 3; ++i) {
      const double slope = cross(i, i) / (rate_energy[i] + 1e-300);
      const double agreement = cross(i, i) / std::sqrt(rate_energy[i] * gyro_energy[i] + 1e-300);
      const char* name = i == 0 ? "wx" : i == 1 ? "wy" : "wz";
      if (rate_energy[i] < 0.01 * count) continue;
      if (agreement > 0.6 && slope > 0.5 * degrees_per_radian) {
        add(name, "unit", 0, log_.rows(),
            "is in degrees per second: the attitude turns 57 times slower; the gyro is not used");
        wrong = true;
      } else if (agreement < -0.6) {
        add(name, "sign", 0, log_.rows(), "has the opposite sign of the attitude's rate; the gyro is not used");
        wrong = true;
      }
    }
    if (wrong) drop("wx", "wy", "wz");
    else clocks(data, rates);
  }

  // a board whose clock wanders against the pose's is laid on it where angular motion shows the time between them
  void clocks(const FlightData& data, const std::vector<Vector3>& rates) {
    const std::optional<ClockTrack> track = gyro_track(data, rates);
    if (!track) return;
    const std::string apart = fmt::format(
        "the gyro is {:.0f} to {:.0f} ms later than the attitude, another time in each stretch of the flight",
        1e3 * track->least_s(), 1e3 * track->most_s());
    if (FlightLog laid = laid_on_pose_clock(log_, *track); gyro_track(data, gyro_of(laid, data))) {
      add("wx…az", "delay", 0, log_.rows(),
          apart + ": inertial data and pose are on two clocks, and the inertial data are not used");
      found_.back().sets_column_aside = true;
      drop("wx", "wy", "wz");
      drop("ax", "ay", "az");
    } else {
      add("wx…az, u1…uN", "delay", 0, log_.rows(),
          apart + ": all that was recorded on board is laid on the pose's clock, stretch by stretch");
      log_ = std::move(laid);
    }
  }

  void velocity_frame() {
    for (const char* name : {"vx", "vy", "vz", "px", "py", "pz", "qw"})
      if (!column(name)) return;
    const FlightData data = without({"vx", "vy", "vz"});
    const std::vector<Vector3> velocity = at_samples(log_, data, "vx", "vy", "vz");
    const std::vector<bool> measured = near(data, has_position);
    double world = 0.0, body = 0.0, energy = 0.0, count = 0.0;
    for (std::size_t k = 0; k < velocity.size(); ++k) {
      const Vector3& v = velocity[k];
      if (!v.allFinite() || !measured[k]) continue;
      const Motion& m = data.motion[k];
      world += (v - m.velocity_W_mps).squaredNorm();
      body += (v - m.attitude_WB.conjugate() * m.velocity_W_mps).squaredNorm();
      energy += m.velocity_W_mps.squaredNorm();
      count += 1.0;
    }
    if (energy < 0.01 * count) return;
    if (body < 0.3 * world && world > 0.05 * energy) {
      add("vx…vz", "frame", 0, log_.rows(),
          "velocity is in body axes, not in world axes: the derivative of the position is used instead");
      drop("vx", "vy", "vz");
    } else if (world > 0.25 * energy) {
      add("vx…vz", "inconsistent", 0, log_.rows(),
          "velocity is not the derivative of the position, which is used instead");
      drop("vx", "vy", "vz");
    }
  }

  FlightLog& log_;
  const VehicleModel& vehicle_;
  std::string label_;
  double step_s_;
  bool aside_ = false;
  bool judge_forces_ = false;  // inputs that have a map to rotor speed
  std::vector<LogFinding> found_;
};

}  // namespace

std::vector<LogFinding> check_log(FlightLog& log, const VehicleModel& vehicle) { return Checker(log, vehicle).run(); }

namespace {

bool are_copies(const FlightLog& one, const FlightLog& other) {
  const auto same = [](const LogColumn& a, const LogColumn& b) {
    return std::ranges::equal(a.values, b.values,
                              [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
  };
  return one.rows() == other.rows() && std::ranges::equal(one.columns, other.columns, same);
}

}  // namespace

std::vector<LogFinding> check_copies(const std::vector<FlightLog>& logs, const std::vector<const FlightLog*>& before) {
  std::vector<LogFinding> found;
  std::vector<const FlightLog*> seen = before;
  for (const FlightLog& log : logs) {
    const auto original =
        std::ranges::find_if(seen, [&](const FlightLog* earlier) { return are_copies(log, *earlier); });
    if (original != seen.end())
      found.push_back({label_of(log.path), "*", "duplicate", 0.0, log.rows() ? log.time_s.back() : 0.0,
                       fmt::format("is a copy of {}: set aside", label_of((*original)->path)), true, false});
    seen.push_back(&log);
  }
  return found;
}

}  // namespace gustlab::diagnosis
