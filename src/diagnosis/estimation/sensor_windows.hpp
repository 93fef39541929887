// Sensors against each other, whatever moves the vehicle: attitudes against the integral of the gyroscope, positions against the double
// integral of the accelerometer, over short windows. For flights whose filter does not take the inertial data in (FlightData::sensors):
// there a gyroscope's scale, a turned attitude, a late pose or a lever would not be observed otherwise.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diagnosis/estimation/innovations.hpp"
#include "diagnosis/model/catalogue.hpp"

namespace gustlab::diagnosis {

// What attitudes turn and positions move beyond the inertial data: kinds of windows.
enum class Beside { gyro, accelerometer };

struct SensorWindow {
  Beside beside;
  double time_s;  // at which it begins
  Vector3 y;      // at the sensors of the vehicle file: rad in B; m/s in W (difference of two mean velocities)
  Eigen::Matrix<double, 3, Eigen::Dynamic>
      by;  // what the sensors' numbers change of it, per column in its natural unit
};

struct SensorWindows {
  std::vector<int> columns;  // of the catalogue: sensor effects, and biases of this flight
  std::vector<SensorWindow> window;
};

// Windows in the order in which they begin; none of a flight without `sensors`.
SensorWindows sensor_windows(const FlightData& flight, int flight_index, const Catalogue& catalogue);

// Variances of what is left of both kinds, per axis: (rad)², (m/s)²; 0: no windows.
using SensorWindowVariance = std::array<double, 2>;

// Rows of some columns and y, whitened; y at `value`.
Whitened whiten_sensor_windows(const SensorWindows& windows, const std::vector<int>& columns,
                               const Catalogue& catalogue, const Eigen::VectorXd& value,
                               const SensorWindowVariance& variance);

// Of what is left at `value`. Errors that last make neighbours alike: no less than sums over ten windows scatter.
SensorWindowVariance sensor_window_variance(const std::vector<SensorWindows>& flights, const Catalogue& catalogue,
                                            const Eigen::VectorXd& value);

}  // namespace gustlab::diagnosis
