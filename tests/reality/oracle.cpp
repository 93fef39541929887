#include "oracle.hpp"

#include <array>
#include <cmath>

namespace reality {
namespace {

constexpr std::array<int, 3> kHorizon{10, 50, 100};  // samples
constexpr double kStep_s = 0.0025;
constexpr int kSteps = 4;

// the reading of a motion with its pose seen late by the truth's delay
Reading late_reading(const Truth& truth, const Motion& now, const Vec3& acceleration_W_mps2) {
  Motion late = now;
  late.com_W_m -= truth.pose_delay_s * now.velocity_W_mps;
  late.velocity_W_mps -= truth.pose_delay_s * acceleration_W_mps2;
  late.attitude = now.attitude * rotation(-truth.pose_delay_s * now.rate_B_radps);
  Reading r = sense(truth, late, {Vec3::Zero(), Vec3::Zero()});
  r.gyro_B_radps = (1 + truth.gyro_scale) * now.rate_B_radps;
  return r;
}

// what a model without knowledge of the sensors takes a reading for
Motion believed(const Truth& model, const Reading& r) {
  Motion m;
  m.attitude = r.attitude;
  m.rate_B_radps = r.gyro_B_radps;
  m.velocity_W_mps = r.velocity_W_mps + r.attitude * m.rate_B_radps.cross(model.com_B_m);
  m.com_W_m = r.position_W_m + r.attitude * model.com_B_m;
  return m;
}

std::vector<PerRotor> fine_speeds(const Truth& truth, const Flight& flight, double until_s) {
  RotorChain chain(truth, flight.start_radps);
  for (const double t : flight.tape.time_s)
    if (t < 0) chain.at(t, flight.tape);
  std::vector<PerRotor> speed;
  for (int i = 0; i * 0.5 * kStep_s <= until_s; ++i) speed.push_back(chain.at(i * 0.5 * kStep_s, flight.tape));
  return speed;
}

using Errors = std::array<std::array<double, 3>, 4>;  // position, velocity, attitude, rate at each horizon

Errors rollouts(const Truth& model, const Truth& truth, const Flight& flight, bool informed) {
  const auto speed = fine_speeds(model, flight, kFlight_s);
  const auto count = static_cast<int>(flight.sample.size());
  const auto reading_at = [&](int k) {
    const auto& s = flight.sample;
    const int a = std::max(0, k - 1), b = std::min(count - 1, k + 1);
    const Vec3 acceleration =
        (s[static_cast<std::size_t>(b)].clean.velocity_W_mps - s[static_cast<std::size_t>(a)].clean.velocity_W_mps) /
        ((b - a) * kSample_s);
    return late_reading(truth, s[static_cast<std::size_t>(k)].clean, acceleration);
  };
  Errors sum{};
  int windows = 0;
  for (int k = 0; k + kHorizon.back() < count; k += kHorizon.back(), ++windows) {
    const auto node = [&](int i) {
      Drive d;
      d.speed_radps = speed[static_cast<std::size_t>(i)];
      d.time_s = i * 0.5 * kStep_s;
      d.voltage_V = flight.sample[static_cast<std::size_t>(std::min(count - 1, i / (2 * kSteps)))].clean_voltage_V;
      return d;
    };
    int i = 2 * kSteps * k;
    const PerRotor& first = speed[static_cast<std::size_t>(i)];
    State x = informed ? flight.sample[static_cast<std::size_t>(k)].state
                       : state_of(model, believed(model, reading_at(k)), first);
    std::size_t h = 0;
    Vec3 before_W_mps = motion(model, x, first).velocity_W_mps;
    for (int n = 1; n <= kHorizon.back(); ++n) {
      for (int j = 0; j < kSteps; ++j, i += 2) x = advance(model, x, node(i), node(i + 1), node(i + 2), kStep_s);
      const Motion m = motion(model, x, speed[static_cast<std::size_t>(i)]);
      const Vec3 acceleration = (m.velocity_W_mps - before_W_mps) / kSample_s;
      before_W_mps = m.velocity_W_mps;
      if (n != kHorizon[h]) continue;
      const Reading got = late_reading(model, m, acceleration), wanted = reading_at(k + n);
      sum[0][h] += (got.position_W_m - wanted.position_W_m).norm();
      sum[1][h] += (got.velocity_W_mps - wanted.velocity_W_mps).norm();
      sum[2][h] += got.attitude.angularDistance(wanted.attitude);
      sum[3][h] += (got.gyro_B_radps - wanted.gyro_B_radps).norm();
      ++h;
    }
  }
  for (auto& row : sum)
    for (double& value : row) value /= windows;
  return sum;
}

}  // namespace

nlohmann::ordered_json oracle(const Truth& before, const Truth& after, const Flight& flight) {
  const Errors blind = rollouts(before, after, flight, false), informed = rollouts(after, after, flight, true);
  nlohmann::ordered_json json;
  json["horizon_s"] = {0.1, 0.5, 1.0};
  const char* name[] = {"position_m", "velocity_mps", "attitude_rad", "body_rate_radps"};
  for (std::size_t i = 0; i < 4; ++i) json[name[i]] = {{"before", blind[i]}, {"after", informed[i]}};
  return json;
}

}  // namespace reality
