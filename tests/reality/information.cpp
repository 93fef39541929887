#include "information.hpp"

#include <cmath>

namespace reality {
namespace {

constexpr int kNodes = 5;   // rotor speeds per sample interval: two steps of order four
constexpr int kState = 18;  // p, v, attitude, rate, force (as acceleration, W), torque (as acceleration, B)
constexpr int kBiases = 6;
constexpr int kMost = 15;
using Readout = Eigen::Matrix<double, kMost, 1>;
using Error = Eigen::Matrix<double, 12, 1>;
using Cov = Eigen::Matrix<double, kState, kState>;

Mat3 cross(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Vec3 turned(const Quat& to, const Quat& from) {
  const Quat d = from.conjugate() * to;
  return 2 * (d.w() < 0 ? -1 : 1) * d.vec();
}

// one sample interval, without turbulence
struct Leap {
  Motion end;
  Acceleration start;
};
Leap leap(Truth truth, const Sample& s, const std::array<PerRotor, kNodes>& speed) {
  truth.load_kg = 0;
  Drive node[kNodes];
  for (int j = 0; j < kNodes; ++j) {
    node[j].speed_radps = speed[j];
    node[j].voltage_V = s.clean_voltage_V;
    node[j].time_s = s.time_s + j * kSample_s / (kNodes - 1);
  }
  State x = state_of(truth, s.clean, speed[0]);
  Leap result;
  result.start = acceleration(truth, x, node[0]);
  for (int j = 0; j + 2 < kNodes; j += 2) x = advance(truth, x, node[j], node[j + 1], node[j + 2], 0.5 * kSample_s);
  result.end = motion(truth, x, speed[kNodes - 1]);
  return result;
}

Readout read(const Truth& truth, const Motion& now, const Acceleration& a) {
  // a late pose is the pose now, moved back along its rates
  Motion late = now;
  late.com_W_m -= truth.pose_delay_s * now.velocity_W_mps;
  late.velocity_W_mps -= truth.pose_delay_s * (now.attitude * a.specific_B_mps2 - Vec3(0, 0, kGravity_mps2));
  late.attitude = now.attitude * rotation(-truth.pose_delay_s * now.rate_B_radps);
  const Reading pose = sense(truth, late, a), inertial = sense(truth, now, a);
  Readout y;
  y << pose.position_W_m, pose.velocity_W_mps, turned(pose.attitude, now.attitude), inertial.gyro_B_radps,
      inertial.specific_B_mps2;
  return y;
}

// speeds at the nodes of every interval, from the whole tape
std::vector<std::array<PerRotor, kNodes>> node_speeds(const Truth& truth, const Flight& flight) {
  RotorChain chain(truth, flight.start_radps);
  std::vector<std::array<PerRotor, kNodes>> all(flight.sample.size());
  for (const double t : flight.tape.time_s) {
    const auto k = static_cast<long>(std::lround(t / kSample_s));
    for (int j = 0; j < kNodes; ++j) {
      const PerRotor& speed = chain.at(t + j * kSample_s / (kNodes - 1) - (j ? 2e-10 : 0), flight.tape);
      if (k >= 0) all[static_cast<std::size_t>(k)][j] = speed;
    }
  }
  return all;
}

struct Filter {
  Cov covariance = Cov::Zero();
  Eigen::Matrix<double, kState, Eigen::Dynamic> error;  // per probe and bias: truth minus estimate
};

void predict(Filter& f, const Motion& m, const Vec3& specific_B, const Noise& noise) {
  const double dt = kSample_s;
  const Mat3 R = m.attitude.toRotationMatrix(), I = Mat3::Identity();
  Cov F = Cov::Identity();
  const Mat3 tilt = -R * cross(specific_B);
  F.block<3, 3>(0, 3) = dt * I;
  F.block<3, 3>(0, 6) = 0.5 * dt * dt * tilt;
  F.block<3, 3>(0, 12) = 0.5 * dt * dt * I;
  F.block<3, 3>(3, 6) = dt * tilt;
  F.block<3, 3>(3, 9) = 0.5 * dt * dt * tilt;
  F.block<3, 3>(3, 12) = dt * I;
  F.block<3, 3>(6, 6) = I - dt * cross(m.rate_B_radps);
  F.block<3, 3>(6, 9) = dt * I;
  F.block<3, 3>(6, 15) = 0.5 * dt * dt * I;
  F.block<3, 3>(9, 15) = dt * I;
  const double keep_force = std::exp(-dt / noise.air_time_s), keep_torque = std::exp(-dt / noise.torque_time_s);
  F.block<3, 3>(12, 12) = keep_force * I;
  F.block<3, 3>(15, 15) = keep_torque * I;
  f.covariance = F * f.covariance * F.transpose();
  for (int i = 0; i < 3; ++i) {
    f.covariance(12 + i, 12 + i) += std::pow(noise.air_mps2, 2) * (1 - keep_force * keep_force);
    f.covariance(15 + i, 15 + i) += std::pow(noise.torque_radps2[i], 2) * (1 - keep_torque * keep_torque);
  }
  f.error = (F * f.error).eval();
}

}  // namespace

Information information(const std::vector<const Flight*>& flights, const std::vector<Truth>& base,
                        const std::vector<Probe>& probes, const Columns& columns, const Noise& noise) {
  const auto count = static_cast<Eigen::Index>(probes.size());
  std::vector<int> rows;
  for (int i = 0; i < kMost; ++i)
    if ((i < 3 || i >= 6 || columns.velocity) && (i < 12 || columns.accel)) rows.push_back(i);
  const auto height = static_cast<Eigen::Index>(rows.size());
  Readout sigma;
  sigma << Vec3::Constant(noise.position_m), Vec3::Constant(noise.velocity_mps), Vec3::Constant(noise.attitude_rad),
      Vec3::Constant(noise.gyro_radps), Vec3::Constant(noise.accel_mps2);

  Information result;
  result.matrix = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t n = 0; n < flights.size(); ++n) {
    const Flight& flight = *flights[n];
    const Truth& truth = base[n];
    const auto speed = node_speeds(truth, flight);
    std::vector<std::vector<std::array<PerRotor, kNodes>>> other_speed;
    for (const Probe& p : probes)
      other_speed.push_back(p.push.empty() ? node_speeds(p.changed[n], flight)
                                           : std::vector<std::array<PerRotor, kNodes>>{});
    Filter f;
    Eigen::Matrix<double, kState, 1> start;
    start << Vec3::Constant(1), Vec3::Constant(1), Vec3::Constant(0.3), Vec3::Constant(3),
        Vec3::Constant(noise.air_mps2), noise.torque_radps2;
    f.covariance.diagonal() = start.cwiseAbs2();
    f.error.setZero(kState, count + kBiases);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count + kBiases, count + kBiases);
    for (std::size_t k = 0; k < flight.sample.size(); ++k) {
      const Sample& s = flight.sample[k];
      const Leap plain = leap(truth, s, speed[k]);
      const Readout reads = read(truth, s.clean, plain.start);
      Eigen::Matrix<double, kMost, Eigen::Dynamic> direct = decltype(direct)::Zero(kMost, count + kBiases);
      Eigen::Matrix<double, 12, Eigen::Dynamic> drift = decltype(drift)::Zero(12, count);
      for (Eigen::Index p = 0; p < count; ++p) {
        const Probe& probe = probes[static_cast<std::size_t>(p)];
        if (!probe.push.empty()) {
          const auto& push = probe.push[n][k];
          const Vec3 a = push.head<3>() / truth.mass_kg, w = push.tail<3>().cwiseQuotient(truth.inertia_kgm2);
          drift.col(p) << 0.5 * kSample_s * kSample_s * a, kSample_s * a, 0.5 * kSample_s * kSample_s * w,
              kSample_s * w;
          direct.col(p).tail<3>() = s.clean.attitude.conjugate() * a;
          continue;
        }
        const Truth& changed = probe.changed[n];
        const Leap other = leap(changed, s, other_speed[static_cast<std::size_t>(p)][k]);
        drift.col(p) << other.end.com_W_m - plain.end.com_W_m, other.end.velocity_W_mps - plain.end.velocity_W_mps,
            turned(other.end.attitude, plain.end.attitude), other.end.rate_B_radps - plain.end.rate_B_radps;
        drift.col(p) /= probe.step;
        direct.col(p) = (read(changed, s.clean, other.start) - reads) / probe.step;
      }
      direct.block<3, 3>(9, count) = Mat3::Identity();
      direct.block<3, 3>(12, count + 3) = Mat3::Identity();

      Eigen::Matrix<double, kMost, kState> all = Eigen::Matrix<double, kMost, kState>::Zero();
      all.block<12, 12>(0, 0).setIdentity();
      all.block<3, 3>(12, 12) = s.clean.attitude.toRotationMatrix().transpose();
      Eigen::MatrixXd H(height, kState), seen(height, count + kBiases), S;
      for (Eigen::Index i = 0; i < height; ++i) {
        H.row(i) = all.row(rows[static_cast<std::size_t>(i)]);
        seen.row(i) = direct.row(rows[static_cast<std::size_t>(i)]);
      }
      const Eigen::MatrixXd PH = f.covariance * H.transpose();
      S = H * PH;
      for (Eigen::Index i = 0; i < height; ++i) S(i, i) += std::pow(sigma[rows[static_cast<std::size_t>(i)]], 2);
      const Eigen::LLT<Eigen::MatrixXd> factor(S);
      const Eigen::MatrixXd innovation = H * f.error + seen;
      const Eigen::MatrixXd white = factor.matrixL().solve(innovation);
      gram.noalias() += white.transpose() * white;
      const Eigen::MatrixXd half = factor.matrixL().solve(PH.transpose());
      f.error -= half.transpose() * white;
      f.covariance -= half.transpose() * half;
      result.samples += static_cast<double>(height);

      predict(f, s.clean, plain.start.specific_B_mps2, noise);
      f.error.topLeftCorner(12, count) += drift;
    }
    // unknown biases cost information
    const Eigen::MatrixXd own = gram.topLeftCorner(count, count), with = gram.topRightCorner(count, kBiases);
    Eigen::MatrixXd bias = gram.bottomRightCorner(kBiases, kBiases);
    bias.diagonal().array() += 1e-9;
    result.matrix += own - with * bias.ldlt().solve(with.transpose());
  }
  return result;
}

}  // namespace reality
