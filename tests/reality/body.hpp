// the moving body: momenta instead of velocities, so rotor inertia and a slung load need no extra terms
#pragma once

#include "truth.hpp"

namespace reality {

/// [centre of mass 3 | linear momentum 3 | attitude w x y z | angular momentum about the centre of mass, rotors
/// included 3 | load position 3 | load velocity 3 | payload deflection x y | payload rate x y], all in W, SI.
using State = Eigen::Matrix<double, 23, 1>;

/// What acts during one step besides the state.
struct Drive {
  PerRotor speed_radps{};
  Vec3 force_W_N = Vec3::Zero();  // turbulence, gust, anything exogenous
  Vec3 torque_B_Nm = Vec3::Zero();
  double voltage_V = 0;
  double time_s = 0;
  double rotor_factor = 1;  // thrust of the rotor that drops out
};

struct Wrench {
  Vec3 force_B_N = Vec3::Zero();    // without gravity
  Vec3 torque_B_Nm = Vec3::Zero();  // about the centre of mass
};

/// Readable view of a state.
struct Motion {
  Vec3 com_W_m, velocity_W_mps, rate_B_radps;
  Quat attitude;
};

Motion motion(const Truth& truth, const State& state, const PerRotor& speed_radps);
State state_of(const Truth& truth, const Motion& motion, const PerRotor& speed_radps);

/// Forces of rotors and air on the body (cable and payload excluded).
Wrench wrench(const Truth& truth, const Motion& m, const Drive& drive);

/// Specific force at the centre of mass [m/s^2, B] and angular acceleration [rad/s^2, B].
struct Acceleration {
  Vec3 specific_B_mps2, angular_B_radps2;
};
Acceleration acceleration(const Truth& truth, const State& state, const Drive& drive);

/// One Runge-Kutta step of order four; drives at its start, middle and end.
State advance(const Truth& truth, const State& state, const Drive& start, const Drive& middle, const Drive& end,
              double step_s);

/// Cable force on the body for this state [N, W]; zero when slack or without load.
Vec3 cable_force_W(const Truth& truth, const State& state, const Drive& drive);

/// Force and torque of the swinging payload on the body; zero without payload.
Wrench payload_wrench(const Truth& truth, const State& state);

}  // namespace reality
