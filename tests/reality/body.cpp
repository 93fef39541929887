#include "body.hpp"

#include <algorithm>
#include <cmath>

#include "air.hpp"

namespace reality {
namespace {

const Vec3 kDown_W_mps2(0, 0, -kGravity_mps2);

// angular momentum stored in the spinning rotors, in B
Vec3 rotor_momentum_B(const Truth& truth, const PerRotor& speed_radps) {
  double sum = 0;
  for (int i = 0; i < kRotors; ++i) sum += truth.nominal.spin[i] * truth.rotor_inertia_kgm2 * speed_radps[i];
  return {0, 0, sum};
}

struct Pull {
  Vec3 force_W_N = Vec3::Zero(), at_B_m = Vec3::Zero();
};

// tension that keeps the cable's length: second derivative of |load - anchor|^2 is zero
Pull cable(const Truth& truth, const State& x, const Motion& m, const Wrench& others) {
  Pull pull;
  if (truth.load_kg <= 0) return pull;
  const Mat3 R = m.attitude.toRotationMatrix();
  pull.at_B_m = -truth.com_B_m;
  const Vec3 anchor_W = m.com_W_m + R * pull.at_B_m;
  const Vec3 anchor_velocity_W = m.velocity_W_mps + R * m.rate_B_radps.cross(pull.at_B_m);
  const Vec3 along_W = (x.segment<3>(13) - anchor_W).normalized();
  const Vec3 slide_W = x.segment<3>(16) - anchor_velocity_W;
  const double across2 = slide_W.squaredNorm() - std::pow(slide_W.dot(along_W), 2);
  const Vec3 arm_B = pull.at_B_m.cross(R.transpose() * along_W);
  const Vec3 inverse_inertia = truth.inertia_kgm2.cwiseInverse();
  const Vec3 spin_B = inverse_inertia.cwiseProduct(
      others.torque_B_Nm - m.rate_B_radps.cross(truth.inertia_kgm2.cwiseProduct(m.rate_B_radps)));
  const Vec3 anchor_acceleration_W = R * (others.force_B_N / truth.mass_kg + spin_B.cross(pull.at_B_m) +
                                          m.rate_B_radps.cross(m.rate_B_radps.cross(pull.at_B_m)));
  const double push = across2 / truth.load_length_m - along_W.dot(anchor_acceleration_W);
  const double mobility = 1 / truth.load_kg + 1 / truth.mass_kg + arm_B.dot(inverse_inertia.cwiseProduct(arm_B));
  const double rubs = 2 * truth.hook_damping * std::sqrt(kGravity_mps2 / truth.load_length_m) * truth.load_kg;
  pull.force_W_N = std::max(0.0, push / mobility) * along_W + rubs * (slide_W - slide_W.dot(along_W) * along_W);
  return pull;
}

// gravity cancels from the cable's constraint: body and load fall alike
State derivative(const Truth& truth, const State& x, const Drive& drive) {
  const Motion m = motion(truth, x, drive.speed_radps);
  const Mat3 R = m.attitude.toRotationMatrix();
  Wrench total = wrench(truth, m, drive);
  const Pull pull = cable(truth, x, m, total);
  State dx = State::Zero();
  if (truth.load_kg > 0) {
    dx.segment<3>(13) = x.segment<3>(16);
    dx.segment<3>(16) = kDown_W_mps2 - pull.force_W_N / truth.load_kg;
    const Vec3 pull_B = R.transpose() * pull.force_W_N;
    total.force_B_N += pull_B;
    total.torque_B_Nm += pull.at_B_m.cross(pull_B);
  }
  if (truth.outside.payload_kg > 0) {
    const Wrench stem = payload_wrench(truth, x);
    const Vec3 arm_B(0, 0, -truth.outside.payload_arm_m);
    const Vec3 shake_B =
        total.force_B_N / truth.mass_kg + total.torque_B_Nm.cwiseQuotient(truth.inertia_kgm2).cross(arm_B);
    dx.segment<2>(19) = x.segment<2>(21);
    dx.segment<2>(21) = -stem.force_B_N.head<2>() / truth.outside.payload_kg - shake_B.head<2>();
    total.force_B_N += stem.force_B_N;
    total.torque_B_Nm += stem.torque_B_Nm;
  }
  dx.segment<3>(0) = m.velocity_W_mps;
  dx.segment<3>(3) = truth.mass_kg * kDown_W_mps2 + R * total.force_B_N;
  const Quat turn = m.attitude * Quat(0, m.rate_B_radps.x(), m.rate_B_radps.y(), m.rate_B_radps.z());
  dx.segment<4>(6) << 0.5 * turn.w(), 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z();
  dx.segment<3>(10) = R * total.torque_B_Nm;
  return dx;
}

// puts the attitude back on the sphere and a taut cable back to its length
void restore(const Truth& truth, State& x) {
  x.segment<4>(6).normalize();
  if (truth.load_kg <= 0) return;
  const Quat attitude(x[6], x[7], x[8], x[9]);
  const Vec3 anchor_W = x.segment<3>(0) - attitude * truth.com_B_m;
  const Vec3 cable_W = x.segment<3>(13) - anchor_W;
  if (cable_W.norm() <= truth.load_length_m) return;
  const Vec3 along_W = cable_W.normalized();
  x.segment<3>(13) = anchor_W + truth.load_length_m * along_W;
  const double stretch = along_W.dot(x.segment<3>(16) - x.segment<3>(3) / truth.mass_kg);
  if (stretch > 0) x.segment<3>(16) -= stretch * along_W;
}

}  // namespace

Truth as_nominal(const Nominal& nominal) {
  Truth t;
  t.nominal = nominal;
  t.mass_kg = nominal.mass_kg;
  t.inertia_kgm2 = nominal.inertia_kgm2;
  t.torque_ratio_m = nominal.torque_ratio_m;
  t.lag_up_s = t.lag_down_s = nominal.motor_lag_s;
  t.max_speed_radps = nominal.max_speed_radps;
  t.rotor_drag = nominal.rotor_drag_at_hover;
  return t;
}

Motion motion(const Truth& truth, const State& x, const PerRotor& speed_radps) {
  Motion m;
  m.com_W_m = x.segment<3>(0);
  m.velocity_W_mps = x.segment<3>(3) / truth.mass_kg;
  m.attitude = Quat(x[6], x[7], x[8], x[9]).normalized();
  const Vec3 body_momentum = m.attitude.conjugate() * Vec3(x.segment<3>(10)) - rotor_momentum_B(truth, speed_radps);
  m.rate_B_radps = body_momentum.cwiseQuotient(truth.inertia_kgm2);
  return m;
}

State state_of(const Truth& truth, const Motion& m, const PerRotor& speed_radps) {
  State x = State::Zero();
  x.segment<3>(0) = m.com_W_m;
  x.segment<3>(3) = truth.mass_kg * m.velocity_W_mps;
  x.segment<4>(6) << m.attitude.w(), m.attitude.x(), m.attitude.y(), m.attitude.z();
  x.segment<3>(10) =
      m.attitude * Vec3(truth.inertia_kgm2.cwiseProduct(m.rate_B_radps) + rotor_momentum_B(truth, speed_radps));
  x.segment<3>(13) = m.com_W_m - m.attitude * truth.com_B_m - Vec3(0, 0, truth.load_length_m);
  x.segment<3>(16) = m.velocity_W_mps;
  return x;
}

Wrench wrench(const Truth& truth, const Motion& m, const Drive& drive) {
  Wrench sum = rotors_in_air(truth, m, drive);
  const Vec3 body_W = fuselage_force_W(truth, m, sum.force_B_N.z()) + drive.force_W_N + truth.force_W_N;
  sum.force_B_N += m.attitude.conjugate() * body_W;
  sum.torque_B_Nm += drive.torque_B_Nm;
  return sum;
}

Acceleration acceleration(const Truth& truth, const State& x, const Drive& drive) {
  const Motion m = motion(truth, x, drive.speed_radps);
  Wrench total = wrench(truth, m, drive);
  const Pull pull = cable(truth, x, m, total);
  const Vec3 pull_B = m.attitude.conjugate() * pull.force_W_N;
  const Wrench stem = payload_wrench(truth, x);
  total.force_B_N += pull_B + stem.force_B_N;
  total.torque_B_Nm += pull.at_B_m.cross(pull_B) + stem.torque_B_Nm;
  const Vec3 spin = truth.inertia_kgm2.cwiseProduct(m.rate_B_radps) + rotor_momentum_B(truth, drive.speed_radps);
  return {total.force_B_N / truth.mass_kg,
          (total.torque_B_Nm - m.rate_B_radps.cross(spin)).cwiseQuotient(truth.inertia_kgm2)};
}

Vec3 cable_force_W(const Truth& truth, const State& x, const Drive& drive) {
  const Motion m = motion(truth, x, drive.speed_radps);
  return cable(truth, x, m, wrench(truth, m, drive)).force_W_N;
}

Wrench payload_wrench(const Truth& truth, const State& x) {
  const Outside& o = truth.outside;
  Wrench stem;
  if (o.payload_kg <= 0) return stem;
  const double stiffness = o.payload_kg * std::pow(2 * std::numbers::pi * o.payload_hz, 2);
  for (int axis = 0; axis < 2; ++axis)
    stem.force_B_N[axis] = stiffness * x[19 + axis] + o.payload_friction_N * std::tanh(x[21 + axis] / 0.01);
  stem.torque_B_Nm = Vec3(0, 0, -o.payload_arm_m).cross(stem.force_B_N);
  return stem;
}

State advance(const Truth& truth, const State& x, const Drive& start, const Drive& middle, const Drive& end,
              double step_s) {
  const State k1 = derivative(truth, x, start);
  const State k2 = derivative(truth, x + 0.5 * step_s * k1, middle);
  const State k3 = derivative(truth, x + 0.5 * step_s * k2, middle);
  const State k4 = derivative(truth, x + step_s * k3, end);
  State next = x + step_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  restore(truth, next);
  return next;
}

}  // namespace reality
