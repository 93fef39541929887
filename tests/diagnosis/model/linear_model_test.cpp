// Columns of the linearised model.
#include "diagnosis/model/linear_model.hpp"

#include <gtest/gtest.h>

#include "diagnosis/estimation/session.hpp"
#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {

// A lag of rotors that have none yet shows in a specific force at the samples alone, as it does in what moves the vehicle between them.
TEST(LinearModel, ForcesAloneSeeALag) {
  const TemporaryFolder folder;
  const auto trial = test::fly_trial(folder, {.vehicle = "crazyflie_21",
                                              .fit = {"multisine"},
                                              .holdout = {"circle"},
                                              .sensors = {"gyroscope", "accelerometer"},
                                              .duration_s = 5.0,
                                              .log_rate_hz = 100.0});
  const FlightLog log = read_flight_log(trial.fit.front());
  const VehicleModel vehicle = read_vehicle(log.meta.vehicle, log.path);
  ReadingOptions reading;
  reading.forces_only = true;
  Session session({prepare_flight(log, vehicle, reading)}, vehicle, 1);
  session.linearise(session.value(), session.all_columns());
  const LinearFlight& flight = session.linear().front();
  ASSERT_TRUE(flight.forces_alone);
  const int lag = session.catalogue().find("motor_lag");
  ASSERT_GE(lag, 0);
  double largest = 0.0;
  for (std::size_t j = 0; j < flight.columns.size(); ++j)
    if (session.catalogue().columns()[static_cast<std::size_t>(flight.columns[j])].group == lag)
      for (const auto& D : flight.D)
        largest = std::max(largest, D.col(static_cast<Eigen::Index>(j)).tail<3>().cwiseAbs().maxCoeff());
  EXPECT_GT(largest, 0.005);  // m/s² per natural size
}

}  // namespace
}  // namespace gustlab::diagnosis
