#include "flight.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBurst_s = 3.0;  // correlation time of the envelope of gusty air

// battery: open-circuit voltage falls with time, load pulls it down further
class Battery {
 public:
  Battery(const Nominal& n, Rng& rng)
      : full_V_(n.nominal_voltage_V * rng.uniform(1.04, 1.08)),
        fall_Vps_(n.nominal_voltage_V * rng.uniform(0.0025, 0.004)),
        drop_V_(n.nominal_voltage_V * rng.uniform(0.03, 0.05)),
        hover_(std::pow(n.hover_speed_radps(), 3)) {}
  double at(double time_s, const PerRotor& speed) const {
    double load = 0;
    for (const double s : speed) load += s * s * s / (kRotors * hover_);
    return full_V_ - fall_Vps_ * (time_s + kPreroll_s) - drop_V_ * load;
  }

 private:
  double full_V_, fall_Vps_, drop_V_, hover_;
};

// everything exogenous that pushes the body
class Air {
 public:
  Air(const Truth& truth, const Noise& noise, std::uint64_t seed, std::uint64_t trial, std::uint64_t stream)
      : truth_(truth),
        bursts_(noise.bursts),
        rng_(seed, trial, stream + 1),
        gust_rng_(seed, trial, stream + 2),
        burst_rng_(seed, trial, stream + 3),
        burst_(bursts_, kBurst_s, burst_rng_) {
    for (int i = 0; i < 3; ++i) {
      push_.emplace_back(noise.air_mps2 * truth.nominal.mass_kg, noise.air_time_s, rng_);
      twist_.emplace_back(noise.torque_radps2[i] * truth.nominal.inertia_kgm2[i], noise.torque_time_s, rng_);
      gust_.emplace_back(i < 2 ? truth.gust_xy_N : truth.gust_z_N, truth.gust_time_s, gust_rng_);
    }
    phase_x_ = gust_rng_.uniform(0, 2 * std::numbers::pi);
    phase_y_ = gust_rng_.uniform(0, 2 * std::numbers::pi);
    next_drop_s_ = gust_rng_.uniform(0.5, 2.5);
    drop_until_s_ = -100;
  }
  void advance(double time_s, double step_s) {
    for (auto& p : push_) p.advance(step_s, rng_);
    for (auto& p : twist_) p.advance(step_s, rng_);
    for (auto& p : gust_) p.advance(step_s, gust_rng_);
    burst_.advance(step_s, burst_rng_);
    if (time_s > next_drop_s_) {
      drop_until_s_ = time_s + gust_rng_.uniform(0.08, 0.3);
      next_drop_s_ = drop_until_s_ + gust_rng_.uniform(0.6, 3.0);
    }
  }
  void fill(Drive& d, double time_s) const {
    // the mean of the envelope's square is one
    const double envelope = std::exp(burst_.value() - bursts_ * bursts_);
    for (int i = 0; i < 3; ++i) {
      d.force_W_N[i] = envelope * push_[i].value() + gust_[i].value();
      d.torque_B_Nm[i] = envelope * twist_[i].value();
    }
    d.force_W_N.x() += truth_.line_N * std::sin(truth_.line_radps * time_s + phase_x_);
    d.force_W_N.y() += truth_.line_N * std::sin(truth_.line_radps * time_s + phase_y_);
    d.rotor_factor = time_s < drop_until_s_ ? 1 - truth_.outside.dropout_loss : 1;
  }

 private:
  const Truth& truth_;
  double bursts_;
  Rng rng_, gust_rng_, burst_rng_;
  Wander burst_;
  std::vector<Wander> push_, twist_, gust_;
  double phase_x_, phase_y_, next_drop_s_, drop_until_s_;
};

// the past of the body, for sensors that look back
struct Past {
  double time_s;
  Motion m;
};

Motion between(const std::vector<Past>& past, double time_s) {
  auto after = std::lower_bound(past.begin(), past.end(), time_s, [](const Past& p, double t) { return p.time_s < t; });
  if (after == past.end()) --after;
  if (after == past.begin()) return after->m;
  const Past& a = *(after - 1);
  const Past& b = *after;
  const double f = (time_s - a.time_s) / (b.time_s - a.time_s);
  Motion m = b.m;
  m.com_W_m = a.m.com_W_m + f * (b.m.com_W_m - a.m.com_W_m);
  m.velocity_W_mps = a.m.velocity_W_mps + f * (b.m.velocity_W_mps - a.m.velocity_W_mps);
  m.rate_B_radps = a.m.rate_B_radps + f * (b.m.rate_B_radps - a.m.rate_B_radps);
  m.attitude = a.m.attitude.slerp(f, b.m.attitude);
  return m;
}

