// Reading a log whose sensors have rates of their own.
#include "diagnosis/flight_data.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {

constexpr double spin_radps = 2.0, step_s = 0.004;

Quaternion attitude(double time_s) { return Quaternion(Eigen::AngleAxisd(spin_radps * time_s, Vector3::UnitZ()) * Eigen::AngleAxisd(0.2, Vector3::UnitX())); }

// two turns about the vertical, the attitude in every second row, by the sign that makes its scalar positive
FlightLog spin() {
  FlightLog log;
  log.path = "somewhere/spin.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name : {"qw", "qx", "qy", "qz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"}) log.columns.push_back({name, {}});
  const Vector3 rate = attitude(0.0).conjugate() * Vector3(0.0, 0.0, spin_radps);
  for (std::size_t k = 0; k < 1600; ++k) {
    const double t = step_s * static_cast<double>(k);
    log.time_s.push_back(t);
    Eigen::Vector4d q(attitude(t).w(), attitude(t).x(), attitude(t).y(), attitude(t).z());
    if (q[0] < 0.0) q = -q;
    if (k % 2 == 1) q.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < 4; ++i) log.columns[i].values.push_back(q[static_cast<int>(i)]);
    for (std::size_t i = 0; i < 3; ++i) log.columns[4 + i].values.push_back(rate[static_cast<int>(i)]);
    for (std::size_t i = 0; i < 4; ++i) log.columns[7 + i].values.push_back(1000.0);
  }
  return log;
}

double worst_attitude_rad(const FlightData& flight) {
  double worst = 0.0;
  for (std::size_t k = 0; k < flight.samples.size(); ++k)
    worst = std::max(worst, flight.motion[k].attitude_WB.angularDistance(attitude(flight.samples[k].time_s)));
  return worst;
}

// GIVEN an attitude that turns through 180 degrees, with rows between that have none WHEN read THEN no sample is off by a sign
TEST(FlightData, AttitudeIsContinuousAcrossRowsWithoutOne) {
  const VehicleModel vehicle = read_vehicle("crazyflie", "");
  EXPECT_LT(worst_attitude_rad(prepare_flight(spin(), vehicle, {})), 1e-3);
  ReadingOptions smoothed;
  smoothed.max_rate_hz = 20.0;
  smoothed.common_filter_s = 0.022;
  EXPECT_LT(worst_attitude_rad(prepare_flight(spin(), vehicle, smoothed)), 5e-2);
}

}  // namespace
}  // namespace gustlab::diagnosis
