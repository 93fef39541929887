// The slung load, flown in the plant: static force, pendulum frequency, no damping of its own.
#include <gmock/gmock.h>

#include <cmath>

#include "plant/plant.hpp"
#include "support/effects.hpp"

namespace gustlab::test {
namespace slung_load_test {

constexpr double load_kg = 0.004, length_m = 0.3, step_s = 0.002;

// a vehicle whose rotors push through its centre of mass, so that it keeps its attitude
VehicleModel balanced() {
  VehicleModel vehicle = small_quadrotor();
  vehicle.center_of_mass_B_m.setZero();
  return vehicle;
}

std::vector<NamedEffect> with_load(double mass_kg = load_kg, double cable_m = length_m) {
  return make_effect_list({{"slung_load", {{"mass", mass_kg}, {"length", cable_m}}}});
}

RotorCommand lifting(const VehicleModel& vehicle, double force_N) {
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i)
    command.speed_radps[i] = std::sqrt(force_N / 4 / vehicle.rotors[i].thrust_coefficient_Ns2);
  return command;
}

TEST(SlungLoad, HangsWithItsWeight) {
  const VehicleModel vehicle = balanced();
  Plant plant(vehicle, with_load(), {.step_s = step_s});
  plant.reset(VehicleState{});
  const RotorCommand hover = lifting(vehicle, (vehicle.mass_kg + load_kg) * 9.81);
  for (int k = 0; k < 5000; ++k) ASSERT_TRUE(plant.step(hover));
  EXPECT_LT(plant.state().velocity_W_mps.norm(), 1e-10);
}

TEST(SlungLoad, AcceleratesUpAsOneBody) {
  const VehicleModel vehicle = balanced();
  Plant plant(vehicle, with_load(), {.step_s = step_s});
  plant.reset(VehicleState{});
  const double force_N = 0.5;
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(plant.step(lifting(vehicle, force_N)));
  EXPECT_NEAR(plant.state().velocity_W_mps.z(), force_N / (vehicle.mass_kg + load_kg) - 9.81, 1e-9);
}

TEST(SlungLoad, CableNeverPushes) {
  const VehicleModel vehicle = balanced();
  Plant plant(vehicle, with_load(), {.step_s = step_s});
  plant.reset(VehicleState{});
  // free fall: no tension
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(plant.step(RotorCommand{}));
  EXPECT_NEAR(plant.state().velocity_W_mps.z(), -9.81, 1e-9);
  // pushed down by a fan that outpulls gravity: the load does not hold it up
  std::vector<NamedEffect> effects = with_load();
  effects.push_back(make_effect("constant_force", {{"z", -1.0}}));
  Plant pushed(vehicle, std::move(effects), {.step_s = step_s});
  pushed.reset(VehicleState{});
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(pushed.step(RotorCommand{}));
  EXPECT_NEAR(pushed.state().velocity_W_mps.z(), -9.81 - 1.0 / vehicle.mass_kg, 1e-9);
}

// acceleration of the vehicle in x while load and vehicle swing freely about their common centre of mass
std::vector<double> swing(double load, double length, double seconds) {
  const VehicleModel vehicle = balanced();
  Plant plant(vehicle, with_load(load, length), {.step_s = step_s});
  const RotorCommand hover = lifting(vehicle, (vehicle.mass_kg + load) * 9.81);
  VehicleState state;
  plant.reset(state);
  // leaning for a moment sets it off
  const auto lean = [&](double angle_rad) {
    state = plant.state();
    state.attitude_WB = Eigen::AngleAxisd(angle_rad, Vector3::UnitY());
    plant.set_state(state);
  };
  lean(0.1);
  for (int k = 0; k < 25; ++k) EXPECT_TRUE(plant.step(hover));
  lean(0.0);
  std::vector<double> acceleration_mps2;
  for (int k = 0; k < std::lround(seconds / step_s); ++k) {
    const double before = plant.state().velocity_W_mps.x();
    EXPECT_TRUE(plant.step(hover));
    acceleration_mps2.push_back((plant.state().velocity_W_mps.x() - before) / step_s);
  }
  return acceleration_mps2;
}

TEST(SlungLoad, SwingsAtTheFrequencyOfTwoFreeMasses) {
  for (const auto& [load, length] : {std::pair{0.004, 0.3}, {0.002, 0.15}, {0.01, 0.65}}) {
    const double mass_kg = balanced().mass_kg;
    const double expected = std::sqrt(9.81 / length * (1 + load / mass_kg));
    const auto signal = swing(load, length, 20.0);
    // upward crossings of zero, interpolated
    std::vector<double> crossings;
    for (std::size_t k = 1; k < signal.size(); ++k)
      if (signal[k - 1] < 0.0 && signal[k] >= 0.0)
        crossings.push_back(step_s * (static_cast<double>(k) - signal[k] / (signal[k] - signal[k - 1])));
    ASSERT_GE(crossings.size(), 5u);
    const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
    EXPECT_NEAR(2 * pi / period / expected, 1.0, 5e-4) << length;
  }
}

TEST(SlungLoad, KeepsItsSwingForAMinute) {
  const auto signal = swing(load_kg, length_m, 60.0);
  const auto largest = [&](std::size_t from, std::size_t to) {
    double most = 0.0;
    for (std::size_t k = from; k < to; ++k) most = std::max(most, std::abs(signal[k]));
    return most;
  };
  const std::size_t n = signal.size();
  EXPECT_NEAR(largest(n - 1000, n) / largest(0, 1000), 1.0, 0.02);
}

}  // namespace slung_load_test
}  // namespace gustlab::test
