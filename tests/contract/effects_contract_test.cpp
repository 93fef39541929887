// What every row of the registry of effects must keep.
#include "contract/effects_flight.hpp"
#include "support/allocations.hpp"

// the template that scripts/new_plugin.py copies flies here as well
#define make_my_effect make_template_effect
#include "../../examples/plugins/effect.cpp"

namespace gustlab::test {
namespace effects_contract_test {

// as its author may leave it to the diagnosis
constexpr EffectRow template_row{.name = "template",
                                 .place = Place::wrench,
                                 .order = 10,
                                 .diagnosable = true,
                                 .says = "a spring",
                                 .shows_in = "motion",
                                 .confused_with = "nothing",
                                 .source = "the template",
                                 .make = make_template_effect};

class EffectContract : public ::testing::TestWithParam<std::string_view> {
 protected:
  const EffectRow* found = find_effect(GetParam());
  const EffectRow& row = found ? *found : template_row;
  const VehicleModel vehicle = lively_vehicle();
  Values natural() const { return natural_values(row, vehicle); }
};

TEST_P(EffectContract, ZeroStrengthChangesNoBit) {
  std::vector<NamedEffect> effects;
  effects.push_back(make_effect(row));
  Flight without({}), with(std::move(effects));
  EXPECT_EQ(without.numbers(2.0), with.numbers(2.0));
}

TEST_P(EffectContract, NaturalSizeShowsAndStaysFinite) {
  if (natural().empty()) GTEST_SKIP() << "has no parameter of its own";
  Flight without(planted(row, {})), with(planted(row, natural()));
  const std::vector<double> plain = without.numbers(1.0), changed = with.numbers(1.0);
  EXPECT_NE(plain, changed);
  EXPECT_TRUE(std::all_of(changed.begin(), changed.end(), [](double value) { return std::isfinite(value); }));
}

TEST_P(EffectContract, IsDeterministic) {
  Flight one(planted(row, natural())), two(planted(row, natural()));
  EXPECT_EQ(one.numbers(1.0), two.numbers(1.0));
}

TEST_P(EffectContract, TwoInstancesAreIndependent) {
  Flight alone(planted(row, natural()));
  const std::vector<double> expected = alone.numbers(1.0);
  Flight one(planted(row, natural())), other(planted(row, {}), {.seed = 8});
  std::vector<double> flown;
  for (int k = 0; k < 100; ++k) {
    const std::vector<double> part = one.numbers(0.01);
    flown.insert(flown.end(), part.begin(), part.end());
    other.numbers(0.01);
  }
  EXPECT_EQ(flown, expected);
}

TEST_P(EffectContract, SnapshotCarriesAllMemory) {
  Flight flight(planted(row, natural()));
  flight.numbers(0.5);
  const std::vector<double> snapshot = flight.plant().snapshot();
  const std::vector<double> expected = flight.numbers(0.5);
  flight.plant().restore(snapshot);
  EXPECT_EQ(flight.numbers(0.5), expected);
  // and into a plant that has flown elsewhere
  Flight fresh(planted(row, natural()));
  fresh.numbers(0.3);
  fresh.plant().restore(snapshot);
  EXPECT_EQ(fresh.numbers(0.5), expected);
}

TEST_P(EffectContract, ResetIsFresh) {
  Flight flight(planted(row, natural()));
  const std::vector<double> expected = flight.numbers(0.5);
  flight.plant().reset(lively_start(vehicle));
  EXPECT_EQ(flight.numbers(0.5), expected);
}

TEST_P(EffectContract, AllocatesNothingPerStep) {
  Flight flight(planted(row, natural()));
  flight.numbers(0.05);
  const std::size_t before = allocations();
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(flight.plant().step(lively_command(vehicle, flight.plant().steps())));
    flight.plant().observe(true);
    flight.plant().disturbance();
  }
  EXPECT_EQ(allocations(), before);
}

// a column of the diagnosis: the change that a small step from zero makes, per step
std::vector<double> column(const EffectRow& row, const std::string& parameter, double step, bool with_voltage) {
  const FlightOptions options{.with_voltage = with_voltage};
  Flight without(planted(row, {}), options), with(planted(row, {{parameter, step}}), options);
  std::vector<double> change = with.numbers(0.3);
  const std::vector<double> plain = without.numbers(0.3);
  for (std::size_t k = 0; k < change.size(); ++k) change[k] = (change[k] - plain[k]) / step;
  return change;
}

double norm(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum);
}

