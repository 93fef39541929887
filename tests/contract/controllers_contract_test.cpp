// What every row of the registry of controllers must keep, on a small, a large and an odd vehicle.
#include <gmock/gmock.h>

#include <limits>
#include <numbers>
#include <tuple>

#include "control/attitude.hpp"
#include "gustlab/random.hpp"
#include "support/allocations.hpp"
#include "support/fly.hpp"
#include "trajectories/trajectories.hpp"

// the template that scripts/new_plugin.py copies flies here as well
#define make_my_controller make_template_controller
#include "../../examples/plugins/controller.cpp"

namespace gustlab::test {
namespace controllers_contract_test {

constexpr ControllerRow template_row{.name = "template", .says = "", .source = "", .make = make_template_controller};

VehicleModel vehicle_named(std::string_view name) {
  if (name == "crazyflie") return crazyflie();
  if (name == "iris") return iris();
  if (name == "slow") return ring(4, 0.04, 0.05, 0.1);
  return ring(name == "three" ? 3 : 6, 1.5, 0.25, 0.03);
}

using Names = std::tuple<std::string_view, std::string_view>;

class ControllerContract : public ::testing::TestWithParam<Names> {
 protected:
  const ControllerRow* found = find_controller(std::get<0>(GetParam()));
  const ControllerRow& row = found ? *found : template_row;
  const VehicleModel vehicle = vehicle_named(std::get<1>(GetParam()));

