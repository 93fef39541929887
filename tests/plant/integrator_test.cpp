// The plant against an integrator of its own kind: classical Runge–Kutta on Newton's and Euler's equations for the body's
// origin, written here from the formulas of the catalogue and from nothing of the plant.
#include <gmock/gmock.h>

#include <cmath>

#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {
namespace integrator_test {

constexpr double drag_at_hover = 0.02;

// a lopsided vehicle: centre of mass off the origin, products of inertia, a tilted rotor
VehicleModel lopsided() {
  VehicleModel vehicle = read_vehicle("crazyflie");
  vehicle.center_of_mass_B_m = Vector3(0.003, -0.002, 0.004);
  vehicle.inertia_B_kgm2 << 2.1e-5, 2e-6, -1e-6, 2e-6, 2.4e-5, 1.5e-6, -1e-6, 1.5e-6, 3.6e-5;
  vehicle.rotors[1].axis_B = Vector3(0.05, -0.03, 1.0).normalized();
  return vehicle;
}

RotorArray speeds(const VehicleModel& vehicle, double t) {
  RotorArray speed{};
  const double hover = vehicle.hover_speed_radps();
  for (std::size_t i = 0; i < 4; ++i) speed[i] = hover * (1.0 + 0.02 * std::sin(11.0 * t + static_cast<double>(i)));
  return speed;
}

using State = Eigen::Matrix<double, 13, 1>;  // position, velocity, quaternion (w first), body rate; of the origin

State derivative(const VehicleModel& v, const State& x, double t) {
  const Vector3 velocity = x.segment<3>(3), w = x.tail<3>();
  const Quaternion q(x[6], x[7], x[8], x[9]);
  const Matrix3 R = q.normalized().toRotationMatrix();
  const Vector3& c = v.center_of_mass_B_m;
  const RotorArray speed = speeds(v, t);
  const Vector3 v_com_B = R.transpose() * velocity + w.cross(c);
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Rotor& rotor = v.rotors[i];
    const Vector3 hub = rotor.position_B_m - c, v_hub = v_com_B + w.cross(hub);
    const Vector3 in_plane = v_hub - rotor.axis_B * rotor.axis_B.dot(v_hub);
    const double f = rotor.thrust_coefficient_Ns2 * speed[i] * speed[i];
    const Vector3 total = f * rotor.axis_B - drag_at_hover / (4.0 * v.hover_speed_radps()) * speed[i] * in_plane;
    force += total;
    torque += hub.cross(total) - rotor.direction * rotor.torque_ratio_m * f * rotor.axis_B;
  }
  const Vector3 spin = v.inertia_B_kgm2.inverse() * (torque - w.cross(v.inertia_B_kgm2 * w));
  // a_origin = a_com − α × c − ω × (ω × c)
  const Vector3 a = R * (force / v.mass_kg - spin.cross(c) - w.cross(w.cross(c))) - Vector3(0.0, 0.0, 9.81);
  State dx;
  dx << velocity, a, 0.5 * (-q.vec().dot(w)), 0.5 * (q.w() * w + q.vec().cross(w)), spin;
  return dx;
}

State runge_kutta(const VehicleModel& v, State x, double duration_s, int steps) {
  const double h = duration_s / steps;
  for (int n = 0; n < steps; ++n) {
    const double t = n * h;
    const State k1 = derivative(v, x, t), k2 = derivative(v, x + 0.5 * h * k1, t + 0.5 * h),
                k3 = derivative(v, x + 0.5 * h * k2, t + 0.5 * h), k4 = derivative(v, x + h * k3, t + h);
    x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return x;
}

State plant_state(const VehicleModel& vehicle, const VehicleState& start, double duration_s, int steps) {
  const double step_s = duration_s / steps;
  Plant plant(vehicle, make_effects({{"rotor_drag", {{"at_hover", "0.02"}}, "test", {}}}),
              {.step_s = step_s, .seed = 1, .replicate = 1});
  plant.reset(start);
  for (int n = 0; n < steps; ++n) {
    // the middle of the step: what is left is the integrator's error
    RotorCommand command{speeds(vehicle, (n + 0.5) * step_s)};
    EXPECT_TRUE(plant.step(command));
  }
  const VehicleState& s = plant.state();
  State x;
  x << s.position_W_m, s.velocity_W_mps, s.attitude_WB.w(), s.attitude_WB.vec(), s.body_rate_B_radps;
  return x;
}

class Integrator : public ::testing::Test {
 protected:
  Integrator() {
    start.velocity_W_mps = Vector3(1.0, -0.5, 0.3);
    start.attitude_WB = Quaternion(0.95, 0.1, -0.2, 0.15).normalized();
    start.body_rate_B_radps = Vector3(2.0, -1.0, 3.0);
    State x;
    x << start.position_W_m, start.velocity_W_mps, start.attitude_WB.w(), start.attitude_WB.vec(),
        start.body_rate_B_radps;
    exact = runge_kutta(vehicle, x, duration_s, 2000);
  }
  double error(int steps) const { return (plant_state(vehicle, start, duration_s, steps) - exact).norm(); }

  const VehicleModel vehicle = lopsided();
  const double duration_s = 0.5;
  VehicleState start;
  State exact;
};

TEST_F(Integrator, AgreesWithRungeKutta) { EXPECT_LT(error(20000), 2e-3 * exact.norm()); }

TEST_F(Integrator, HalvingTheStepHalvesTheError) {
  for (const int steps : {500, 1000}) {
    const double ratio = error(steps) / error(2 * steps);
    EXPECT_GT(ratio, 1.8);
    EXPECT_LT(ratio, 2.2);
  }
}

}  // namespace integrator_test
}  // namespace gustlab
