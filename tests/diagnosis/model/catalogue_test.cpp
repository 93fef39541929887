// Which numbers of which effects are columns, of logs that tell more or less.
#include "diagnosis/model/catalogue.hpp"

#include <gmock/gmock.h>

#include "diagnosis/result/decisions.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace catalogue_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Need pose = Need::attitude | Need::motion | Need::torque;

Catalogue catalogue(const Catalogue::Seen& seen, int flights = 1) { return {read_vehicle("crazyflie"), flights, seen}; }

std::vector<std::string> columns(const Catalogue& of, std::string_view label) {
  std::vector<std::string> names;
  const int g = of.find(label);
  if (g < 0) return names;
  for (const int c : of.group(g).columns) names.push_back(of.column(c).name);
  return names;
}

TEST(Catalogue, AnAccelerometerThatIsNotUsedIsNotCalledMissing) {
  Catalogue::Seen seen{.observable = Need::attitude | Need::motion};
  const EffectRow& lever =
      first_effect([](const EffectRow& row) { return row.diagnosable && row.asks(Need::accelerometer); });
  EXPECT_EQ(catalogue(seen).why_left_out(lever)->lack, Lack::accelerometer);
  seen.inertial_unused = true;
  EXPECT_EQ(catalogue(seen).why_left_out(lever)->lack, Lack::torque);
}

TEST(Catalogue, BatteryIsDescribedByItsVoltageWhereThatIsSeen) {
  EXPECT_THAT(columns(catalogue({.observable = pose, .voltage = true}), "battery_sag"), ElementsAre("exponent"));
  EXPECT_THAT(columns(catalogue({.observable = pose}), "battery_sag"), ElementsAre("rate"));
}

TEST(Catalogue, TheHeightOfACentreOfMassIsKnownBeforehandAndMayStayOut) {
  Catalogue all = catalogue({.observable = pose});
  const std::vector<int> of_center = all.group(all.find("center_of_mass")).columns;
  const auto known_to = [&](std::size_t i) { return all.column(of_center[i]).known_to; };
  EXPECT_EQ(known_to(0), 0.0);
  EXPECT_NEAR(known_to(2), 0.05 * read_vehicle("crazyflie").arm_m(), 1e-12);
  all.freeze(of_center[2]);
  EXPECT_THAT(columns(all, "center_of_mass"), ElementsAre("x", "y"));
}

TEST(Catalogue, AWindIsNearlyLevelAndNoHurricane) {
  const Catalogue all = catalogue({.observable = pose});
  const std::vector<int> wind = all.group(all.find("steady_wind")).columns;
  EXPECT_EQ(all.column(wind[0]).known_to, 0.0);
  EXPECT_FALSE(all.column(wind[0]).admits(-35.0));
  EXPECT_EQ(all.column(wind.back()).known_to, 1.0);  // m/s, up
}

TEST(Catalogue, AnInflowIsNoLargerThanTwiceMomentumTheoryAndARotorHardlyGains) {
  VehicleModel vehicle = read_vehicle("crazyflie");
  const auto column_of = [&](std::string_view label) {
    const Catalogue of(vehicle, 1, {.observable = pose});
    return of.column(of.group(of.find(label)).columns.front());
  };
  vehicle.rotor_radius_m = 0.023;
  const double disc_m2 = 4.0 * pi * 0.023 * 0.023;
  const double induced_mps = std::sqrt(vehicle.weight_N() / (2.0 * 1.225 * disc_m2));
  EXPECT_NEAR(column_of("axial_inflow").max, 2.0 * vehicle.weight_N() / induced_mps, 1e-12);
  EXPECT_EQ(column_of("axial_inflow").min, 0.0);
  vehicle.rotor_radius_m = 0.0;
  EXPECT_TRUE(std::isinf(column_of("axial_inflow").max));
  EXPECT_EQ(column_of("rotor_loss#2").min, -0.3);
  EXPECT_EQ(column_of("rotor_loss#2").max, 1.0);
}

TEST(Catalogue, AGyroscopesScaleNeedsAGyroscopeAndNoTorque) {
  const Need without = Need::attitude | Need::motion;
  EXPECT_THAT(columns(catalogue({.observable = without}), "gyro_scale"), IsEmpty());
  EXPECT_THAT(columns(catalogue({.observable = without | Need::gyro}), "gyro_scale"), ElementsAre("delta"));
}

TEST(Catalogue, TorqueTrimsAreOfEveryFlightWhoseTorquesAreTold) {
  const auto trims = [](const Catalogue& of) {
    return std::ranges::count_if(of.columns(), [](const Column& c) { return c.of_torque_trim(); });
  };
  EXPECT_EQ(trims(catalogue({.observable = pose}, 3)), 9);
  EXPECT_EQ(trims(catalogue({.observable = Need::attitude | Need::motion}, 3)), 0);
}

TEST(Catalogue, LagHasTwoTimeConstantsWhereTheMotionTellsThemApart) {
  const Catalogue quick = catalogue({.observable = pose});
  EXPECT_THAT(columns(quick, "motor_lag"), ElementsAre("time_constant", "time_constant_down"));
  for (const int c : quick.group(quick.find("motor_lag")).columns) EXPECT_EQ(quick.column(c).min, 0.0);
  VehicleModel vehicle = read_vehicle("crazyflie");
  vehicle.effects.clear();
  const Catalogue slow(vehicle, 1, {.observable = Need::attitude | Need::torque});
  EXPECT_THAT(columns(slow, "motor_lag"), ElementsAre("time_constant"));
}