  ControllerFlight flight(Controller& controller, const Trajectory& trajectory, double duration_s) const {
    ControllerFlight out;
    out.controller = &controller;
    out.trajectory = &trajectory;
    out.vehicle = vehicle;
    out.duration_s = duration_s;
    return out;
  }
  std::unique_ptr<Trajectory> hover() const {
    auto trajectory = make_hover();
    trajectory->prepare();
    return trajectory;
  }
  std::unique_ptr<Trajectory> eight() const {
    auto trajectory = make_lemniscate();
    set_number(*trajectory, "period_s", 8.0);
    trajectory->prepare();
    return trajectory;
  }
  // every command of a flight in a gust
  std::vector<double> commands(Controller& controller, double duration_s) const {
    std::vector<double> all;
    const auto trajectory = eight();
    ControllerFlight f = flight(controller, *trajectory, duration_s);
    f.force = gust(0.05 * vehicle.weight_N());
    f.heard = [&](const RotorCommand& command) {
      all.insert(all.end(), command.speed_radps.begin(), command.speed_radps.end());
    };
    fly(f);
    return all;
  }
};

TEST_P(ControllerContract, CommandsAreFiniteAndWithinTheRotorsLimits) {
  const auto controller = row.make();
  const std::vector<double> all = commands(*controller, 3.0);
  ASSERT_FALSE(all.empty());
  for (const double speed : all) {
    ASSERT_TRUE(std::isfinite(speed));
    ASSERT_GE(speed, 0.0);
    ASSERT_LE(speed, vehicle.max_speed_radps * 1.001);
  }
}

TEST_P(ControllerContract, IsDeterministic) {
  const auto one = row.make(), two = row.make();
  EXPECT_EQ(commands(*one, 2.0), commands(*two, 2.0));
}

TEST_P(ControllerContract, ResetIsFresh) {
  const auto controller = row.make();
  const std::vector<double> first = commands(*controller, 2.0);
  EXPECT_EQ(commands(*controller, 2.0), first);
}

TEST_P(ControllerContract, TwoInstancesAreIndependent) {
  const auto alone = row.make();
  const std::vector<double> expected = commands(*alone, 1.0);
  const auto one = row.make(), other = row.make();
  other->reset({vehicle, 1.0 / other->rate_hz(vehicle)}, Observation{});
  std::vector<double> all;
  const auto trajectory = eight();
  ControllerFlight f = flight(*one, *trajectory, 1.0);
  f.force = gust(0.05 * vehicle.weight_N());
  f.heard = [&](const RotorCommand& command) {
    all.insert(all.end(), command.speed_radps.begin(), command.speed_radps.end());
    Observation elsewhere;
    elsewhere.position_W_m = Vector3(3.0, -2.0, 1.0);
    other->update(elsewhere, Reference{});
  };
  fly(f);
  EXPECT_EQ(all, expected);
}

TEST_P(ControllerContract, UpdateAllocatesNothing) {
  const auto controller = row.make();
  Observation observation;
  observation.specific_force_B_mps2.z() = 9.81;
  observation.rotor_speed_radps.fill(vehicle.hover_speed_radps());
  const double period_s = 1.0 / controller->rate_hz(vehicle);
  controller->reset({vehicle, period_s}, observation);
  std::vector<double> told(controller->telemetry_names().size());
  const std::size_t before = allocations();
  for (int i = 0; i < 1000; ++i) {
    observation.time_s = observation.pose_time_s = observation.inertial_time_s = i * period_s;
    observation.velocity_W_mps.x() = 1e-3 * i;
    controller->update(observation, Reference{});
    controller->telemetry(told);
  }
  EXPECT_EQ(allocations(), before);
}

// GIVEN a controller in flight WHEN a sensor or the reference goes bad THEN the command says so, and no controller hides it
TEST_P(ControllerContract, FlagsANan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Harm = std::function<void(Observation&, Reference&)>;
  std::vector<std::pair<std::string, Harm>> harms{
      {"position", [=](Observation& o, Reference&) { o.position_W_m.x() = nan; }},
      {"height", [=](Observation& o, Reference&) { o.position_W_m.z() = nan; }},
      {"velocity", [=](Observation& o, Reference&) { o.velocity_W_mps.y() = nan; }},
      {"attitude", [=](Observation& o, Reference&) { o.attitude_WB.x() = nan; }},
      {"body rate", [=](Observation& o, Reference&) { o.body_rate_B_radps.x() = nan; }},
      {"reference", [=](Observation&, Reference& r) { r.position_W_m.y() = nan; }},
      {"yaw", [=](Observation&, Reference& r) { r.yaw_rad = nan; }}};
  const auto controller = row.make();
  if (controller->uses_accelerometer())
    harms.emplace_back("accelerometer", [=](Observation& o, Reference&) { o.specific_force_B_mps2.y() = nan; });
  for (const auto& [name, harm] : harms) {
    Observation observation;
    Reference reference;
    observation.specific_force_B_mps2.z() = 9.81;
    observation.rotor_speed_radps.fill(vehicle.hover_speed_radps());
    const double period_s = 1.0 / controller->rate_hz(vehicle);
    controller->reset({vehicle, period_s}, observation);
    for (int i = 0; i < 10; ++i) controller->update(observation, reference);
    harm(observation, reference);
    bool flagged = false;
    for (int i = 0; i < 50 && !flagged; ++i)
      for (const double speed : controller->update(observation, reference).speed_radps)
        flagged |= !std::isfinite(speed);
    EXPECT_TRUE(flagged) << name;
  }
}

TEST_P(ControllerContract, HoversWhereItShould) {
  const auto controller = row.make();
  const auto trajectory = hover();
  ControllerFlight f = flight(*controller, *trajectory, 20.0);
  f.settle_s = 10.0;
  const ControllerFlightEnd end = fly(f);
  EXPECT_TRUE(end.finite);
  EXPECT_LT(end.rmse_xy_m, 0.01);
  EXPECT_LT(end.rmse_z_m, 0.01);
}

TEST_P(ControllerContract, RejectsAConstantForce) {
  const auto controller = row.make();
  const auto trajectory = hover();
  ControllerFlight f = flight(*controller, *trajectory, 60.0);
  f.settle_s = 50.0;
  const Vector3 force = vehicle.weight_N() * Vector3(0.08, -0.05, 0.03);
  f.force = [=](double) { return force; };
  const ControllerFlightEnd end = fly(f);
  EXPECT_TRUE(end.finite);
  // against 0.5 m and more of a proportional law at such gains
  EXPECT_LT(end.rmse_xy_m, 0.1);
  EXPECT_LT(end.rmse_z_m, 0.05);
}

// GIVEN a start away from the reference, tilted and turned WHEN it flies THEN it arrives, level
TEST_P(ControllerContract, ConvergesFromReasonableAttitudes) {
  for (std::uint64_t i = 0; i < 6; ++i) {
    const auto u = RandomStream(1, 0, "controllers_contract").uniform4(i);
    const auto controller = row.make();
    const auto trajectory = make_hover();
    set<Vector3>(*trajectory, "start_offset_m", Vector3(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5));
    ControllerFlight f = flight(*controller, *trajectory, 40.0);
    const Vector3 axis(std::cos(6.0 * u[3]), std::sin(6.0 * u[3]), 0.0);
    f.start_attitude_WB = from_euler({0.0, 0.0, 3.0 * (u[2] - 0.5)}) * Quaternion(Eigen::AngleAxisd(0.8 * u[1], axis));
    const ControllerFlightEnd end = fly(f);
    EXPECT_TRUE(end.finite);
    EXPECT_LT(end.final_error_m, 0.03) << "start " << i;
    EXPECT_LT(end.final_tilt_rad, 0.02) << "start " << i;
  }
}

// GIVEN any attitude, on its side or its head WHEN it flies THEN no command and no state is other than a number, and the paper's
// vehicles arrive
TEST_P(ControllerContract, ConvergesFromEveryAttitude) {
  const bool of_the_paper = std::get<1>(GetParam()) == "crazyflie" || std::get<1>(GetParam()) == "iris";
  for (const double tilt_deg : {60.0, 90.0, 120.0, 170.0})
    for (int i = 0; i < 6; ++i) {
      const double azimuth = 0.05 + i * std::numbers::pi / 3.0;
      const auto controller = row.make();
      const auto trajectory = make_hover();
      ControllerFlight f = flight(*controller, *trajectory, of_the_paper ? 30.0 : 2.0);
      f.start_attitude_WB = Quaternion(
          Eigen::AngleAxisd(tilt_deg * std::numbers::pi / 180.0, Vector3(std::cos(azimuth), std::sin(azimuth), 0.0)));
      const ControllerFlightEnd end = fly(f);
      EXPECT_TRUE(end.finite) << tilt_deg << " degrees about " << azimuth << " rad";
      if (!of_the_paper) continue;
      EXPECT_LT(end.final_error_m, 0.2) << tilt_deg << " degrees about " << azimuth << " rad";
      EXPECT_LT(end.final_tilt_rad, 0.1) << tilt_deg << " degrees about " << azimuth << " rad";
    }
}

TEST_P(ControllerContract, FollowsAnEight) {
  const auto controller = row.make();
  const auto trajectory = make_lemniscate();
  trajectory->prepare();
  const ControllerFlightEnd end = fly(flight(*controller, *trajectory, 24.0));
  EXPECT_TRUE(end.finite);
  // the firmwares' laws without feed-forward lag behind by v/K_p, 0.26 m/s over 1 to 2 1/s; scaled gains more
  EXPECT_LT(end.rmse_xy_m, 0.4);
}

std::vector<std::string_view> controller_names() {
  std::vector<std::string_view> names{template_row.name};
  for (const ControllerRow& row : controller_registry()) names.push_back(row.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Registry, ControllerContract,
                         ::testing::Combine(::testing::ValuesIn(controller_names()),
                                            ::testing::Values("crazyflie", "iris", "six", "slow", "three")),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" + std::string(std::get<1>(test.param));
                         });

}  // namespace controllers_contract_test
}  // namespace gustlab::test
