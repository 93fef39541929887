#include "autopilot.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

constexpr double kPeriod_s = 0.01;

Vec3 vee(const Mat3& m) { return {m(2, 1), m(0, 2), m(1, 0)}; }

template <class F>
Vec3 slope2(const F& f, double t, double h) {
  return (f(t + h) - 2 * f(t) + f(t - h)) / (h * h);
}

}  // namespace

Autopilot::Autopilot(const Truth& truth, const Path& path) : nominal_(truth.nominal), path_(path) {
  const double slowness_s =
      0.5 * (truth.lag_up_s + truth.lag_down_s) + truth.delay_s + 1.5 * kPeriod_s + 0.5 * truth.pose_delay_s;
  const double cap = nominal_.large ? 14 : 20;
  rate_gain_ = std::min(cap, 0.75 / slowness_s);
  yaw_gain_ = std::min(nominal_.large ? 3.0 : 6.0, 0.5 * rate_gain_);
  slow_gain_ = std::min(1.8, 0.5 * rate_gain_ / (5.0 + 12 * truth.pose_delay_s));
  climb_gain_ = std::min(4.0, 0.18 / slowness_s);
  for (int i = 0; i < kRotors; ++i) {
    const Vec3& hub = nominal_.hub_B_m[i];
    mixer_.col(i) << 1, hub.y(), -hub.x(), -nominal_.spin[i] * nominal_.torque_ratio_m;
  }
  mixer_ = mixer_.inverse().eval();
}

void Autopilot::estimate(const Reading& r) {
  if (!started_) {
    position_W_m_ = r.position_W_m;
    velocity_W_mps_ = r.velocity_W_mps;
    attitude_ = r.attitude;
    started_ = true;
    return;
  }
  attitude_ = (attitude_ * rotation(r.gyro_B_radps * kPeriod_s)).normalized();
  attitude_ = attitude_.slerp(0.12, r.attitude);
  position_W_m_ += kPeriod_s * velocity_W_mps_;
  velocity_W_mps_ += kPeriod_s * pushed_W_mps2_;
  position_W_m_ += 0.3 * (r.position_W_m - position_W_m_);
  velocity_W_mps_ += 0.25 * (r.velocity_W_mps - velocity_W_mps_);
}

Mat3 Autopilot::wanted_attitude(const Vec3& push_W_mps2, double yaw_rad) const {
  const Vec3 up = push_W_mps2.normalized();
  const Vec3 left = up.cross(Vec3(std::cos(yaw_rad), std::sin(yaw_rad), 0)).normalized();
  Mat3 wanted;
  wanted << left.cross(up), left, up;
  return wanted;
}

PerRotor Autopilot::mix(double thrust_N, const Vec3& torque_Nm) const {
  const double most_N = nominal_.thrust_coefficient * std::pow(nominal_.max_speed_radps, 2);
  const Eigen::Vector4d share_N = mixer_ * Eigen::Vector4d(thrust_N, torque_Nm.x(), torque_Nm.y(), torque_Nm.z());
  PerRotor speed;
  for (int i = 0; i < kRotors; ++i)
    speed[i] = std::sqrt(std::clamp(share_N[i], 0.02 * most_N, most_N) / nominal_.thrust_coefficient);
  return speed;
}

PerRotor Autopilot::command(double t, const Reading& reading) {
  estimate(reading);
  const auto& where = path_.position_W_m;
  const double step = 0.02;
  const Vec3 goal_W = where(t), goal_velocity_W = (where(t + step) - where(t - step)) / (2 * step);
  const Vec3 goal_push_W = slope2(where, t, step);
  const Vec3 error_W = goal_W - position_W_m_, error_velocity_W = goal_velocity_W - velocity_W_mps_;
  position_sum_ = (position_sum_ + kPeriod_s * error_W).cwiseMax(-0.8).cwiseMin(0.8);
  const double w = slow_gain_, wz = climb_gain_;
  const Vec3 kp(w * w, w * w, wz * wz), kv(1.8 * w, 1.8 * w, 1.8 * wz),
      ki = 0.3 * kp.cwiseProduct(Vec3(w, w, 0.5 * wz));
  Vec3 push_W =
      goal_push_W + kp.cwiseProduct(error_W) + kv.cwiseProduct(error_velocity_W) + ki.cwiseProduct(position_sum_);
  const double most = nominal_.large ? 9 : 8;
  push_W.head<2>() *= std::min(1.0, most / std::max(1e-9, push_W.head<2>().norm()));
  push_W.z() = std::clamp(push_W.z(), -6.0, 8.0) + kGravity_mps2;

  const double yaw = path_.yaw_rad(t);
  const Mat3 wanted = wanted_attitude(push_W, yaw), actual = attitude_.toRotationMatrix();
  const auto planned = [&](double a) {
    return wanted_attitude(slope2(where, a, step) + Vec3(0, 0, kGravity_mps2), path_.yaw_rad(a));
  };
  const Vec3 wanted_rate = vee(planned(t).transpose() * (planned(t + step) - planned(t - step)) / (2 * step));
  const Vec3 error = 0.5 * vee(wanted.transpose() * actual - actual.transpose() * wanted);
  const Vec3 rate_error = reading.gyro_B_radps - actual.transpose() * wanted * wanted_rate;
  attitude_sum_ = (attitude_sum_ + kPeriod_s * error).cwiseMax(-0.4).cwiseMin(0.4);
  const Vec3 rate_gain(rate_gain_, rate_gain_, yaw_gain_);
  const Vec3 stiffness = 0.26 * rate_gain.cwiseProduct(rate_gain);
  const Vec3 spin = -stiffness.cwiseProduct(error) - rate_gain.cwiseProduct(rate_error) -
                    0.22 * rate_gain.cwiseProduct(stiffness).cwiseProduct(attitude_sum_) + path_.shake_radps2(t);
  const Vec3& inertia = nominal_.inertia_kgm2;
  const Vec3 torque =
      inertia.cwiseProduct(spin) + reading.gyro_B_radps.cross(inertia.cwiseProduct(reading.gyro_B_radps));
  const double thrust = nominal_.mass_kg * (push_W.dot(actual.col(2)) + path_.surge_mps2(t));
  pushed_W_mps2_ = thrust / nominal_.mass_kg * actual.col(2) - Vec3(0, 0, kGravity_mps2);
  return mix(thrust, torque);
}

}  // namespace reality