// forces with a memory of their own, which no change of the vehicle's numbers reproduces
struct Push {
  Vec3 force_W_N, torque_B_Nm;
};
Push hidden_push(const Truth& truth, const State& x, const Drive& drive) {
  const Motion m = motion(truth, x, drive.speed_radps);
  Drive steady = drive;
  steady.rotor_factor = 1;
  const Wrench with = wrench(truth, m, drive), without = wrench(truth, m, steady);
  const Wrench stem = payload_wrench(truth, x);
  return {cable_force_W(truth, x, drive) + m.attitude * (stem.force_B_N + with.force_B_N - without.force_B_N),
          stem.torque_B_Nm + with.torque_B_Nm - without.torque_B_Nm};
}

bool sane(const State& x, const Motion& m, const Path& path, double time_s, const Truth& truth) {
  const double reach_m = truth.nominal.large ? 5.0 : 1.2;
  if (!((m.com_W_m - path.position_W_m(time_s)).norm() < reach_m)) return false;
  if ((m.attitude * Vec3::UnitZ()).z() < 0.2) return false;
  // no pilot lets a load swing beyond seventy degrees
  if (truth.load_kg > 0 && x[15] - m.com_W_m.z() > -0.34 * truth.load_length_m) return false;
  const Surroundings& s = truth.surroundings;
  const double size_m = truth.nominal.radius_m;
  if (s.ground_z_m && m.com_W_m.z() < *s.ground_z_m + size_m) return false;
  if (s.ceiling_z_m && m.com_W_m.z() > *s.ceiling_z_m - size_m) return false;
  return !s.wall || (m.com_W_m.head<2>() - s.wall->point_W_m).dot(s.wall->normal_W) > 1.5 * size_m;
}

}  // namespace

Noise noise_level(bool large, int level) {
  const double k = level == 1 ? 1 : 2.5;
  Noise n;
  n.position_m = 0.0004 * k;
  n.attitude_rad = 0.1 * kDegree * k;
  n.velocity_mps = 0.006 * k;
  n.gyro_radps = (large ? 0.008 : 0.015) * k;
  n.accel_mps2 = 0.08 * k;
  n.voltage_V = 0.001 * (large ? 11 : 4) * k;
  n.gyro_bias_radps = 0.01;
  n.accel_bias_mps2 = 0.05;
  n.air_mps2 = level == 1 ? 0.07 : 0.14;
  n.air_time_s = 0.15;
  n.torque_radps2 = (large ? Vec3(0.12, 0.12, 0.04) : Vec3(0.8, 0.8, 0.25)) * (level == 1 ? 1 : 2);
  n.torque_time_s = 0.07;
  return n;
}

void set_air(Noise& noise, bool large, double roughness, AirKind kind) {
  const Noise room = noise_level(large, 1);
  noise.air_mps2 = roughness * room.air_mps2;
  noise.torque_radps2 = roughness * room.torque_radps2;
  if (kind == AirKind::gusty) noise.bursts = 0.6;
  if (kind == AirKind::outdoor) {
    noise.air_time_s = 0.6;
    noise.torque_time_s = 0.15;
  }
}

Reading sense(const Truth& truth, const Motion& m, const Acceleration& a) {
  const Mat3 R = m.attitude.toRotationMatrix();
  const Vec3 &w = m.rate_B_radps, &c = truth.com_B_m, arm = truth.imu_lever_m - c;
  Reading r;
  r.position_W_m = m.com_W_m - R * c;
  r.velocity_W_mps = m.velocity_W_mps - R * w.cross(c);
  r.attitude = m.attitude * rotation(truth.attitude_offset_rad);
  r.gyro_B_radps = (1 + truth.gyro_scale) * w;
  r.specific_B_mps2 = a.specific_B_mps2 + a.angular_B_radps2.cross(arm) + w.cross(w.cross(arm));
  return r;
}

