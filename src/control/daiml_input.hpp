// What the DAIML network looks at: the same numbers in training and in flight, for any multirotor.
//
// Neural-Fly feeds velocity, quaternion and four pwm values (divided by 1000), which ties a network to one vehicle. Here the
// motors come as what they do, in units of the vehicle: [thrust/(mg), torque/(mg · arm)], for a quadrotor a linear map of
// its four thrusts. The network learns accelerations, m/s². So one set of weights is at least of the right size on both
// vehicles of the paper.
#pragma once

#include <array>
#include <string_view>

#include "control/rotors.hpp"

namespace gustlab {

inline constexpr int daiml_inputs = 11;
inline constexpr std::array<std::string_view, daiml_inputs> daiml_input_names{
    "vx_W_mps", "vy_W_mps", "vz_W_mps", "qw", "qx", "qy", "qz", "thrust", "torque_x", "torque_y", "torque_z"};

// quaternion with w ≥ 0
std::array<double, daiml_inputs> daiml_input(const VehicleModel& vehicle, const Mixer& mixer,
                                             const Vector3& velocity_W_mps, const Quaternion& attitude_WB,
                                             const RotorArray& rotor_speed_radps);

}  // namespace gustlab
