// Offboard controllers: a force law at its own rate, which sees late and guesses the thrust, over the low-level loops.
//
// Offboard<Law> is a Controller. A Law is a plain class with
//   void visit(ParameterVisitor&)                              its parameters
//   void reset(const OffboardSetup&)                           throws ParameterError
//   Vector3 update(const OffboardInput&)                       force that the rotors should push with, world axes, N
//   std::vector<std::string_view> telemetry_names() const, void telemetry(std::span<double>) const
#pragma once

#include <optional>

#include "control/filters.hpp"
#include "control/low_level.hpp"
#include "control/rotors.hpp"
#include "gustlab/controller.hpp"

namespace gustlab {

// What every offboard law shares.
struct OffboardOptions {
  std::string low_level = "auto";
  double rate_hz = 50.0;
  double delay_s = 0.0;
  std::string thrust_estimate = "command", thrust_until = "arrival";
  double bandwidth_radps = 0.0;
  double damping = 1.0;
  double tilt_limit_deg = 30.0;
  bool feedforward = true;
  void visit(ParameterVisitor& visitor);
};

struct OffboardSetup {
  VehicleModel vehicle;
  double period_s = 0.02;        // of the law
  double bandwidth_radps = 1.6;  // of the position error's PD
  double damping = 1.0;          // likewise
  double tilt_limit_rad = 0.5;
};

struct OffboardInput {
  double time_s = 0.0;
  Observation seen;  // delayed
  Reference reference;
  Vector3 position_error_W_m;           // e_p = p − p_d
  Vector3 velocity_error_W_mps;         // e_v = v − v_d
  Vector3 acceleration_command_W_mps2;  // a_cmd = a_d − K_p e_p − K_v e_v
  // both over the same interval, that between the last two poses seen
  Vector3 acceleration_W_mps2;  // a_meas, finite difference of the velocity
  Vector3 thrust_W_N;           // u_prev, mean of the estimated thrust vector
  Vector3 thrust_now_W_N;       // the estimate of this instant
  double age_s = 0.0;           // of the pose, by its time stamp
  Vector3 impulse_since_W_Ns;   // of the estimated thrust since then
};

// The part of an offboard controller that does not depend on its law.
class OffboardFrame {
 public:
  double base_rate_hz(const OffboardOptions& options, const VehicleModel& vehicle) const;
  // Returns what the law needs to know. Throws ParameterError.
  OffboardSetup reset(const OffboardOptions& options, const ControllerSetup& setup, const Observation& first);

  // Every base tick, first: remembers, and when the law's turn has come, says so and fills the input.
  bool observe(const Observation& observation, const Reference& reference, OffboardInput& input);
  // The law's answer.
  void command(const Vector3& force_W_N, const Quaternion& seen_attitude_WB, double yaw_rad);
  // Every base tick, last.
  RotorCommand update(const Observation& observation);

 private:
  Vector3 impulse_until(double age_s) const;

  struct Moment {
    Observation observation;
    Vector3 impulse_W_Ns = Vector3::Zero();  // of the estimated thrust, from the start to its pose
  };

  VehicleModel vehicle_;
  Mixer mixer_;
  std::unique_ptr<LowLevelLoop> loop_;
  double period_s_ = 0.002;
  int ticks_ = 1, tick_ = 0;
  double k_p_ = 0.0, k_v_ = 0.0;
  double tilt_limit_rad_ = 0.5;
  bool from_rotor_speed_ = false, until_stamp_ = false, feedforward_ = true;

  // the last few moments, for the delay
  std::vector<Moment> ring_;
  std::size_t newest_ = 0;
  Vector3 impulse_W_Ns_ = Vector3::Zero(), pose_impulse_W_Ns_ = Vector3::Zero();
  std::vector<Vector3> past_impulses_W_Ns_;  // ring, one for each base tick
  std::size_t present_ = 0;
  double pose_time_s_ = 0.0;
  double model_follows_ = 1.0;
  RotorArray model_speed_radps_{};
  RotorArray command_radps_{};

  // the last pose that was new
  std::optional<Moment> last_;
  Vector3 acceleration_W_mps2_ = Vector3::Zero();
  Vector3 thrust_W_N_ = Vector3::Zero();
};

template <class Law>
class Offboard final : public Controller {
 public:
  void visit(ParameterVisitor& visitor) override {
    options_.visit(visitor);
    law_.visit(visitor);
  }
  double rate_hz(const VehicleModel& vehicle) const override { return frame_.base_rate_hz(options_, vehicle); }
  void reset(const ControllerSetup& setup, const Observation& first) override {
    law_.reset(frame_.reset(options_, setup, first));
  }
  RotorCommand update(const Observation& observation, const Reference& reference) override {
    if (frame_.observe(observation, reference, input_))
      frame_.command(law_.update(input_), input_.seen.attitude_WB, reference.yaw_rad);
    return frame_.update(observation);
  }
  std::vector<std::string_view> telemetry_names() const override { return law_.telemetry_names(); }
  void telemetry(std::span<double> out) const override { law_.telemetry(out); }

 private:
  OffboardOptions options_;
  Law law_;
  OffboardFrame frame_;
  OffboardInput input_;
};

}  // namespace gustlab
