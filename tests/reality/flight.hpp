// one flight: world, sensors and autopilot together
#pragma once

#include <string>
#include <vector>

#include "autopilot.hpp"
#include "body.hpp"
#include "rotors.hpp"

namespace reality {

constexpr double kSample_s = 0.01;

/// How loud the sensors and the air are (standard deviations).
struct Noise {
  double position_m, attitude_rad, velocity_mps, gyro_radps, accel_mps2, voltage_V;
  double gyro_bias_radps, accel_bias_mps2;
  double air_mps2, air_time_s;  // turbulence as acceleration of the nominal mass
  Vec3 torque_radps2;           // the same for torques
  double torque_time_s;
  double bursts = 0;  // standard deviation of the logarithm of the turbulence's envelope
};
Noise noise_level(bool large, int level);

/// What moves the air. All kinds have the same standard deviation at the same roughness.
enum class AirKind { steady, gusty, outdoor };

/// Air whose turbulence is `roughness` times that of the quiet room of noise level 1: steady keeps its times; gusty comes in
/// bursts of some seconds; outdoor has longer times, as a wind has.
void set_air(Noise& noise, bool large, double roughness, AirKind kind);

/// which optional columns the log has
struct Columns {
  bool velocity = true, accel = false, voltage = false;
};

struct Sample {
  double time_s;
  Reading reading;  // as logged: noise, bias and sensor effects included
  PerRotor command_radps;
  double voltage_V;  // as logged
  Motion clean;      // truth, for sensitivities and the oracle only
  State state;       // the same with everything hidden
  double clean_voltage_V;
  Vec3 extra_force_W_N;  // mean over the following interval: cable, payload, drop-outs
  Vec3 extra_torque_B_Nm;
};

struct Flight {
  std::vector<Sample> sample;
  CommandTape tape;  // includes the time before the recording
  PerRotor start_radps{};
  bool lost = false;  // crashed, flew away, or cut a cable
};

/// Flies one path; every draw comes from (seed, trial, stream).
Flight fly(const Truth& truth, const Path& path, const Noise& noise, std::uint64_t seed, std::uint64_t trial,
           std::uint64_t stream);

/// Noise-free readings of a motion; delays are not applied here.
Reading sense(const Truth& truth, const Motion& m, const Acceleration& a);

}  // namespace reality