TEST_P(EffectContract, ColumnAtZeroStrengthIsThereAndStraight) {
  if (!row.diagnosable || row.name == "saturation" || row.name == "gust")
    GTEST_SKIP() << "has no column (DIAGNOSIS §5)";
  for (const Declared& parameter : parameters_of(*row.make())) {
    const bool is_choice = parameter.name == "rotor" || parameter.name == "length";
    if (is_choice || parameter.info.natural == 0.0) continue;
    const double step = 1e-3 * parameter.info.natural * scale_of(parameter.info.scale, vehicle);
    // the rate of sag counts where the voltage is not known
    const bool with_voltage = parameter.name != "rate";
    const std::vector<double> whole = column(row, parameter.name, step, with_voltage);
    std::vector<double> half = column(row, parameter.name, 0.5 * step, with_voltage);
    EXPECT_GT(norm(whole), 0.0) << parameter.name;
    for (std::size_t k = 0; k < half.size(); ++k) half[k] -= whole[k];
    EXPECT_LT(norm(half), 0.02 * norm(whole)) << parameter.name;
  }
}

// what is fixed in the world turns with it
Values turned(const EffectRow& row, Values values) {
  for (const auto& [x, y] : {std::pair{"x", "y"}, {"mean_x", "mean_y"}})
    if ((row.name == "steady_wind" || row.name == "constant_force" || row.name == "gust") &&
        values.count(x) + values.count(y) == 2) {
      const double old_x = values[x];
      values[x] = -values[y];
      values[y] = old_x;
    }
  return values;
}

TEST_P(EffectContract, KnowsNoPreferredHeading) {
  if (row.name == "measurement_noise") GTEST_SKIP() << "draws noise per world axis";
  Values values = natural();
  if (row.name == "gust") values = {{"mean_x", 0.02}, {"mean_y", -0.01}};
  if (row.name == "fans") values["turbulence"] = 0.0;               // each fan has its own
  const Quaternion turn(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5));  // a quarter to the left
  FlightOptions east, north;
  north.start.position_W_m = turn * east.start.position_W_m;
  north.start.velocity_W_mps = turn * east.start.velocity_W_mps;
  north.start.attitude_WB = turn * east.start.attitude_WB;
  for (Environment::Wall& wall : north.vehicle.environment.walls) wall = {turn * wall.point_W_m, turn * wall.normal_W};
  std::vector<Observation> seen_east, seen_north;
  std::vector<VehicleState> truth_east, truth_north;
  Flight(planted(row, values), east).fly(0.5, seen_east, truth_east);
  // the drag that goes with wind is alike in all headings
  Flight(planted(row, turned(row, values)), north).fly(0.5, seen_north, truth_north);
  for (std::size_t k = 0; k < seen_east.size(); ++k) {
    const auto near = [](const auto& a, const auto& b) { return (a - b).norm() < 1e-9 * (1.0 + b.norm()); };
    ASSERT_TRUE(near(truth_north[k].position_W_m, turn * truth_east[k].position_W_m)) << k;
    ASSERT_TRUE(near(truth_north[k].body_rate_B_radps, truth_east[k].body_rate_B_radps)) << k;
    ASSERT_TRUE(near(seen_north[k].position_W_m, turn * seen_east[k].position_W_m)) << k;
    ASSERT_TRUE(near(seen_north[k].velocity_W_mps, turn * seen_east[k].velocity_W_mps)) << k;
    ASSERT_LT(seen_north[k].attitude_WB.angularDistance(turn * seen_east[k].attitude_WB), 1e-7) << k;
    ASSERT_TRUE(near(seen_north[k].body_rate_B_radps, seen_east[k].body_rate_B_radps)) << k;
    ASSERT_TRUE(near(seen_north[k].specific_force_B_mps2, seen_east[k].specific_force_B_mps2)) << k;
  }
}

