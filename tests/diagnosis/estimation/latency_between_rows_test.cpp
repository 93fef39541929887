// A loop that is faster than its log: the command of a row falls until the next one, and rotors that follow it seem later than they are.
#include "diagnosis/estimation/latency_between_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/model/speed_comparison.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace latency_between_rows_test {

constexpr double sample_s = 0.02, fine_s = 0.0005, duration_s = 15.0, file_lag_s = 0.12, falls_s = 0.033;

// the fine history of a flight, whose rotors are late by `lag_s`
struct Flown {
  std::vector<RotorArray> command, speed;
  std::vector<Vector3> rate;
};

Flown fly(const VehicleModel& vehicle, double lag_s) {
  Flown flown;
  RotorArray speed = test::all_at(vehicle.hover_speed_radps());
  Vector3 rate = Vector3::Zero();
  for (int n = 0; n * fine_s <= duration_s + fine_s; ++n) {
    const double t = n * fine_s, row_s = std::floor(t / sample_s + 1e-6) * sample_s;
    RotorArray missing{};
    Vector3 torque = Vector3::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const Rotor& rotor = vehicle.rotors[i];
      missing[i] = 80.0 * std::sin((5.0 + 3.0 * static_cast<double>(i)) * row_s) * std::exp(-(t - row_s) / falls_s);
      const double thrust = rotor.thrust_coefficient_Ns2 * speed[i] * speed[i];
      torque += thrust * Vector3(rotor.position_B_m.y(), -rotor.position_B_m.x(), 0.0);
    }
    RotorArray command = speed;
    for (std::size_t i = 0; i < 4; ++i) command[i] += missing[i];
    flown.command.push_back(command);
    flown.speed.push_back(speed);
    flown.rate.push_back(rate);
    rate += fine_s * vehicle.inertia_B_kgm2.inverse() * torque;
    for (std::size_t i = 0; i < 4; ++i) speed[i] += fine_s / lag_s * missing[i];
  }
  return flown;
}

struct Asked {
  double lag_s, found_s;
  bool hold_known = false, pushed = false;  // by something else
};

std::optional<double> told(const Asked& asked) {
  VehicleModel vehicle = test::crazyflie();
  vehicle.effects = {test::effect("motor_lag", {{"time_constant", "0.12"}, {"time_constant_down", "0.12"}})};
  const Flown flown = fly(vehicle, asked.lag_s);
  const auto at = [](const auto& history) {
    return [&history](double t) { return history[static_cast<std::size_t>(std::lround(t / fine_s))]; };
  };
  const auto motion = [&](double t) {
    Motion moves;
    moves.body_rate_B_radps = at(flown.rate)(t);
    if (asked.pushed) moves.body_rate_B_radps += Vector3(20.0 * std::sin(60.0 * t), 20.0 * std::cos(70.0 * t), 0.0);
    return moves;
  };
  FlightData flight = test::flight_of(vehicle, duration_s, sample_s, motion, at(flown.command));
  flight.substeps = 8;
  flight.hold_known = asked.hold_known;
  flight.measured_speed = test::record_of(at(flown.speed), duration_s, sample_s, true);
  flight.measured_at_sample = measured_beside_commands(flight);
  const Catalogue catalogue{vehicle, 1, {.observable = Need::attitude | Need::motion | Need::torque}};
  Eigen::VectorXd found = catalogue.nominal();
  for (const int c : catalogue.group(catalogue.find(Place::actuation, Latency::lag)).columns)
    found[c] += asked.found_s - file_lag_s;
  return latency_between_rows({flight}, catalogue, found, catalogue.nominal());
}

TEST(LatencyBetweenRows, IsTheFilesWhereCommandsFall) {
  const double seems_s = 0.16;  // over the mean of what falls
  const auto delta_chi2 = told({file_lag_s, seems_s});
  ASSERT_TRUE(delta_chi2.has_value());
  EXPECT_LT(*delta_chi2, -10.0);
}

TEST(LatencyBetweenRows, IsTheFoundOneWhereRotorsAreFaster) {
  const auto delta_chi2 = told({0.06, 0.08});
  ASSERT_TRUE(delta_chi2.has_value());
  EXPECT_GT(*delta_chi2, 10.0);
}

TEST(LatencyBetweenRows, IsNotAskedWhereTheLogSaysHowCommandsGoOnOrSomethingElseTurnsTheBody) {
  EXPECT_FALSE(told({file_lag_s, 0.16, true}).has_value());
  EXPECT_FALSE(told({file_lag_s, 0.16, false, true}).has_value());
}

}  // namespace latency_between_rows_test
}  // namespace gustlab::diagnosis
