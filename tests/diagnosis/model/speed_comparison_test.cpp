// Speeds that commands predict, against a lag's closed form and its derivative.
#include "diagnosis/model/speed_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace speed_comparison_test {

constexpr double step_at_s = 0.3, lag_s = 0.0125;

// after a third of a second a tenth more is commanded; what was measured never changes
class SpeedComparison : public ::testing::Test {
 protected:
  SpeedComparison() {
    flight = test::flight_of(
        vehicle, 0.6, 0.01, [](double) { return Motion{}; }, [this](double t) { return speeds(t); });
    flight.measured_speed = test::record_of([this](double) { return test::all_at(hover); }, 0.6, 0.01, false);
    for (int c = 0; c < catalogue.size(); ++c) linear.columns.push_back(c);
  }
  RotorArray speeds(double t) const { return test::all_at((t < step_at_s - 1e-9 ? 1.0 : 1.1) * hover); }
  void compare() {
    flight.measured_at_sample = measured_beside_commands(flight);
    compare_speeds(flight, 0, catalogue, catalogue.nominal(), linear);
  }
  int lag_column() const { return catalogue.group(catalogue.find("motor_lag")).columns[0]; }

  const VehicleModel vehicle = test::crazyflie();
  const double hover = vehicle.hover_speed_radps();
  const Catalogue catalogue{vehicle, 1, {.observable = Need::attitude | Need::motion | Need::torque}};
  FlightData flight;
  LinearFlight linear;
};

TEST_F(SpeedComparison, IsTheLagsClosedForm) {
  compare();
  ASSERT_EQ(linear.predicted.size(), flight.samples.size());
  const double natural = catalogue.column(lag_column()).natural;
  const auto& by = linear.predicted_by[static_cast<std::size_t>(lag_column())];
  ASSERT_EQ(by.size(), flight.samples.size());
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const double since_s = std::max(0.0, flight.samples[k].time_s - step_at_s), left = std::exp(-since_s / lag_s);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(linear.predicted[k][i], hover * (1.1 - (since_s > 0.0 ? 0.1 * left : 0.1)), 1e-6 * hover) << k;
      EXPECT_NEAR(linear.faster[k][i], hover - linear.predicted[k][i], 1e-9 * hover);
      EXPECT_NEAR(by[k][i], -0.1 * hover * since_s / (lag_s * lag_s) * left * natural, 2e-4 * hover) << k;
    }
  }
}

TEST_F(SpeedComparison, WhatMovesTheBodyAloneChangesNoSpeed) {
  compare();
  for (const char* name : {"mass", "rotor_drag", "center_of_mass", "thrust_curve"})
    for (const int c : catalogue.group(catalogue.find(name)).columns)
      EXPECT_TRUE(linear.predicted_by[static_cast<std::size_t>(c)].empty()) << name;
}

TEST_F(SpeedComparison, SaysNothingWhereThereIsNothingToCompare) {
  const FlightData whole = flight;
  for (const auto& spoil : {+[](FlightData& f) { f.measured_speed = {}; }, +[](FlightData& f) { f.commands = {}; },
                            +[](FlightData& f) { f.collective_only = true; }}) {
    flight = whole;
    compare();
    EXPECT_FALSE(linear.predicted.empty());
    spoil(flight);
    compare();
    EXPECT_TRUE(linear.predicted.empty() && linear.faster.empty());
  }
}

// a log that wrote its commands down twice has measured nothing
TEST_F(SpeedComparison, ACommandIsNoMeasurementOfItself) {
  flight.measured_speed = test::record_of([this](double t) { return speeds(t); }, 0.6, 0.01, true);
  compare();
  EXPECT_TRUE(linear.predicted.empty());
}

}  // namespace speed_comparison_test
}  // namespace gustlab::diagnosis