TEST_P(EffectContract, SaysWhatItIs) {
  EXPECT_FALSE(row.says.empty());
  EXPECT_FALSE(row.shows_in.empty());
  EXPECT_FALSE(row.source.empty());
  EXPECT_TRUE(!row.diagnosable || !row.confused_with.empty());
  for (const Declared& parameter : parameters_of(*row.make())) {
    EXPECT_FALSE(parameter.info.help.empty()) << parameter.name;
    EXPECT_FALSE(parameter.info.unit.empty()) << parameter.name;
    EXPECT_LE(parameter.info.min, parameter.value) << parameter.name;
    EXPECT_GE(parameter.info.max, parameter.value) << parameter.name;
    EXPECT_GE(parameter.info.natural, parameter.info.tolerance) << parameter.name;
    // natural size fits both a hand's breadth and half a metre
    for (const VehicleModel& size : {small_quadrotor(), large_quadrotor()})
      if (parameter.info.natural > 0.0) {
        EXPECT_LE(parameter.info.natural * scale_of(parameter.info.scale, size), parameter.info.max) << parameter.name;
      }
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, EffectContract, ::testing::ValuesIn(effect_names()),
                         [](const auto& tested) { return std::string(tested.param); });

INSTANTIATE_TEST_SUITE_P(Template, EffectContract, ::testing::Values("template"),
                         [](const auto& tested) { return std::string(tested.param); });

// F = k (p0 - p): what one step changes
TEST(EffectTemplate, PullsToItsAnchorWithItsFormula) {
  const VehicleModel vehicle = lively_vehicle();
  const Vector3 anchor_W_m(2.0, -1.0, 0.5);
  const double stiffness_Npm = 0.1 * vehicle.weight_N();
  const Values values{{"stiffness", stiffness_Npm},
                      {"anchor.x", anchor_W_m.x()},
                      {"anchor.y", anchor_W_m.y()},
                      {"anchor.z", anchor_W_m.z()}};
  std::vector<Observation> seen;
  std::vector<VehicleState> pulled, free;
  Flight(planted(template_row, values)).fly(step_s, seen, pulled);
  Flight({}).fly(step_s, seen, free);
  const Vector3 force_W_N = vehicle.mass_kg * (pulled[0].velocity_W_mps - free[0].velocity_W_mps) / step_s;
  const Vector3 wanted_W_N = stiffness_Npm * (anchor_W_m - lively_start(vehicle).position_W_m);
  EXPECT_LT((force_W_N - wanted_W_N).norm(), 0.01 * wanted_W_N.norm());
}

TEST(EffectRegistry, NamesAreUniqueAndFound) {
  for (const EffectRow& row : effect_registry()) EXPECT_EQ(find_effect(row.name), &row);
  EXPECT_EQ(find_effect("wind"), nullptr);
}

TEST(EffectRegistry, HasTheCatalogueInItsOrder) {
  const std::vector<std::string_view> catalogue = {
      "rotor_drag",      "quadratic_drag", "axial_inflow", "translational_lift", "flapping_torque",
      "ground_effect",   "ceiling_effect", "wall_effect",  "steady_wind",        "gust",
      "constant_force",  "slung_load",     "mass",         "center_of_mass",     "inertia",
      "thrust_scale",    "rotor_loss",     "rotor_tilt",   "motor_lag",          "actuation_delay",
      "thrust_curve",    "saturation",     "battery_sag",  "yaw_torque_ratio",   "rotor_inertia",
      "attitude_offset", "yaw_offset",     "pose_delay",   "imu_lever",          "gyro_scale"};
  std::vector<std::string_view> diagnosable;
  for (const EffectRow& row : effect_registry())
    if (row.diagnosable) diagnosable.push_back(row.name);
  EXPECT_EQ(diagnosable, catalogue);
}

}  // namespace effects_contract_test
}  // namespace gustlab::test
