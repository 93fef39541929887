// The makers of every effect; each lives in its own file of this folder.
#pragma once

#include <memory>

#include "gustlab/effect.hpp"

namespace gustlab {

std::unique_ptr<Effect> make_rotor_drag();
std::unique_ptr<Effect> make_quadratic_drag();
std::unique_ptr<Effect> make_axial_inflow();
std::unique_ptr<Effect> make_translational_lift();
std::unique_ptr<Effect> make_flapping_torque();
std::unique_ptr<Effect> make_ground_effect();
std::unique_ptr<Effect> make_ceiling_effect();
std::unique_ptr<Effect> make_wall_effect();
std::unique_ptr<Effect> make_fans();
std::unique_ptr<Effect> make_steady_wind();
std::unique_ptr<Effect> make_gust();
std::unique_ptr<Effect> make_constant_force();
std::unique_ptr<Effect> make_slung_load();
std::unique_ptr<Effect> make_mass();
std::unique_ptr<Effect> make_center_of_mass();
std::unique_ptr<Effect> make_inertia();
std::unique_ptr<Effect> make_thrust_scale();
std::unique_ptr<Effect> make_rotor_loss();
std::unique_ptr<Effect> make_rotor_tilt();
std::unique_ptr<Effect> make_motor_lag();
std::unique_ptr<Effect> make_actuation_delay();
std::unique_ptr<Effect> make_thrust_curve();
std::unique_ptr<Effect> make_saturation();
std::unique_ptr<Effect> make_battery_sag();
std::unique_ptr<Effect> make_yaw_torque_ratio();
std::unique_ptr<Effect> make_rotor_inertia();
std::unique_ptr<Effect> make_attitude_offset();
std::unique_ptr<Effect> make_yaw_offset();
std::unique_ptr<Effect> make_pose_delay();
std::unique_ptr<Effect> make_imu_lever();
std::unique_ptr<Effect> make_gyro_scale();
std::unique_ptr<Effect> make_measurement_noise();
std::unique_ptr<Effect> make_estimator_delay();
std::unique_ptr<Effect> make_sindy_residual();
std::unique_ptr<Effect> make_recorded_loop();

}  // namespace gustlab
