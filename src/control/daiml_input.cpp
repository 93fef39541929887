#include "control/daiml_input.hpp"

namespace gustlab {

std::array<double, daiml_inputs> daiml_input(const VehicleModel& vehicle, const Mixer& mixer,
                                             const Vector3& velocity_W_mps, const Quaternion& attitude_WB,
                                             const RotorArray& rotor_speed_radps) {
  const double sign = attitude_WB.w() < 0.0 ? -1.0 : 1.0;
  const double thrust = mixer.force_B_N(rotor_speed_radps).z() / vehicle.weight_N();
  const Vector3 torque = mixer.torque_B_Nm(rotor_speed_radps) / (vehicle.weight_N() * vehicle.arm_m());
  return {velocity_W_mps.x(),
          velocity_W_mps.y(),
          velocity_W_mps.z(),
          sign * attitude_WB.w(),
          sign * attitude_WB.x(),
          sign * attitude_WB.y(),
          sign * attitude_WB.z(),
          thrust,
          torque.x(),
          torque.y(),
          torque.z()};
}

}  // namespace gustlab