Flight fly(const Truth& truth, const Path& path, const Noise& noise, std::uint64_t seed, std::uint64_t trial,
           std::uint64_t stream) {
  Rng sensor(seed, trial, stream);
  Air air(truth, noise, seed, trial, stream);
  const Nominal& nominal = truth.nominal;
  const Battery battery(nominal, sensor);
  const Vec3 gyro_bias = noise.gyro_bias_radps * sensor.normal3(),
             accel_bias = noise.accel_bias_mps2 * sensor.normal3();
  const double step_s = nominal.large ? 1e-3 : 5e-4;
  const int steps = static_cast<int>(std::lround(kSample_s / step_s));
  const int first = -static_cast<int>(std::lround(kPreroll_s / kSample_s));
  const int last = static_cast<int>(std::lround(kFlight_s / kSample_s));

  const bool hidden = truth.load_kg > 0 || truth.outside.payload_kg > 0 || truth.outside.dropout_rotor >= 0;
  Flight flight;
  const double hover = nominal.hover_speed_radps();
  flight.start_radps = {hover, hover, hover, hover};
  RotorChain chain(truth, flight.start_radps);
  Autopilot pilot(truth, path);
  Motion m;
  m.com_W_m = path.position_W_m(first * kSample_s);
  m.velocity_W_mps = Vec3::Zero();
  m.rate_B_radps = Vec3::Zero();
  m.attitude = rotation(Vec3(0, 0, path.yaw_rad(first * kSample_s)));
  Drive here;
  here.speed_radps = flight.start_radps;
  here.voltage_V = battery.at(first * kSample_s, here.speed_radps);
  here.time_s = first * kSample_s;
  air.fill(here, here.time_s);
  State x = state_of(truth, m, here.speed_radps);
  std::vector<Past> past;
  Reading previous;
  for (int k = first; k < last; ++k) {
    const double t = k * kSample_s;
    m = motion(truth, x, here.speed_radps);
    if (!sane(x, m, path, t, truth)) {
      flight.lost = true;
      return flight;
    }
    if (past.empty()) past.push_back({t, m});
    Reading r = sense(truth, m, acceleration(truth, x, here));
    if (truth.pose_delay_s > 0) {
      const Reading old = sense(truth, between(past, t - truth.pose_delay_s), {Vec3::Zero(), Vec3::Zero()});
      r.position_W_m = old.position_W_m;
      r.velocity_W_mps = old.velocity_W_mps;
      r.attitude = old.attitude;
    }
    r.position_W_m += noise.position_m * sensor.normal3();
    r.velocity_W_mps += noise.velocity_mps * sensor.normal3();
    r.attitude = r.attitude * rotation(noise.attitude_rad * sensor.normal3());
    r.gyro_B_radps += gyro_bias + noise.gyro_radps * sensor.normal3();
    r.specific_B_mps2 += accel_bias + noise.accel_mps2 * sensor.normal3();
    if (k == first) previous = r;
    const PerRotor command = pilot.command(t, previous);
    previous = r;
    flight.tape.time_s.push_back(t);
    flight.tape.speed_radps.push_back(command);
    const double volts = here.voltage_V + noise.voltage_V * sensor.normal();
    if (k >= 0) flight.sample.push_back({t, r, command, volts, m, x, here.voltage_V, Vec3::Zero(), Vec3::Zero()});

    for (int i = 0; i < steps; ++i) {
      const double a = t + i * step_s, b = i + 1 == steps ? (k + 1) * kSample_s : t + (i + 1) * step_s;
      here.speed_radps = chain.at(a, flight.tape);
      Drive middle = here, end = here;
      middle.time_s = 0.5 * (a + b);
      middle.speed_radps = chain.at(middle.time_s, flight.tape);
      end.time_s = b;
      end.speed_radps = chain.at(b, flight.tape);
      end.voltage_V = battery.at(b, end.speed_radps);
      middle.voltage_V = 0.5 * (here.voltage_V + end.voltage_V);
      if (k >= 0 && hidden) {
        const Push push = hidden_push(truth, x, here);
        flight.sample.back().extra_force_W_N += push.force_W_N / steps;
        flight.sample.back().extra_torque_B_Nm += push.torque_B_Nm / steps;
      }
      x = advance(truth, x, here, middle, end, step_s);
      air.advance(b, step_s);
      air.fill(end, b);
      here = end;
      if (truth.pose_delay_s > 0) past.push_back({b, motion(truth, x, here.speed_radps)});
    }
  }
  return flight;
}

}  // namespace reality
