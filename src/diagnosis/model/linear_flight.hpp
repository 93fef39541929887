// The simulator linearised along a flight, one sample ahead.
//
// Error state e = [δp δv δϑ δω] of the centre of mass (W, W, B, B) about the smoothed trajectory x̄, plus a free wrench
// d = [force/mass in W, angular acceleration in B]:
//   e⁺ = F e + (f(x̄_k, u; θ₀) ⊟ x̄_{k+1}) + Γ d + B θ,   y ⊟ h(x̄) = H e + D θ + v.
// F, B and D are finite differences of the simulator's own forces; nothing is differentiated from the data.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab::diagnosis {

inline constexpr int error_size = 12;  // δp δv δϑ δω
inline constexpr int state_size = 18;  // and d
inline constexpr int row_count = 12;   // position, attitude, rate, specific force
inline constexpr int first_force_row = 9;

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
// accelerations, a column each: linear in W, angular in B
using SpatialAcceleration = Eigen::Matrix<double, 6, 1>;
using SpatialAccelerations = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// What an accelerometer feels of them: rows of the specific force in B.
inline Eigen::Matrix<double, 3, Eigen::Dynamic> felt(const SpatialAccelerations& acceleration, const Matrix3& R_WB) {
  return R_WB.transpose() * acceleration.topRows<3>();
}

// The plant along one flight.
struct LinearPlant {
  std::vector<Matrix12> F;
  std::vector<Vector12> b;         // f(x̄_k) ⊟ x̄_{k+1}
  std::vector<double> interval_s;  // to the next sample
  std::vector<bool> starts;        // no prediction reaches this sample
  std::vector<Eigen::Matrix<bool, row_count, 1>> measured;
  std::vector<Vector12> y;  // measured ⊟ h(x̄)
  std::vector<Matrix3> R_WB;
  std::vector<Eigen::Matrix<double, 3, 9>> force_rows;  // ∂ specific force / ∂ (δv, δϑ, δω)
  // where commands and rotor speeds are both recorded, per sample: speed as commands predict it, and how much faster it is, rad/s
  std::vector<RotorArray> predicted, faster;
  // where torques are observed over a while alone (mean_torques.hpp), per window: its first sample's time, and the mean angular
  // acceleration, measured less predicted, rad/s²
  std::vector<double> window_s;
  std::vector<Vector3> mean_acceleration;
  Vector3 center_of_mass_B_m = Vector3::Zero();
  bool torque_known = true;
  bool forces_alone = false;  // neither a pose nor torques: see direct_forces.hpp
  std::size_t size() const { return b.size(); }

  // Γ: adds to the first 12 rows of `state` what accelerations, a column each, change from sample k to the next. Torques that are not
  // known turn nothing: the body turns as it was recorded.
  template <class Accelerations, class State>
  void add_moved_by(const Accelerations& acceleration, std::size_t k, State&& state) const {
    const double dt = interval_s[k];
    for (int i = 0; i < (torque_known ? 6 : 3); i += 3) {
      state.template middleRows<3>(2 * i) += 0.5 * dt * dt * acceleration.template middleRows<3>(i);
      state.template middleRows<3>(2 * i + 3) += dt * acceleration.template middleRows<3>(i);
    }
  }
};
// and what parameters change of it: per sample a matrix, whose columns are `columns` in their natural units
struct LinearFlight : LinearPlant {
  template <int rows>
  using Changes = std::vector<Eigen::Matrix<double, rows, Eigen::Dynamic, Eigen::RowMajor>>;
  std::vector<int> columns;  // of the catalogue, those that can act in this flight
  // B = Γ acceleration_by; rows of D: felt_by the specific force, sensed_by position, attitude and rate, of the columns with these
  // indices alone (the others change nothing there)
  Changes<6> acceleration_by;
  Changes<3> felt_by;
  std::vector<Eigen::Index> sensed;
  Changes<first_force_row> sensed_by;
  std::vector<std::vector<RotorArray>>
      predicted_by;  // per column, per sample: what it changes of `predicted`; empty: nothing
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>>
      mean_acceleration_by;  // per window, per column: of the predicted mean
};

}  // namespace gustlab::diagnosis
