#include "diagnosis/recording/log_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/recording/clock_checks.hpp"
#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/recording/force_checks.hpp"
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
      : log_(log),
        vehicle_(vehicle),
        label_(log.path.substr(log.path.find_last_of('/') + 1)),
        step_s_(median_step(log.time_s)) {}

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
    if (kind == ActuatorKind::pwm) return 65535.0;
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
          fmt::format(
              "the inputs are a straight line for {:.1f} s (interpolated over lost telemetry): the flight is set aside",
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
    const FlightData data = prepare_flight(log_, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
    const CommandRecord& record = data.measured_speed.empty() ? data.commands : data.measured_speed;
    for (std::size_t k = 0; k < log_.rows(); ++k) {
      const RotorArray mean = record.mean(log_.time_s[k] - 0.15, log_.time_s[k] + 0.15);
      double thrust = 0.0;
      for (int i = 0; i < vehicle_.rotor_count; ++i)
        thrust += std::pow(mean[static_cast<std::size_t>(i)] / hover, 2) / vehicle_.rotor_count;
      off[k] = thrust < 0.35;
    }
    // in between, a moment of falling is flight, and so is what moves
    std::size_t count = 0;
    for (std::size_t first = 0, last = 0; first < off.size(); first = last) {
      for (last = first; last < off.size() && off[last] == off[first];) ++last;
      const bool inside = first > 0 && last < off.size();
      if (off[first] && inside &&
          (log_.time_s[last] - log_.time_s[first] < shortest_stop_s ||
           moves(data, log_.time_s[first], log_.time_s[last])))
        std::fill(off.begin() + static_cast<std::ptrdiff_t>(first), off.begin() + static_cast<std::ptrdiff_t>(last),
                  false);
      for (std::size_t k = first; k < last; ++k) count += off[k] ? 1 : 0;
    }
    if (count > 0) {
      add("*", "out_of_range", 0, log_.rows(),
          fmt::format("{:.1f} s with rotors too slow to fly (on the ground) are left out",
                      static_cast<double>(count) * step_s_));
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
      add(name, "held", 0, c->size(),
          fmt::format("{:.0f} % of its samples repeat the one before (forward-filled): only new ones are used",
                      100.0 * share));
    else if (stuck)
      add(name, "frozen", end - longest, end + 1,
          fmt::format("stands still for {:.2f} s: not used there", static_cast<double>(longest) * step_s_));
    else return;
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

  // gyro against attitude, accelerometer and inputs against the motion, velocity against position
  void sensors() {
    if (column("wx") && column("wy") && column("wz") && column("qw") && column("qx") && column("qy") && column("qz"))
      gyro();
    if (judge_forces_)
      for (const ForceFault& fault : check_forces(log_, vehicle_)) {
        add(fault.column, fault.kind, 0, log_.rows(), fault.says);
        if (fault.sets_column_aside) drop("ax", "ay", "az");
      }
    velocity_frame();
  }

  // the gyro per sample of a reading of the log at its own rate
  std::vector<Vector3> gyro_of(const FlightLog& log, const FlightData& data) const {
    const auto &wx = *log.find("wx"), &wy = *log.find("wy"), &wz = *log.find("wz");
    std::vector<Vector3> rate;
    std::size_t row = 0;
    for (const Sample& sample : data.samples) {
      while (log.time_s[row] < sample.time_s) ++row;
      rate.emplace_back(wx[row], wy[row], wz[row]);
    }
    return rate;
  }

  void gyro() {
    FlightLog pose = log_;
    std::erase_if(pose.columns, [](const LogColumn& c) { return c.name == "wx" || c.name == "wy" || c.name == "wz"; });
    const FlightData data = prepare_flight(pose, vehicle_, {.linear_hold = false, .max_rate_hz = 1e6});
    const std::vector<Vector3> rates = gyro_of(log_, data);
    Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
    Vector3 rate_energy = Vector3::Zero(), gyro_energy = Vector3::Zero();
    for (std::size_t k = 0; k < rates.size(); ++k) {
      if (!rates[k].allFinite() || !(data.samples[k].channels & has_attitude)) continue;
      const Vector3& rate = data.motion[k].body_rate_B_radps;
      cross += rates[k] * rate.transpose();
      rate_energy += rate.cwiseAbs2();
      gyro_energy += rates[k].cwiseAbs2();
    }
    bool wrong = false;
    for (int i = 0; i < 3; ++i) {
      const double slope = cross(i, i) / (rate_energy[i] + 1e-300);
      const double agreement = cross(i, i) / std::sqrt(rate_energy[i] * gyro_energy[i] + 1e-300);
      const char* name = i == 0 ? "wx" : i == 1 ? "wy" : "wz";
      if (rate_energy[i] / static_cast<double>(log_.rows()) < 0.01) continue;
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

  // a board whose clock wanders against the pose's is laid on it where turning tells the time between them
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

std::vector<LogFinding> check_copies(const std::vector<FlightLog>& logs) {
  std::vector<LogFinding> found;
  for (std::size_t i = 0; i < logs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (logs[i].rows() != logs[j].rows() || logs[i].columns.size() != logs[j].columns.size()) continue;
      bool same = true;
      for (std::size_t c = 0; same && c < logs[i].columns.size(); ++c)
        same = std::equal(logs[i].columns[c].values.begin(), logs[i].columns[c].values.end(),
                          logs[j].columns[c].values.begin(),
                          [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); });
      if (!same) continue;
      const auto name = [](const FlightLog& log) { return log.path.substr(log.path.find_last_of('/') + 1); };
      found.push_back({name(logs[i]), "*", "duplicate", 0.0, logs[i].rows() ? logs[i].time_s.back() : 0.0,
                       fmt::format("is a copy of {}: set aside", name(logs[j])), true, false});
      break;
    }
  return found;
}

}  // namespace gustlab::diagnosis
