// One instant of a fast, tilted, turning flight near every surface, for closed forms.
#pragma once

#include <gmock/gmock.h>

#include "plant/force_model.hpp"
#include "support/effects.hpp"

namespace gustlab::test {

struct Evaluated {
  VehicleModel vehicle;
  Flow flow;
  RotorSet rotors;
  Wrench wrench;
};

struct Instant {
  VehicleModel vehicle = small_quadrotor();
  VehicleState state;
  RotorArray speed_radps{1900, 2000, 2150, 1850};
  RotorArray acceleration_radps2{300, -200, 150, 420};
  double voltage_V = 3.5;

  Instant() {
    state.time_s = 7.0;
    state.position_W_m = {0.4, -0.3, 0.06};
    state.velocity_W_mps = {1.5, -0.8, 0.6};
    state.attitude_WB = Quaternion(Eigen::AngleAxisd(0.7, Vector3::UnitZ()) * Eigen::AngleAxisd(0.2, Vector3::UnitY()) *
                                   Eigen::AngleAxisd(-0.15, Vector3::UnitX()));
    state.body_rate_B_radps = {1.2, -0.7, 0.9};
    vehicle.environment.ground_z_m = 0.0;
    vehicle.environment.ceiling_z_m = 0.2;
    vehicle.environment.walls = {{{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}}, {{0.0, -0.5, 0.0}, {0.0, 1.0, 0.0}}};
  }

  Matrix3 R() const { return state.attitude_WB.toRotationMatrix(); }
  // v_r of the centre of mass in still air
  Vector3 air_velocity_B() const {
    return R().transpose() * state.velocity_W_mps + state.body_rate_B_radps.cross(vehicle.center_of_mass_B_m);
  }
  Vector3 hub_B(std::size_t i) const { return vehicle.rotors[i].position_B_m - vehicle.center_of_mass_B_m; }
  Vector3 hub_velocity_B(std::size_t i) const { return air_velocity_B() + state.body_rate_B_radps.cross(hub_B(i)); }
  double nominal_thrust_N(std::size_t i) const {
    return vehicle.rotors[i].thrust_coefficient_Ns2 * speed_radps[i] * speed_radps[i];
  }

  Evaluated evaluate(const std::vector<Wanted>& wanted) const {
    ForceModel forces(vehicle, make_effect_list(wanted));
    forces.prepare(0.002, 1, 1);
    std::vector<double> memory(static_cast<std::size_t>(forces.state_size()));
    forces.reset_state(memory);
    Evaluated out{forces.vehicle(), forces.flow(state, voltage_V), {}, {}};
    forces.rotors(speed_radps, acceleration_radps2, out.flow, out.rotors);
    out.wrench = forces.wrench(out.flow, out.rotors, memory);
    return out;
  }
  // what an effect adds to the nominal force and torque
  Wrench added(const std::vector<Wanted>& wanted) const {
    const Wrench with = evaluate(wanted).wrench, without = evaluate({}).wrench;
    return {with.force_B_N - without.force_B_N, with.torque_B_Nm - without.torque_B_Nm};
  }
};

inline void expect_near(const Vector3& actual, const Vector3& expected, double relative = 1e-9) {
  EXPECT_LE((actual - expected).norm(), relative * expected.norm() + 1e-15)
      << "actual " << actual.transpose() << "\nexpected " << expected.transpose();
}

}  // namespace gustlab::test
