// Hubs on a circle against hand-computed places, and the vehicle that the written files say against the numbers that it was made of.
#include "vehicle/new_vehicle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"
#include "vehicle/estimates.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {
namespace new_vehicle_test {

// opposite hubs mirror each other and turns cancel, in every layout
TEST(NewVehicle, LayoutsAreBalanced) {
  ASSERT_FALSE(layouts().empty());
  for (const Layout& layout : layouts()) {
    const std::vector<Hub> hubs = hubs_on_circle(layout, 0.2);
    Vector3 sum = Vector3::Zero();
    double yaw = 0.0;
    for (const Hub& hub : hubs) {
      EXPECT_NEAR(hub.position_B_m.norm(), 0.2, 1e-12) << layout.name;
      sum += hub.position_B_m, yaw += hub.counter_clockwise ? 1.0 : -1.0;
    }
    EXPECT_NEAR(sum.norm(), 0.0, 1e-9) << layout.name;
    EXPECT_TRUE(yaw == 0.0 || hubs.size() % 2 == 1) << layout.name;
  }
}

TEST(NewVehicle, DegreesGoClockwiseFromTheNose) {
  static constexpr std::array<Layout::Place, 2> places = {{{90.0, true}, {30.0, false}}};
  const std::vector<Hub> hubs = hubs_on_circle({"test", "", "", places}, 2.0);
  EXPECT_NEAR((hubs[0].position_B_m - Vector3(0.0, -2.0, 0.0)).norm(), 0.0, 1e-12);  // right of the nose: y is left
  EXPECT_TRUE(hubs[0].counter_clockwise);
  EXPECT_NEAR((hubs[1].position_B_m - Vector3(std::sqrt(3.0), -1.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_FALSE(hubs[1].counter_clockwise);
}

TEST(NewVehicle, UnknownLayoutIsAnError) { EXPECT_THROW(find_layout("no such layout"), ConfigError); }

NewVehicle wanted() {
  NewVehicle w;
  w.name = "made";
  w.mass_kg = {1.2, "scale"};
  w.hubs = hubs_on_circle(layouts().front(), 0.2);
  w.hubs_source = "measured";
  w.propeller_diameter_m = Sourced{0.2, "label"};
  w.thrust_to_weight = Sourced{2.5, "guess"};
  w.inertia_kgm2 = {{{0.011, "swung"}, {0.012, "swung"}, {0.02, "swung"}}};
  return w;
}

TEST(NewVehicle, FilesSayTheNumbersThatTheyWereMadeOf) {
  const TemporaryFolder folder;
  const VehicleFiles files = new_vehicle_files(wanted());
  std::ofstream(folder.path() / "vehicle.toml") << files.vehicle_toml;
  std::ofstream(folder.path() / "made.xml") << files.mjcf;
  const VehicleModel vehicle = read_vehicle((folder.path() / "vehicle.toml").string());
  EXPECT_NEAR(vehicle.mass_kg, 1.2, 1e-9);
  EXPECT_EQ(vehicle.rotor_count, static_cast<int>(wanted().hubs.size()));
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(vehicle.inertia_B_kgm2(i, i), (*wanted().inertia_kgm2)[static_cast<std::size_t>(i)].value, 1e-6);
  double full_N = 0.0;
  for (std::size_t i = 0; i < wanted().hubs.size(); ++i) {
    EXPECT_NEAR((vehicle.rotors[i].position_B_m - wanted().hubs[i].position_B_m).head<2>().norm(), 0.0, 1e-4);
    EXPECT_EQ(vehicle.rotors[i].direction > 0.0, wanted().hubs[i].counter_clockwise);
    full_N += vehicle.rotors[i].thrust_coefficient_Ns2 * vehicle.max_speed_radps * vehicle.max_speed_radps;
  }
  EXPECT_NEAR(full_N / (1.2 * vehicle.gravity_mps2), 2.5, 0.01);
  // C_T ρ D⁴ / 4π² of a 0.2 m propeller with C_T = 0.11 in air of 1.2 kg/m³: 5.4e-6 N s²
  EXPECT_NEAR(estimated_thrust_coefficient_Ns2(0.2), 5.4e-6, 0.2e-6);
}

TEST(NewVehicle, NumbersThatContradictEachOtherAreErrors) {
  const auto broken = [](const std::function<void(NewVehicle&)>& change) {
    NewVehicle w = wanted();
    change(w);
    return w;
  };
  EXPECT_NO_THROW(new_vehicle_files(wanted()));
  EXPECT_THROW(new_vehicle_files(broken([](NewVehicle& w) { w.propeller_diameter_m->value = 0.5; })), ConfigError);
  EXPECT_THROW(new_vehicle_files(broken([](NewVehicle& w) { w.thrust_to_weight->value = 0.9; })), ConfigError);
  EXPECT_THROW(new_vehicle_files(broken([](NewVehicle& w) { w.hover = Sourced{0.4, "log"}; })), ConfigError);
  EXPECT_THROW(new_vehicle_files(broken([](NewVehicle& w) { w.thrust_to_weight.reset(); })), ConfigError);
}

// Ω = √(T / (C_T ρ D⁴ / 4π²)), by hand: 1.2 kg on 10 inches 58 m/s, a Crazyflie 53 m/s
TEST(NewVehicle, MassesThatPropellersCannotCarryAreRefusedOrSaid) {
  const auto made = [](double mass_kg, double arm_m, double diameter_m, double thrust_to_weight) {
    NewVehicle w = wanted();
    w.mass_kg.value = mass_kg, w.hubs = hubs_on_circle(layouts().front(), arm_m);
    w.propeller_diameter_m = Sourced{diameter_m, "label"}, w.thrust_to_weight = Sourced{thrust_to_weight, "label"};
    return new_vehicle_files(w).warnings;
  };
  EXPECT_TRUE(made(1.2, 0.25, 0.254, 2.1).empty());
  EXPECT_TRUE(made(0.032, 0.046, 0.045, 1.9).empty());
  EXPECT_TRUE(made(0.7, 0.11, 0.127, 12.0).empty());
  EXPECT_THROW(made(0.001, 1.0, 0.762, 2.0), ConfigError);   // 0.6 m/s
  EXPECT_THROW(made(10.0, 0.25, 0.0254, 2.0), ConfigError);  // 1670 m/s
  EXPECT_EQ(made(0.05, 0.25, 0.254, 2.0).size(), 1u);        // 12 m/s
  EXPECT_EQ(made(0.7, 0.11, 0.127, 14.9).size(), 1u);        // 88 m/s in hover, 341 m/s at full throttle
  EXPECT_EQ(made(1.2, 0.25, 0.254, 1.1).size(), 1u);         // it hovers, and cannot be steered
  EXPECT_EQ(made(1.2, 0.25, 0.254, 20.0).size(), 1u);        // no racer has it
  EXPECT_EQ(made(1.0, 3.0, 0.254, 2.0).size(), 1u);          // motors 4.2 m apart
}

TEST(NewVehicle, AHoverThrottleIsAThrustToWeight) {
  const auto hovers = [](double throttle) {
    NewVehicle w = wanted();
    w.thrust_to_weight.reset(), w.hover = Sourced{throttle, "log"};
    new_vehicle_files(w);
  };
  EXPECT_NO_THROW(hovers(0.5));
  EXPECT_THROW(hovers(0.99), ConfigError);
  EXPECT_THROW(hovers(0.001), ConfigError);
}

}  // namespace new_vehicle_test
}  // namespace gustlab