TEST(Catalogue, HistoriesHaveOneColumnAndTheirScanTheRest) {
  const Catalogue all = catalogue({.observable = pose});
  EXPECT_THAT(columns(all, "slung_load"), ElementsAre("mass"));
  EXPECT_THAT(columns(all, "saturation"), ElementsAre("max_speed"));
  EXPECT_EQ(all.find(ColumnFrom::swing), all.find("slung_load"));
  EXPECT_EQ(all.find(ColumnFrom::speed_limit), all.find("saturation"));
  // which never fly in the linearised model
  Eigen::VectorXd value = all.nominal();
  for (const char* name : {"slung_load", "saturation"}) value[all.group(all.find(name)).columns.front()] = 1.0;
  for (const NamedEffect& effect : all.effects(value, 0)) EXPECT_FALSE(effect.row->is_history()) << effect.row->name;
}

TEST(Catalogue, EveryRotorAndEveryFlightHasItsOwn) {
  const Catalogue all = catalogue({.observable = pose}, 3);
  EXPECT_GE(all.find("rotor_loss#4"), 0);
  EXPECT_EQ(all.find("rotor_loss"), -1);
  EXPECT_EQ(columns(all, "steady_wind").size(), 9u);
  EXPECT_EQ(columns(all, "rotor_drag").size(), 1u);
}

TEST(Catalogue, SaysWhyAnEffectIsLeftOut) {
  const auto why = [](const Catalogue& of, std::string_view name) {
    return of.why_left_out(*find_effect(name)).value_or(NotIdentifiable{}).why;
  };
  const Catalogue all = catalogue({.observable = pose}),
                  filtered = catalogue({.observable = pose | Need::gyro, .trims = true}),
                  forces = catalogue({.observable = Need::attitude | Need::accelerometer});
  EXPECT_THAT(why(all, "mass"), IsEmpty());
  EXPECT_THAT(why(all, "steady_wind"), IsEmpty());
  EXPECT_THAT(why(all, "imu_lever"), HasSubstr("no accelerometer"));
  EXPECT_THAT(why(filtered, "steady_wind"), HasSubstr("see constant_force"));
  EXPECT_THAT(why(filtered, "gyro_scale"), IsEmpty());
  EXPECT_THAT(why(forces, "mass"), HasSubstr("see thrust_scale"));
  EXPECT_EQ(filtered.find("steady_wind"), -1);
  // what would tell it, as a value
  EXPECT_EQ(all.why_left_out(*find_effect("imu_lever"))->lack, Lack::accelerometer);
  EXPECT_EQ(filtered.why_left_out(*find_effect("steady_wind"))->lack, Lack::raw_sensors);
  EXPECT_EQ(forces.why_left_out(*find_effect("inertia"))->lack, Lack::torque);
  EXPECT_EQ(forces.why_left_out(*find_effect("ground_effect"))->lack, Lack::motion);
}

TEST(Catalogue, WhatFiltersMayBeIsNoGyroscope) {
  const auto tolerance = [](bool filtered) {
    const Catalogue all = catalogue({.observable = pose | Need::gyro, .trims = filtered});
    return all.column(all.group(all.find("gyro_scale")).columns.front()).tolerance;
  };
  EXPECT_EQ(tolerance(false), 0.005);
  EXPECT_EQ(tolerance(true), decisions::filter_rate_share);
}

TEST(Catalogue, FindsLatencyAndAirByWhatTheyDo) {
  const Catalogue all = catalogue({.observable = pose});
  EXPECT_EQ(all.find(Place::actuation, Latency::lag), all.find("motor_lag"));
  EXPECT_EQ(all.find(Place::actuation, Latency::delay), all.find("actuation_delay"));
  EXPECT_EQ(all.find(Place::measurement, Latency::delay), all.find("pose_delay"));
  EXPECT_EQ(all.find(Airflow::wind), all.find("steady_wind"));
  EXPECT_EQ(all.find(Airflow::drag), all.find("rotor_drag"));
}

TEST(Catalogue, OfAnExactAliasOneIsFree) {
  const Catalogue all = catalogue({.observable = pose});
  const int inertia = all.find("inertia"), ratio = all.find("yaw_torque_ratio"), drag = all.find("rotor_drag");
  EXPECT_EQ(own_columns(all, {inertia}, inertia).size(), 3u);
  EXPECT_EQ(own_columns(all, {inertia, ratio}, inertia).size(), 2u);
  EXPECT_EQ(own_columns(all, {drag, inertia, ratio}, inertia).size(), 3u);
}

TEST(Catalogue, CorrectsTheSensorsOfAFlight) {
  const Catalogue all = catalogue({.observable = pose | Need::gyro});
  Eigen::VectorXd value = all.nominal();
  const auto set = [&](std::string_view label, std::size_t i, double to) {
    value[all.group(all.find(label)).columns[i]] = to;
  };
  set("attitude_offset", 0, 0.01), set("attitude_offset", 1, -0.02), set("yaw_offset", 0, 0.03);
  set("pose_delay", 0, 0.015), set("gyro_scale", 0, 0.02);
  const SensorCorrection found = all.sensor_correction(value, 0);
  EXPECT_EQ(found.attitude_offset_B_rad, Vector3(0.01, -0.02, 0.03));
  EXPECT_EQ(found.pose_delay_s, 0.015);
  EXPECT_EQ(found.rate_scale, 0.02);
}

}  // namespace catalogue_test
}  // namespace gustlab::diagnosis
