// The adaptive part that Adaptive SINDy and DAIML share: the residual force, measured, filtered, adapted to, and limited.
//
//   f_dist = m a_meas + m g − u_prev        s = e_v + Λ e_p        F_d = m a_cmd + m g − f̂
//
// (arXiv 2603.08863, section II-B and Algorithm 1.) a_meas and u_prev are means over the same interval and pass the same
// filter. Inside, everything is per mass (m/s²), so that one set of gains fits vehicles of any weight.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "control/adaptation.hpp"
#include "control/filters.hpp"
#include "control/offboard.hpp"

namespace gustlab {

class ResidualAdaptation {
 public:
  void visit(ParameterVisitor& visitor);
  // start: n×3, m/s² per unit of each feature. Throws ParameterError.
  void reset(const OffboardSetup& setup, const Adaptation::Parameters& start);
  // Features at the present; returns F_d, world axes, N.
  Vector3 update(const OffboardInput& input, const Adaptation::Row& phi);

  std::vector<std::string_view> telemetry_names() const {
    return {"force_x_N", "force_y_N", "force_z_N", "residual_x_N", "residual_y_N", "residual_z_N"};
  }
  void telemetry(std::span<double> out) const;
  const Adaptation& adaptation() const { return adaptation_; }

 private:
  Adaptation::Options options_;
  std::string covariance_law_ = "corrected";
  double sliding_radps_ = 1.0;  // Λ
  double filter_hz_ = 5.0;
  double limit_weights_ = 0.5;

  double mass_kg_ = 0.0, weight_N_ = 0.0;
  Adaptation adaptation_;
  LowPass1<Vector3> filter_;
  Vector3 residual_W_mps2_ = Vector3::Zero(), estimate_W_mps2_ = Vector3::Zero();
};

}  // namespace gustlab
