// A flight whose residual force is known: smooth tilts and thrust, and the velocity that Newton gives with the force.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "gustlab/flight_log.hpp"
#include "identification/force_residual.hpp"

namespace gustlab {

struct PlantedFlight {
  FlightLog log;
  VehicleModel vehicle;
  std::vector<double> thrust_N;  // per row

  KnownModel known() const {
    return [this](std::size_t row, const VehicleState&) {
      return KnownForce{Vector3(0.0, 0.0, thrust_N[row]), thrust_N[row]};
    };
  }
};

// Tilt and thrust at a time; `phase` makes flights different.
inline FeatureInput planted_input(double t, double phase) {
  FeatureInput in;
  in.roll_rad = 0.25 * std::sin(1.9 * t + phase) + 0.1 * std::sin(4.3 * t);
  in.pitch_rad = 0.22 * std::cos(1.3 * t + 2.0 * phase) + 0.12 * std::sin(3.1 * t);
  in.thrust_N = 19.4 + 3.0 * std::sin(2.3 * t + phase) + 2.0 * std::cos(5.1 * t);
  return in;
}

inline Matrix3 rotation(const FeatureInput& in) {
  return (Eigen::AngleAxisd(in.yaw_rad, Vector3::UnitZ()) * Eigen::AngleAxisd(in.pitch_rad, Vector3::UnitY()) *
          Eigen::AngleAxisd(in.roll_rad, Vector3::UnitX()))
      .toRotationMatrix();
}

inline PlantedFlight planted_flight(const std::function<Vector3(const FeatureInput&)>& force_W_N, int rows,
                                    double step_s, double phase = 0.0) {
  PlantedFlight out;
  out.vehicle.name = "planted";
  out.vehicle.mass_kg = 1.98;
  out.log.path = "planted.csv";
  for (const char* name : {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "ax", "ay", "az"}) {
    out.log.columns.push_back({name, {}});
  }
  const auto acceleration = [&](double t) -> Vector3 {
    const FeatureInput in = planted_input(t, phase);
    Vector3 a = (rotation(in) * Vector3(0.0, 0.0, in.thrust_N) + force_W_N(in)) / out.vehicle.mass_kg;
    a.z() -= out.vehicle.gravity_mps2;
    return a;
  };
  // Simpson's rule per step: the acceleration is a function of time alone
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero();
  for (int i = 0; i < rows; ++i) {
    const double t = step_s * i;
    const FeatureInput in = planted_input(t, phase);
    const Matrix3 R_WB = rotation(in);
    const Quaternion q(R_WB);
    const Vector3 a = acceleration(t), specific = R_WB.transpose() * (a + out.vehicle.gravity_mps2 * Vector3::UnitZ());
    const double values[] = {position.x(), position.y(), position.z(), velocity.x(), velocity.y(), velocity.z(), q.w(),
                             q.x(),        q.y(),        q.z(),        specific.x(), specific.y(), specific.z()};
    out.log.time_s.push_back(t);
    for (std::size_t c = 0; c < out.log.columns.size(); ++c) out.log.columns[c].values.push_back(values[c]);
    out.thrust_N.push_back(in.thrust_N);
    const Vector3 middle = acceleration(t + step_s / 2), end = acceleration(t + step_s);
    position += step_s * velocity + step_s * step_s / 6.0 * (a + 2.0 * middle);
    velocity += step_s / 6.0 * (a + 4.0 * middle + end);
  }
  return out;
}

}  // namespace gustlab
