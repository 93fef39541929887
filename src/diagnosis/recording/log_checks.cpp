#include "diagnosis/recording/log_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/recording/clock_checks.hpp"
#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/recording/row_intervals.hpp"

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
 public:
  Checker(FlightLog& log, const VehicleModel& vehicle)
      : log_(log), vehicle_(vehicle), label_(log.path.substr(log.path.find_last_of('/') + 1)), step_s_(median_step(log.time_s)) {}

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
    for (const char* name : {"px", "py", "pz", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "ax", "ay", "az"}) held(name);
    voltage();
    sensors();
    return std::move(found_);
  }

 private:
  void add(const std::string& column, const std::string& kind, std::size_t first, std::size_t last, const std::string& says,
           bool flight_aside = false) {
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
      if (step > std::max(0.1, 5.0 * step_s_)) add("time_s", "gap", k - 1, k + 1, fmt::format("no sample for {:.2f} s", step));
    }
    const auto* pose = column("px") ? column("px") : column("qw");
    if (!pose) return;
    for (const auto& [last, next] : pose_gaps(log_.time_s, *pose))
      if (log_.time_s[last + 1] < log_.time_s[next])
        add("px…qz", "gap", last, next + 1, fmt::format("no pose for {:.2f} s: this part is left out", log_.time_s[next] - log_.time_s[last]));
  }

  std::vector<std::vector<double>*> inputs(const char* prefix) {
    std::vector<std::vector<double>*> result;
    for (int i = 1; i <= vehicle_.rotor_count; ++i)
      if (auto* c = column(fmt::format("{}{}", prefix, i))) result.push_back(c);
    return result;
  }

  // ranges of the input, copies, straight lines (interpolated over a loss of telemetry)
  void actuator() {
    const ActuatorKind kind = log_.meta.actuator;
    const double top = kind == ActuatorKind::pwm       ? 65535.0
                       : kind == ActuatorKind::throttle ? 1.0
                       : kind == ActuatorKind::rotor_speed ? 1.3 * vehicle_.max_speed_radps
                                                           : 3.0 * vehicle_.weight_N();
    const auto u = inputs("u");
    const bool scale_unknown = !vehicle_.rotor_speed_known && log_.meta.source == "recording";
    if (scale_unknown && !inputs("rotor").empty()) {
      for (auto* c : inputs("rotor")) std::fill(c->begin(), c->end(), nan);
      add("rotor1…rotorN", "unit", 0, log_.rows(), "measured rotor speeds are not used: the vehicle file has hover in place of a thrust coefficient");
    }
    if (scale_unknown && kind == ActuatorKind::rotor_speed && !u.empty())
      add("u1…uN", "unit", 0, log_.rows(), "the inputs are rotor speeds, and hover of the vehicle file is another input: write it in rad/s, or a coefficient", true);
    if (u.empty()) return;
    std::size_t outside = 0, first = log_.rows(), last = 0;
    for (auto* c : u)
      for (std::size_t k = 0; k < c->size(); ++k)
        if (std::isfinite((*c)[k]) && ((*c)[k] < -1e-6 * top || (*c)[k] > 1.0001 * top)) {
          ++outside;
          first = std::min(first, k);
          last = std::max(last, k + 1);
        }
    if (outside > 0) {
      const double share = static_cast<double>(outside) / static_cast<double>(u.size() * log_.rows());
      add("u1…uN", "out_of_range", first, last,
          fmt::format("{:.1f} % of the inputs are outside 0…{:g}: the flight is set aside", 100.0 * share, top), true);
      return;
    }
    std::size_t moving = 0, longest = 0, end = 0;
    for (auto* c : u) {
      std::size_t run = 0;
      moving += std::adjacent_find(c->begin(), c->end(), std::not_equal_to<>()) != c->end() ? 1 : 0;
      for (std::size_t k = 2; k < c->size(); ++k) {
        const double bend = (*c)[k] - 2.0 * (*c)[k - 1] + (*c)[k - 2], slope = (*c)[k] - (*c)[k - 1];
        run = std::abs(bend) < 1e-9 * top && slope != 0.0 ? run + 1 : 0;
        if (run > longest) longest = run, end = k;
      }
    }
    if (moving < u.size()) {
      add("u1…uN", "frozen", 0, log_.rows(),
          fmt::format("{} of {} inputs never change: the flight is set aside", u.size() - moving, u.size()), true);
    } else if (static_cast<double>(longest) * step_s_ > 0.5) {
      add("u1…uN", "inconsistent", end - longest, end + 1,
          fmt::format("the inputs are a straight line for {:.1f} s (interpolated over lost telemetry): the flight is set aside",
                      static_cast<double>(longest) * step_s_),
          true);
    }
  }

  // rows before take-off, after landing and of a stop between: rotors that cannot carry the weight
  void ground() {
    const auto u = inputs("u"), measured = inputs("rotor");
    const auto& speed = measured.empty() ? u : measured;
    if (speed.empty() || (measured.empty() && (log_.meta.actuator == ActuatorKind::throttle))) return;
    const double hover = vehicle_.hover_speed_radps();
    constexpr double shortest_stop_s = 1.0;
    std::vector<bool> off(log_.rows(), false);
    std::vector<double> thrusts(log_.rows());
    const FlightData data = prepare_flight(log_, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
    const CommandRecord& record = data.measured_speed.empty() ? data.commands : data.measured_speed;
    for (std::size_t k = 0; k < log_.rows(); ++k) {
      const RotorArray mean = record.mean(log_.time_s[k] - 0.15, log_.time_s[k] + 0.15);
      double thrust = 0.0;
      for (int i = 0; i < vehicle_.rotor_count; ++i)
        thrust += std::pow(mean[static_cast<std::size_t>(i)] / hover, 2) / vehicle_.rotor_count;
      off[k] = thrust < 0.35;
      thrusts[k] = thrust;
    }
    // in between, a moment of falling is flight
    std::size_t count = 0;
    double thrust_sum = 0.0;
    for (std::size_t first = 0, last = 0; first < off.size(); first = last) {
      for (last = first; last < off.size() && off[last] == off[first];) ++last;
      const bool inside = first > 0 && last < off.size();
      if (off[first] && inside && log_.time_s[last] - log_.time_s[first] < shortest_stop_s)
        std::fill(off.begin() + static_cast<std::ptrdiff_t>(first), off.begin() + static_cast<std::ptrdiff_t>(last), false);
      for (std::size_t k = first; k < last; ++k) {
        count += off[k] ? 1 : 0;
        thrust_sum += off[k] ? 0.0 : thrusts[k];
      }
    }
    if (count > 0) {
      add("*", "out_of_range", 0, log_.rows(),
          fmt::format("{:.1f} s with rotors too slow to fly (on the ground) are left out", static_cast<double>(count) * step_s_));
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
    const double ratio = thrust_sum / static_cast<double>(log_.rows());
    if (ratio < 0.5 || ratio > 2.0)
      add("u1…uN", "inconsistent", 0, log_.rows(),
          fmt::format("the inputs mean {:.2f} times the vehicle's weight of thrust: is it the right vehicle and the right unit?", ratio));
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
             : fmt::format("{} samples leap faster than {:g} m/s: they are not used", leapt, fastest_mps), many);
  }

  // forward-filled samples are no samples; a column that never moves is none at all
  void held(const char* name) {
    auto* c = column(name);
    if (!c) return;
    std::size_t repeats = 0, valid = 0, longest = 0, run = 0, end = 0;
    for (std::size_t k = 1; k < c->size(); ++k) {
      if (!std::isfinite((*c)[k]) || !std::isfinite((*c)[k - 1])) continue;
      ++valid;
      const bool same = (*c)[k] == (*c)[k - 1];
      repeats += same ? 1 : 0;
      run = same ? run + 1 : 0;
      if (run > longest) longest = run, end = k;
    }
    if (valid < 20) return;
    const double share = static_cast<double>(repeats) / static_cast<double>(valid);
    if (share > 0.999) {
      add(name, "frozen", 0, c->size(), "never changes: not used");
      std::fill(c->begin(), c->end(), nan);
      return;
    }
    const bool stuck = static_cast<double>(longest) * step_s_ > 0.25;
    if (share > 0.25)
      add(name, "held", 0, c->size(), fmt::format("{:.0f} % of its samples repeat the one before (forward-filled): only new ones are used", 100.0 * share));
    else if (stuck)
      add(name, "frozen", end - longest, end + 1, fmt::format("stands still for {:.2f} s: not used there", static_cast<double>(longest) * step_s_));
    else
      return;
    double last = nan;
    for (double& value : *c) {
      const double now = value;
      if (now == last) value = nan;
      last = now;
    }
  }

  void voltage() {
    auto* c = column("vbat");
    if (!c) return;
    double low = 1e9, high = -1e9;
    for (const double v : *c)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    if (high - low > 1e-3 * std::max(1.0, high)) return;
    add("vbat", "frozen", 0, c->size(), "battery voltage never changes: battery_sag can only be told by time");
    std::erase_if(log_.columns, [](const LogColumn& column) { return column.name == "vbat"; });
  }

  // gyro against attitude, accelerometer against gravity, velocity against position
  void sensors() {
    FlightLog pose = log_;
    std::erase_if(pose.columns, [](const LogColumn& c) { return c.name == "wx" || c.name == "wy" || c.name == "wz"; });
    const auto *wx = column("wx"), *wy = column("wy"), *wz = column("wz");
    const bool attitude = column("qw") && column("qx") && column("qy") && column("qz");
    if (wx && wy && wz && attitude) {
      const FlightData data = prepare_flight(pose, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
      Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
      Vector3 rate_energy = Vector3::Zero(), gyro_energy = Vector3::Zero();
      for (std::size_t k = 0; k < data.samples.size() && k < log_.rows(); ++k) {
        const Vector3 gyro((*wx)[k], (*wy)[k], (*wz)[k]);
        if (!gyro.allFinite() || !(data.samples[k].channels & has_attitude)) continue;
        const Vector3& rate = data.motion[k].body_rate_B_radps;
        cross += gyro * rate.transpose();
        rate_energy += rate.cwiseAbs2();
        gyro_energy += gyro.cwiseAbs2();
      }
      bool wrong = false;
      for (int i = 0; i < 3; ++i) {
        const double slope = cross(i, i) / (rate_energy[i] + 1e-300);
        const double agreement = cross(i, i) / std::sqrt(rate_energy[i] * gyro_energy[i] + 1e-300);
        const char* name = i == 0 ? "wx" : i == 1 ? "wy" : "wz";
        if (rate_energy[i] / static_cast<double>(log_.rows()) < 0.01) continue;
        if (agreement > 0.6 && slope > 0.5 * degrees_per_radian) {
          add(name, "unit", 0, log_.rows(), "is in degrees per second: the attitude turns 57 times slower; the gyro is not used");
          wrong = true;
        } else if (agreement < -0.6) {
          add(name, "sign", 0, log_.rows(), "has the opposite sign of the attitude's rate; the gyro is not used");
          wrong = true;
        }
      }
      std::vector<Vector3> rate;
      for (std::size_t k = 0; k < log_.rows(); ++k) rate.emplace_back((*wx)[k], (*wy)[k], (*wz)[k]);
      const std::vector<LogFinding> delays = wrong ? std::vector<LogFinding>{} : rate_delays(data, rate);
      found_.insert(found_.end(), delays.begin(), delays.end());
      if (wrong || !delays.empty()) drop("wx", "wy", "wz");
      if (!delays.empty()) drop("ax", "ay", "az");
    }
    if (const auto *ax = column("ax"), *ay = column("ay"), *az = column("az"); ax && ay && az) {
      std::vector<double> size;
      double up = 0.0;
      for (std::size_t k = 0; k < log_.rows(); ++k) {
        const double n = std::hypot((*ax)[k], (*ay)[k], (*az)[k]);
        if (!std::isfinite(n)) continue;
        size.push_back(n);
        up += (*az)[k];
      }
      if (size.size() > 20) {
        const double typical = median(std::move(size));
        const char* fault = typical > 0.5 && typical < 1.6   ? "is in g, not m/s²"
                            : typical < 5.0 || typical > 20.0 ? "is not a specific force (a hover reads 9.81)"
                                                              : nullptr;
        if (fault) {
          add("ax…az", "unit", 0, log_.rows(), fmt::format("the accelerometer {} (median size {:.2f}): not used", fault, typical));
          drop("ax", "ay", "az");
        } else if (up < 0.0) {
          add("az", "sign", 0, log_.rows(), "the accelerometer reads downward in flight (a hover reads +9.81): not used");
          drop("ax", "ay", "az");
        }
      }
    }
    velocity_frame();
  }

  void velocity_frame() {
    const auto *vx = column("vx"), *vy = column("vy"), *vz = column("vz");
    if (!vx || !vy || !vz || !column("px") || !column("py") || !column("pz") || !column("qw")) return;
    const FlightData data = prepare_flight(log_, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
    double world = 0.0, body = 0.0, energy = 0.0;
    for (std::size_t k = 0; k < data.samples.size() && k < log_.rows(); ++k) {
      const Vector3 v((*vx)[k], (*vy)[k], (*vz)[k]);
      if (!v.allFinite()) continue;
      const Motion& m = data.motion[k];
      world += (v - m.velocity_W_mps).squaredNorm();
      body += (v - m.attitude_WB.conjugate() * m.velocity_W_mps).squaredNorm();
      energy += m.velocity_W_mps.squaredNorm();
    }
    if (energy / static_cast<double>(log_.rows()) < 0.01) return;
    if (body < 0.3 * world && world > 0.05 * energy) {
      add("vx…vz", "frame", 0, log_.rows(), "velocity is in body axes, not in world axes: the derivative of the position is used instead");
      drop("vx", "vy", "vz");
    } else if (world > 0.25 * energy) {
      add("vx…vz", "inconsistent", 0, log_.rows(), "velocity is not the derivative of the position, which is used instead");
      drop("vx", "vy", "vz");
    }
  }

  FlightLog& log_;
  const VehicleModel& vehicle_;
  std::string label_;
  double step_s_;
  bool aside_ = false;
  std::vector<LogFinding> found_;
};

}  // namespace

std::vector<LogFinding> check_log(FlightLog& log, const VehicleModel& vehicle) { return Checker(log, vehicle).run(); }

std::vector<LogFinding> check_copies(const std::vector<FlightLog>& logs) {
  std::vector<LogFinding> found;
  for (std::size_t i = 0; i < logs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (logs[i].rows() != logs[j].rows() || logs[i].columns.size() != logs[j].columns.size()) continue;
      bool same = true;
      for (std::size_t c = 0; same && c < logs[i].columns.size(); ++c)
        same = std::equal(logs[i].columns[c].values.begin(), logs[i].columns[c].values.end(), logs[j].columns[c].values.begin(),
                          [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); });
      if (!same) continue;
      LogFinding f;
      f.file = logs[i].path.substr(logs[i].path.find_last_of('/') + 1);
      f.column = "*";
      f.kind = "duplicate";
      f.to_s = logs[i].rows() ? logs[i].time_s.back() : 0.0;
      f.says = fmt::format("is a copy of {}: set aside", logs[j].path.substr(logs[j].path.find_last_of('/') + 1));
      f.sets_flight_aside = true;
      found.push_back(f);
      break;
    }
  return found;
}

}  // namespace gustlab::diagnosis
