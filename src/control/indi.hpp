// Incremental nonlinear dynamic inversion: the Crazyflie firmware's cascade (controller_indi, position_controller_indi;
// Smeur, Chu, de Croon, JGCD 39(3) 2016; Smeur, de Croon, Chu, CEP 73 2018) and its flatness form (Tal & Karaman, TCST 29(3)
// 2021). What the sensors feel is filtered; what was commanded passes the same filter; the difference that is missing is
// added to what was commanded.
//
// The Crazyflie has the firmware's units and constants (counts of the motor scale). Any other vehicle has torque in N m and
// effectiveness from its own inertia, its nominal rotor lag, and gains no faster than its rotors allow.
#pragma once

#include "control/filters.hpp"
#include "control/legacy_mixer.hpp"
#include "control/low_level.hpp"
#include "control/rotor_lead.hpp"

namespace gustlab {

struct IndiOptions {
  double attitude_gain = 5.0;  // rate wanted per attitude error, 1/s
  double rate_gain = 24.0;     // angular acceleration wanted per rate error, 1/s
  double position_gain = 1.0;  // velocity wanted per position error, 1/s
  double velocity_gain = 5.0;  // acceleration wanted per velocity error, 1/s
  double filter_hz = 8.0;      // second-order Butterworth of every sensor and actuator
  double tilt_limit_rad = 10.0 * pi / 180.0;
};

// All gains times what a vehicle's rotors can follow, at most 1.
IndiOptions scaled(IndiOptions options, const VehicleModel& vehicle, LowLevel kind, double period_s);

// Inner loop: attitude error → rate → angular acceleration → increment of torque. Runs at the base rate.
class IndiAttitude {
 public:
  IndiAttitude() = default;
  IndiAttitude(const VehicleModel& vehicle, LowLevel kind, const IndiOptions& options, double period_s);

  void reset(const Observation& first);
  RotorCommand update(const Observation& observation, const ThrustAttitude& wanted);

 private:
  bool counts_ = false;  // the firmware's units
  IndiOptions options_;
  double period_s_ = 0.002;
  Mixer mixer_;
  RotorLead lead_;
  LegacyMixer legacy_;
  Matrix3 torque_per_acceleration_ = Matrix3::Zero();  // G1⁻¹, with G2 in yaw
  double yaw_g2_ = 0.0;
  Vector3 limit_ = Vector3::Zero();
  double actuator_follows_ = 1.0;

  LowPass2<Vector3> rate_, actuator_filter_;
  Vector3 actuator_ = Vector3::Zero();  // torque after the actuator model
  double last_yaw_increment_ = 0.0;
};

// Outer loop of the firmware: [Δφ, Δθ, ΔT] = G⁻¹ (a_ref − a_f), a_ref = K_v (K_p (p_ref − p) − v); no feed-forward.
class IndiPosition {
 public:
  IndiPosition() = default;
  IndiPosition(const VehicleModel& vehicle, LowLevel kind, const IndiOptions& options, double period_s);

  void reset(const Observation& first);
  ThrustAttitude update(const Observation& observation, const Reference& reference);

 private:
  bool counts_ = false;
  IndiOptions options_;
  double period_s_ = 0.002;
  double mass_kg_ = 1.0, gravity_mps2_ = 9.81;
  LegacyMixer legacy_;
  double acceleration_per_thrust_ = 1.0;  // K_thr: of one unit of the thrust command
  double most_thrust_ = 0.0;
  double actuator_follows_ = 1.0;

  LowPass2<Vector3> specific_force_, angles_rad_;
  LowPass2<double> thrust_filter_;
  double thrust_ = 0.0, wanted_thrust_ = 0.0;
  double last_yaw_rad_ = 0.0;
};

// Outer loop in flatness form: F = F_f + m (a_ref − a_f), a_ref = a_d − K_p e_p − K_v e_v. F_f is the estimated thrust
// vector through the same filter as the accelerometer.
class IndiForce {
 public:
  IndiForce() = default;
  IndiForce(const VehicleModel& vehicle, const IndiOptions& options, double bandwidth_radps, double damping,
            double period_s);

  void reset(const Observation& first);
  ThrustAttitude update(const Observation& observation, const Reference& reference);
  // what the rotors were told since
  void flown(const RotorCommand& command) { command_radps_ = command.speed_radps; }

 private:
  IndiOptions options_;
  double period_s_ = 0.002, k_p_ = 0.0, k_v_ = 0.0;
  double mass_kg_ = 1.0, gravity_mps2_ = 9.81;
  Mixer mixer_;
  double model_follows_ = 1.0;
  RotorArray command_radps_{}, model_speed_radps_{};
  LowPass2<Vector3> acceleration_, thrust_;
};

}  // namespace gustlab
