// The vehicle's motion between samples, for linearising and for shooting: the force model with a midpoint rule.
#pragma once

#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/model/linear_flight.hpp"
#include "diagnosis/recording/flight_data.hpp"
#include "plant/force_model.hpp"

namespace gustlab::diagnosis {

inline Quaternion exp_rotation(const Vector3& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Quaternion(Eigen::AngleAxisd(angle, turn / angle)) : Quaternion::Identity();
}

// small rotation from a to b, in the axes of a
inline Vector3 log_rotation(const Quaternion& a, const Quaternion& b) {
  const Quaternion d = a.conjugate() * b;
  return (d.w() < 0.0 ? -2.0 : 2.0) * d.vec();
}

// motion of the centre of mass
struct Point {
  Vector3 position, velocity;
  Quaternion attitude;
  Vector3 rate;

  Point plus(int i, double step) const {
    Point moved = *this;
    if (i < 3) moved.position[i] += step;
    else if (i < 6) moved.velocity[i - 3] += step;
    else if (i < 9) moved.attitude = attitude * exp_rotation(step * Vector3::Unit(i - 6));
    else moved.rate[i - 9] += step;
    return moved;
  }
  Vector12 minus(const Point& other) const {
    Vector12 e;
    e << position - other.position, velocity - other.velocity, log_rotation(other.attitude, attitude),
        rate - other.rate;
    return e;
  }
};

inline Point halfway(const Point& a, const Point& b) {
  return {0.5 * (a.position + b.position), 0.5 * (a.velocity + b.velocity), a.attitude.slerp(0.5, b.attitude),
          0.5 * (a.rate + b.rate)};
}

inline Point center_of_mass(const Motion& motion, const Vector3& arm) {
  const Matrix3 R = motion.attitude_WB.toRotationMatrix();
  return {motion.position_W_m + R * arm, motion.velocity_W_mps + R * motion.body_rate_B_radps.cross(arm),
          motion.attitude_WB, motion.body_rate_B_radps};
}

// the force model at a point of the flight
struct Evaluator {
  const ForceModel& forces;
  Flow flow;
  RotorSet rotors;
  Vector3 trim_B_radps2 = Vector3::Zero();  // an angular acceleration that nothing explains

  Acceleration operator()(const Point& x, double time_s, double voltage_V, const RotorArray& speed,
                          const RotorArray& acceleration) {
    prepare(x, time_s, voltage_V, speed, acceleration);
    Acceleration a = forces.acceleration(flow, forces.wrench(flow, rotors, {}));
    a.angular_B_radps2 += trim_B_radps2;
    return a;
  }
  // What an accelerometer at the origin feels. The rotors' own acceleration is left out: a difference of recorded speeds is noise, for
  // the most part, and would be most of a column that depends on how the body turns.
  Vector3 specific_force(const Point& x, double time_s, double voltage_V, const RotorArray& speed,
                         Vector3& angular_acceleration) {
    prepare(x, time_s, voltage_V, speed, {});
    const Wrench wrench = forces.wrench(flow, rotors, {});
    angular_acceleration = forces.acceleration(flow, wrench).angular_B_radps2;
    return forces.specific_force_at_origin(flow, wrench, angular_acceleration);
  }

 private:
  void prepare(const Point& x, double time_s, double voltage_V, const RotorArray& speed,
               const RotorArray& acceleration) {
    VehicleState state;
    state.time_s = time_s;
    state.attitude_WB = x.attitude;
    state.body_rate_B_radps = x.rate;
    const Matrix3 R = x.attitude.toRotationMatrix();
    const Vector3& arm = forces.vehicle().center_of_mass_B_m;
    state.position_W_m = x.position - R * arm;
    state.velocity_W_mps = x.velocity - R * x.rate.cross(arm);
    flow = forces.flow(state, voltage_V);
    forces.rotors(speed, acceleration, flow, rotors);
  }
};

// Mean of the rotors' speeds or accelerations over consecutive substeps.
inline RotorArray mean_of(const RotorArray* values, int count) {
  RotorArray mean{};
  for (int s = 0; s < count; ++s)
    for (std::size_t i = 0; i < max_rotors; ++i) mean[i] += values[s][i] / count;
  return mean;
}

// The plant's motion over one sample interval: midpoint rule in substeps, rotor speeds held at their means.
Point propagate(Evaluator& evaluate, Point x, double time_s, double interval_s, double voltage_V, int substeps,
                const RotorArray* speed, const RotorArray* acceleration);

// The forces of one flight at given values; `also`: a group that takes part even at zero strength.
ForceModel force_model(const FlightData& flight, const Catalogue& catalogue, const Eigen::VectorXd& value,
                       int flight_index, int also);

// Rotor speeds as the commands have it, or as they were measured: the better estimate of them where there is one.
RotorHistory rotor_history(const FlightData& flight, const ForceModel& forces);
// Where both were recorded, one of the two alone.
RotorHistory measured_history(const FlightData& flight);
RotorHistory commanded_history(const FlightData& flight, const ForceModel& forces);
// From each measured speed to that of the next row, as rotors get there that answer as `forces` say: to the command of the log, and to what is missing of
// it, which rises in a straight line from row to row. Mean speeds alone.
RotorHistory history_between_rows(const FlightData& flight, const ForceModel& forces);

}  // namespace gustlab::diagnosis
