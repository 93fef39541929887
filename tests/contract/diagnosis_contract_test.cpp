// What the diagnosis owes every row of the registry: planted in flights that excite it it is found, and alone; planted below
// its reporting tolerance it is not named. A sample of the rows by default, all of them with GUSTLAB_EVERY_EFFECT=1.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>

#include "contract/effects_flight.hpp"
#include "support/trials.hpp"

namespace gustlab::test {
namespace diagnosis_contract_test {

using ::testing::IsEmpty;

// in a room with a ground, a ceiling and one wall; waypoints that come close to none of them
std::string room(std::string_view waypoints_m =
                     "[0,0,1, 0,0,0.7, 0.1,0,0.8, 0.3,0,1.0, 0.1,0.2,0.9, -0.2,0,1.2, 0,0,0.9, 0.5,0,1.1, 0.5,0.3,0.8, "
                     "0.2,0,1.1, -0.1,0,0.9, -0.3,0,1.0]") {
  return fmt::format(R"(
[environment]
ground_z_m = 0.0
ceiling_z_m = 2.0
walls = [[1.0, 0.0, -1.0, 0.0]]
[trajectory.lemniscate]
period_s = 4.0
[trajectory.multisine]
center_m = [0, 0, 1]
yaw_amplitude_rad = 1.2
yaw_frequency_hz = 0.25
[trajectory.waypoints]
points_m = {}
speed_mps = 0.35
[trajectory.circle]
radius_m = 0.7
ramp_s = 2.0
period_s = 4.0
start = "reference"
)",
                     waypoints_m);
}

// waypoints close to the surface that an effect needs; empty: it needs none
std::string_view waypoints_m(std::string_view effect) {
  if (effect == "ground_effect")
    return "[0,0,0.6, 0,0,0.3, 0,0,0.08, 0.3,0,0.08, 0.3,0,0.2, 0.3,0.3,0.12, 0,0.3,0.07, 0,0,0.3, -0.2,0,0.1, "
           "0,0,0.08, 0,0,0.5]";
  if (effect == "ceiling_effect")
    return "[0,0,1.2, 0.2,0,1.5, 0.2,0,1.8, -0.1,0,1.84, -0.3,0,1.8, 0,0.3,1.6, 0.2,0.2,1.84, 0,0,1.3]";
  if (effect == "wall_effect")
    return "[0,0,1, 0.8,0,1, 0.9,0,1, 0.92,0.4,1, 0.9,0,1.2, 0.6,0,1, 0.92,-0.3,0.8, 0.92,0.3,0.8, 0.4,0,1, 0.92,0,1]";
  return {};
}

// what the vehicle file says of an effect
Values nominal_values(const VehicleModel& vehicle, std::string_view name) {
  Values values;
  for (const EffectSpec& spec : vehicle.effects)
    if (spec.type == name)
      for (const auto& [key, value] : spec.values) values[key] = std::stod(value);
  return values;
}

// totals of an effect that is `sizes` natural sizes away from the vehicle file
Values strong_values(const EffectRow& row, const VehicleModel& vehicle, double sizes) {
  if (row.name == "gust") return {{"sigma_xy", 0.03}, {"sigma_z", 0.01}, {"correlation_time", 1.0}};
  // bites in the quick parts of these flights
  if (row.name == "saturation") return {{"max_speed", 1.12 * vehicle.hover_speed_radps()}};
  Values values = natural_values(row, vehicle);
  for (auto& [name, value] : values) value *= sizes;
  for (const auto& [name, value] : nominal_values(vehicle, row.name)) values[name] += value;
  if (row.name == "slung_load") values["length"] /= sizes;
  if (row.name == "battery_sag") values.erase("exponent");  // these logs have no voltage
  if (row.name == "rotor_loss") values["rotor"] = 3;
  return values;
}

// half of each tolerance away from the vehicle file; empty: none is declared
Values small_values(const EffectRow& row, const VehicleModel& vehicle) {
  Values values;
  for (const Declared& parameter : parameters_of(*row.make()))
    if (parameter.info.tolerance > 0.0)
      values[parameter.name] = 0.5 * parameter.info.tolerance * scale_of(parameter.info.scale, vehicle);
  if (values.empty()) return values;
  for (const auto& [name, value] : nominal_values(vehicle, row.name)) values[name] += value;
  if (row.name == "rotor_loss") values["rotor"] = 3;
  return values;
}

diagnosis::Diagnosis diagnose_with(const EffectRow& row, const Values& values) {
  std::string text = fmt::format("{{type = \"{}\"", row.name);
  for (const auto& [name, value] : values) text += fmt::format(", {} = {:.9g}", name, value);
  const TemporaryFolder folder;
  const std::string_view near = waypoints_m(row.name);
  return diagnosis::diagnose(fly_trial(folder, {.fit = {"lemniscate", "multisine", "waypoints"},
                                                .holdout = {near.empty() ? "circle" : "waypoints"},
                                                .sensors = {"pose", "velocity", "gyroscope", "accelerometer"},
                                                .duration_s = 16.0,
                                                .tables = near.empty() ? room() : room(near),
                                                .concealed = text + "}"}));
}

class DiagnosisContractTrials : public ::testing::TestWithParam<std::string_view> {
 protected:
  const EffectRow& row = *find_effect(GetParam());
  const VehicleModel vehicle = crazyflie();
};

TEST_P(DiagnosisContractTrials, FindsWhatIsPlantedAndNothingElse) {
  const diagnosis::Diagnosis d = diagnose_with(row, strong_values(row, vehicle, 3.0));
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  const diagnosis::EffectFinding& found = d.effects.front();
  EXPECT_TRUE(found.effect == row.name || std::count(found.classmates.begin(), found.classmates.end(), row.name) == 1)
      << found.effect << " was named for " << row.name;
}

TEST_P(DiagnosisContractTrials, DoesNotNameWhatIsBelowItsTolerance) {
  const Values values = small_values(row, vehicle);
  if (values.empty()) GTEST_SKIP() << "has no tolerance";
  EXPECT_THAT(diagnose_with(row, values).effects, IsEmpty());
}

std::vector<std::string_view> tested_effects() {
  if (const char* every = std::getenv("GUSTLAB_EVERY_EFFECT"); every == nullptr || *every == '\0')
    return {"quadratic_drag", "motor_lag", "rotor_loss"};
  std::vector<std::string_view> names;
  for (const EffectRow& row : effect_registry())
    if (row.diagnosable) names.push_back(row.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Registry, DiagnosisContractTrials, ::testing::ValuesIn(tested_effects()),
                         [](const auto& tested) { return std::string(tested.param); });

}  // namespace diagnosis_contract_test
}  // namespace gustlab::test
