// Columns of the linearised model.
#include "diagnosis/model/linear_model.hpp"

#include <gtest/gtest.h>

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/model/propagation.hpp"
#include "support/flight_data.hpp"
#include "support/sessions.hpp"
#include "support/trials.hpp"
#include "support/vehicles.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace linear_model_test {

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
    if (session.catalogue().column(flight.columns[j]).group == lag)
      for (const auto& felt : flight.felt_by)
        largest = std::max(largest, felt.col(static_cast<Eigen::Index>(j)).cwiseAbs().maxCoeff());
  EXPECT_GT(largest, 0.005);  // m/s² per natural size
}

// with the rate of the first sample alone attitudes came half an interval early: 12 ms of a late pose were 6 ms
TEST(LinearModel, TorquesThatNobodyKnowsTurnTheBodyAsItsRatesWereRecorded) {
  const VehicleModel vehicle = test::crazyflie();
  constexpr double sample_s = 0.01, frequency_radps = 12.0;
  FlightData flight = test::flight_of(
      vehicle, 1.0, sample_s,
      [](double t) {
        Motion m;
        m.attitude_WB = exp_rotation({0.3 * std::sin(frequency_radps * t), 0.0, 0.0});
        m.body_rate_B_radps.x() = 0.3 * frequency_radps * std::cos(frequency_radps * t);
        return m;
      },
      [&](double) { return test::all_at(vehicle.hover_speed_radps()); });
  flight.collective_only = true;
  const Catalogue catalogue(vehicle, 1, {Need::attitude | Need::motion, false, false, false});
  LinearFlight linear;
  linearise(flight, 0, catalogue, catalogue.nominal(), {}, linear);
  ASSERT_FALSE(linear.torque_known);
  double largest = 0.0;
  for (const Vector12& b : linear.b) largest = std::max(largest, b.segment<3>(6).cwiseAbs().maxCoeff());
  // half an interval of 43 rad/s² would be 2e-3 rad
  EXPECT_LT(largest, 1e-4);
}

// An accelerometer that is one row late shows of a load's force what it was one row before.
TEST(LinearModel, ALateAccelerometerShowsALoadLate) {
  const TemporaryFolder folder;
  const auto trial = test::fly_trial(folder, {.fit = {"multisine"}, .holdout = {"circle"}, .duration_s = 3.0});
  const FlightLog log = read_flight_log(trial.fit.front());
  const VehicleModel vehicle = read_vehicle(log.meta.vehicle, log.path);
  FlightData late = prepare_flight(log, vehicle, {});
  late.late.force_s = late.sample_s;
  std::vector<Vector3> force;
  for (const Sample& sample : late.samples) force.emplace_back(std::sin(20.0 * sample.time_s), 0.0, 0.0);
  Session session({late}, vehicle, 1);
  session.suspect_load({}, {force});
  const std::vector<int>& column = session.catalogue().group(session.catalogue().find(ColumnFrom::swing)).columns;
  session.linearise(session.value(), column);
  const LinearFlight& flight = session.linear().front();
  ASSERT_EQ(flight.columns, column);
  for (std::size_t k = 2; k < 50; ++k) {
    const Vector3 shown = flight.R_WB[k] * flight.felt_by[k].col(0);
    // turned back by this row's attitude, which is a little past that of the row before
    EXPECT_NEAR(shown.x(), flight.acceleration_by[k - 1](0, 0), 0.02 * std::abs(shown.x()) + 1e-3);
  }
}

// What is predicted at another value is as a new linearisation there has it, bit for bit; what parameters change stays as it was.
TEST(LinearModel, PredictsAtAnotherValueWithTheColumnsItHas) {
  const auto flown = test::short_flights(R"({type = "rotor_drag", at_hover = 0.01})", {"multisine"}, 3.0);
  Session one = test::session_of(flown), other = test::session_of(flown);
  const std::vector<int> columns = one.with_biases(
      {one.catalogue().find("mass"), one.catalogue().find("motor_lag"), one.catalogue().find("attitude_offset")});
  Eigen::VectorXd value = one.value();
  one.linearise(value, columns);
  const LinearFlight before = one.linear().front();
  for (const int c : columns) value[c] += 0.5 * one.catalogue().column(c).natural;
  one.predict_at(value);
  other.linearise(other.value(), columns);
  other.linearise(value, columns);
  const LinearFlight &again = one.linear().front(), &anew = other.linear().front();
  EXPECT_EQ(one.value(), value);
  EXPECT_EQ(again.columns, anew.columns);
  EXPECT_EQ(again.y, anew.y);
  EXPECT_EQ(again.b, anew.b);
  EXPECT_EQ(again.acceleration_by, before.acceleration_by);
  EXPECT_NE(again.acceleration_by, anew.acceleration_by);
  EXPECT_NE(again.b, before.b);
}

}  // namespace linear_model_test
}  // namespace gustlab::diagnosis
