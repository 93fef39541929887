// What a row of the registry of effects says of itself is true of the effect: the diagnosis asks for these traits and for no name.
#include <algorithm>
#include <numbers>

#include "contract/effects_flight.hpp"

namespace gustlab::test {
namespace effect_traits_test {

// a symmetric vehicle, far from every surface
VehicleModel plain_vehicle() {
  VehicleModel vehicle = crazyflie();
  vehicle.effects.clear();
  vehicle.center_of_mass_B_m.setZero();
  vehicle.nominal_voltage_V = 3.8;
  return vehicle;
}

VehicleState at_rest(const VehicleModel& vehicle) {
  VehicleState state;
  state.position_W_m = {0.0, 0.0, 20.0};
  for (std::size_t i = 0; i < 4; ++i) state.rotor_speed_radps[i] = vehicle.hover_speed_radps();
  return state;
}

RotorCommand hover_command(const VehicleModel& vehicle, double factor = 1.0) {
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i) command.speed_radps[i] = factor * vehicle.hover_speed_radps();
  return command;
}

// how the first step of a flight changes the velocities of a vehicle, per second
struct FirstStep {
  Vector3 linear_W_mps2, angular_B_radps2;
};
FirstStep first_step(std::vector<NamedEffect> effects, VehicleState start, double voltage_V = 3.6,
                     RotorCommand command = hover_command(plain_vehicle())) {
  Plant plant(plain_vehicle(), std::move(effects), {.step_s = step_s, .seed = 7});
  plant.set_voltage(voltage_V);
  plant.reset(start);
  EXPECT_TRUE(plant.step(command));
  return {(plant.state().velocity_W_mps - start.velocity_W_mps) / step_s,
          (plant.state().body_rate_B_radps - start.body_rate_B_radps) / step_s};
}

Values first_number(const EffectRow& row, double value) { return {{parameters_of(*row.make()).front().name, value}}; }

class EffectTraits : public ::testing::TestWithParam<std::string_view> {
 protected:
  const EffectRow& row = *find_effect(GetParam());
  const VehicleModel vehicle = plain_vehicle();
  bool declares(std::string_view name) const {
    const std::vector<Declared> parameters = parameters_of(*row.make());
    return std::any_of(parameters.begin(), parameters.end(), [&](const Declared& p) { return p.name == name; });
  }
};

TEST_P(EffectTraits, AirIsFeltByThoseThatSaySoAndMovedByWinds) {
  const auto flown = [&](bool with_wind, bool with_drag) {
    std::vector<NamedEffect> effects = make_effect_list({{row.name, natural_values(row, lively_vehicle())}});
    if (with_wind) effects.push_back(make_effect("steady_wind", {{"x", 1.0}, {"y", -0.5}}));
    if (with_drag) effects.push_back(make_effect("rotor_drag", {{"at_hover", 0.01}}));
    return Flight(std::move(effects)).numbers(0.2);
  };
  if (row.air == Airflow::wind) {
    EXPECT_EQ(flown(false, false), Flight({}).numbers(0.2)) << "moves more than the air";
    EXPECT_NE(flown(false, true), Flight(make_effect_list({{"rotor_drag", {{"at_hover", 0.01}}}})).numbers(0.2));
  } else {
    EXPECT_EQ(flown(false, false) == flown(true, false), row.air == Airflow::ignored);
  }
}

TEST_P(EffectTraits, OfWhatFeelsTheAirDragAlonePushesAgainstAnyLevelMotion) {
  if (row.air != Airflow::felt && row.air != Airflow::drag) GTEST_SKIP();
  VehicleState start = at_rest(vehicle);
  start.velocity_W_mps = {2.0, 1.0, 0.0};
  const Vector3 push =
      first_step(planted(row, natural_values(row, vehicle)), start).linear_W_mps2 - first_step({}, start).linear_W_mps2;
  const double along = push.dot(start.velocity_W_mps.normalized());
  EXPECT_TRUE(row.air == Airflow::drag ? along < -1e-4 : std::abs(along) < 1e-9) << along;
}

TEST_P(EffectTraits, LagAnswersAtOnceAndInPartDelayLaterAndInFull) {
  if (row.place != Place::actuation) GTEST_SKIP();
  constexpr double latency_s = 5 * step_s;
  Plant plant(vehicle, planted(row, row.latency == Latency::none ? Values{} : first_number(row, latency_s)),
              {.step_s = step_s, .seed = 7});
  plant.reset(at_rest(vehicle));
  std::vector<double> answered;
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(plant.step(hover_command(vehicle, 1.1)));
    answered.push_back(plant.state().rotor_speed_radps[0] / vehicle.hover_speed_radps() - 1.0);
  }
  switch (row.latency) {
    case Latency::none:
      EXPECT_NEAR(answered[0], 0.1, 1e-9);
      break;
    case Latency::lag:
      EXPECT_NEAR(answered[0], 0.1 * (1.0 - std::exp(-step_s / latency_s)), 1e-9);
      break;
    case Latency::delay:
      EXPECT_NEAR(answered[3], 0.0, 1e-9);
      EXPECT_NEAR(answered[6], 0.1, 1e-9);
      break;
  }
}

TEST_P(EffectTraits, ChangesHowFastRotorsTurnIfItSaysSo) {
  const auto turning = [&](std::vector<NamedEffect> effects, double factor, bool speed_is_measured) {
    ForceModel forces(vehicle, std::move(effects));
    forces.set_speed_is_measured(speed_is_measured);
    forces.prepare(step_s, 7, 0);
    struct Held final : Actuation::Past {
      RotorArray before{};
      void command(double, RotorArray& speed) const override { speed = before; }
    } past;
    Actuation actuation;
    actuation.past = &past;
    actuation.step_s = step_s, actuation.voltage_V = 3.3;
    actuation.command_radps = hover_command(vehicle, factor).speed_radps;
    past.before = actuation.start_speed_radps = hover_command(vehicle).speed_radps;
    forces.actuate(actuation);
    return actuation.end_speed_radps;
  };
  bool changes = false;
  for (const double factor : {0.5, 1.1, 5.0})
    for (const bool speed_is_measured : {false, true})
      changes = changes || turning(planted(row, natural_values(row, vehicle)), factor, speed_is_measured) !=
                               turning({}, factor, speed_is_measured);
  EXPECT_EQ(changes, row.on_command);
}

TEST_P(EffectTraits, LateMeasurementsAreWhatWas) {
  if (row.place != Place::measurement || row.latency == Latency::none) GTEST_SKIP();
  EXPECT_EQ(row.latency, Latency::delay);
  Flight flight(planted(row, first_number(row, 5 * step_s)));
  std::vector<Observation> seen;
  std::vector<VehicleState> truth;
  flight.fly(0.2, seen, truth);
  const std::size_t last = seen.size() - 1;
  EXPECT_LT((seen[last].position_W_m - truth[last - 5].position_W_m).norm(), 1e-9);
}

TEST_P(EffectTraits, CorrectsWhatItSaysAndNothingElse) {
  if (row.place != Place::measurement || row.corrects == Corrects::nothing) {
    EXPECT_EQ(row.corrects, Corrects::nothing);
    return;
  }
  Flight without({}), with(planted(row, natural_values(row, vehicle)));
  std::vector<Observation> plain, changed;
  std::vector<VehicleState> truth;
  without.fly(0.1, plain, truth), with.fly(0.1, changed, truth);
  const std::vector<Declared> numbers = parameters_of(*row.make());
  for (std::size_t k = 0; k < plain.size(); ++k) {
    ASSERT_EQ(plain[k].position_W_m, changed[k].position_W_m);
    ASSERT_EQ(plain[k].velocity_W_mps, changed[k].velocity_W_mps);
    Vector3 turn = Vector3::Zero();
    double scale = 1.0;
    for (std::size_t p = 0; p < numbers.size(); ++p) {
      const double natural = numbers[p].info.natural;
      if (row.corrects == Corrects::attitude) turn[static_cast<Eigen::Index>(p)] = natural;
      if (row.corrects == Corrects::heading) turn.z() = natural;
      if (row.corrects == Corrects::rate_scale) scale += natural;
    }
    const Quaternion by =
        turn.isZero() ? Quaternion::Identity() : Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    ASSERT_LT(changed[k].attitude_WB.angularDistance(plain[k].attitude_WB * by), 1e-7);
    ASSERT_LT((changed[k].body_rate_B_radps - scale * plain[k].body_rate_B_radps).norm(), 1e-12);
  }
}

TEST_P(EffectTraits, OnlyWhatHasNoColumnIsRandom) {
  if (!row.diagnosable) GTEST_SKIP();
  const auto flown = [&](std::uint64_t seed) {
    return Flight(planted(row, natural_values(row, lively_vehicle())), {.seed = seed}).numbers(0.2);
  };
  EXPECT_EQ(flown(7) == flown(8), row.column != ColumnFrom::nowhere);
}

TEST_P(EffectTraits, HistoriesDeclareWhatTheirScanFinds) {
  if (row.column == ColumnFrom::swing) {
    EXPECT_TRUE(declares("mass") && declares("length"));
    EXPECT_GT(row.make()->state_size(), 0);
  }
  if (row.column == ColumnFrom::speed_limit) {
    EXPECT_TRUE(declares("max_speed"));
  }
  if (!row.is_history()) GTEST_SKIP();
  const std::vector<Declared> numbers = parameters_of(*row.make());
  EXPECT_EQ(
      std::count_if(numbers.begin(), numbers.end(), [](const Declared& p) { return p.info.fitted != Fitted::never; }),
      1)
      << "a history is one column";
}

TEST_P(EffectTraits, NumbersThatDependOnTheVoltageDoSo) {
  for (const Declared& p : parameters_of(*row.make())) {
    if (p.info.fitted != Fitted::with_voltage && p.info.fitted != Fitted::without_voltage) continue;
    const Values values = {{p.name, p.info.natural * scale_of(p.info.scale, vehicle)}};
    for (const bool with_voltage : {true, false}) {
      const bool changes = Flight(planted(row, values), {.with_voltage = with_voltage}).numbers(0.2) !=
                           Flight({}, {.with_voltage = with_voltage}).numbers(0.2);
      EXPECT_EQ(changes, (p.info.fitted == Fitted::with_voltage) == with_voltage) << p.name;
    }
  }
}

TEST_P(EffectTraits, NegativeNumbersAreAsTheOnesBefore) {
  const std::vector<Declared> numbers = parameters_of(*row.make());
  for (std::size_t p = 0; p < numbers.size(); ++p) {
    if (numbers[p].info.fitted != Fitted::unless_negative) continue;
    ASSERT_GT(p, 0u);
    const double natural = numbers[p - 1].info.natural;
    const auto flown = [&](double value) {
      return Flight(planted(row, {{numbers[p - 1].name, natural}, {numbers[p].name, value}})).numbers(0.2);
    };
    EXPECT_EQ(flown(-1.0), flown(natural));
    EXPECT_NE(flown(0.5 * natural), flown(natural));
  }
}

TEST_P(EffectTraits, ShowsInHoverAsItSays) {
  if (row.in_hover == InHover::nothing) GTEST_SKIP();
  Values values = natural_values(row, vehicle);
  if (row.in_hover == InHover::rotor) values["rotor"] = 2;
  const VehicleState rest = at_rest(vehicle);
  const FirstStep without = first_step({}, rest), with = first_step(planted(row, values), rest);
  const double lifts = std::abs((with.linear_W_mps2 - without.linear_W_mps2).z());
  const double turns = (with.angular_B_radps2 - without.angular_B_radps2).head<2>().norm();
  EXPECT_TRUE(lifts > 1e-3 || row.in_hover == InHover::center) << lifts;
  EXPECT_TRUE(row.in_hover == InHover::weight ? turns < 1e-9 : turns > 1e-3) << turns;
}

TEST_P(EffectTraits, EveryRotorHasItsOwn) {
  ASSERT_EQ(row.per_rotor, declares("rotor"));
  if (!row.per_rotor) return;
  Values second = natural_values(row, vehicle), third = second;
  second["rotor"] = 2, third["rotor"] = 3;
  EXPECT_NE(Flight(planted(row, second)).numbers(0.1), Flight(planted(row, third)).numbers(0.1));
}

// m, J and thrust grow alike: nothing moves otherwise
TEST_P(EffectTraits, WhatIsNeverBesideAnotherScalesWithIt) {
  if (row.never_beside.empty()) GTEST_SKIP();
  const EffectRow& other = *find_effect(row.never_beside);
  std::vector<NamedEffect> effects = planted(row, first_number(row, 0.1));
  effects.push_back(make_effect(other.name, first_number(other, 0.1)));
  Flight without({});
  EXPECT_NE(Flight(make_effect_list({{row.name, first_number(row, 0.1)}})).numbers(0.2), Flight({}).numbers(0.2));
  effects.push_back(make_effect("inertia", {{"delta_x", 0.1}, {"delta_y", 0.1}, {"delta_z", 0.1}}));
  const std::vector<double> plain = without.numbers(0.5), scaled = Flight(std::move(effects)).numbers(0.5);
  for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_NEAR(plain[i], scaled[i], 1e-9 * (1.0 + std::abs(plain[i])));
}

// about yaw alone, from rest: 1 + δ of the one is 1 / (1 + δ) of the other's last number
TEST_P(EffectTraits, ExactAliasTurnsTheVehicleAlike) {
  if (row.alias.effect.empty()) GTEST_SKIP();
  const EffectRow& other = *find_effect(row.alias.effect);
  RotorCommand command = hover_command(vehicle);
  for (std::size_t i = 0; i < 4; ++i) command.speed_radps[i] *= 1.0 + 0.01 * vehicle.rotors[i].direction;
  const auto yaw = [&](std::vector<NamedEffect> effects) {
    return first_step(std::move(effects), at_rest(vehicle), 3.6, command).angular_B_radps2.z();
  };
  const double delta = 0.2;
  const Values last = {{parameters_of(*other.make()).back().name, 1.0 / (1.0 + delta) - 1.0}};
  EXPECT_GT(std::abs(yaw(planted(row, first_number(row, delta))) - yaw({})), 0.1 * std::abs(yaw({})));
  EXPECT_NEAR(yaw(planted(row, first_number(row, delta))), yaw(planted(other, last)), 1e-6 * std::abs(yaw({})));
}

// a push to the side: of the row it turns with the heading, of the others it stays in the world
TEST_P(EffectTraits, LikeOthersUnlessTurningPushesInTheBodyWhatTheyPushInTheWorld) {
  if (row.like_unless_turning[0].empty() || row.place == Place::measurement) GTEST_SKIP();
  const auto push = [&](const EffectRow& pushing, double heading_rad) -> Vector3 {
    const Values values = {{parameters_of(*pushing.make()).front().name, 0.01}};
    VehicleState start = at_rest(vehicle);
    start.attitude_WB = Eigen::AngleAxisd(heading_rad, Vector3::UnitZ());
    return first_step(planted(pushing, values), start).linear_W_mps2 - first_step({}, start).linear_W_mps2;
  };
  const Vector3 own = push(row, 0.0);
  EXPECT_GT(own.x(), 1e-3);
  EXPECT_LT((push(row, 0.5 * std::numbers::pi) - own.x() * Vector3::UnitY()).norm(), 1e-6);
  for (const std::string_view name : row.like_unless_turning) {
    const Vector3 other = push(*find_effect(name), 0.0);
    EXPECT_LT((other.normalized() - own.normalized()).norm(), 1e-3) << name;
    EXPECT_LT((push(*find_effect(name), 0.5 * std::numbers::pi) - other).norm(), 1e-3 * other.norm()) << name;
  }
}

// lighter as it pushes harder, and one turns the vehicle otherwise
TEST_P(EffectTraits, LikeAnotherButForTurningPushesAsThatDoes) {
  if (row.like_but_for_turning.empty()) GTEST_SKIP();
  const EffectRow& other = *find_effect(row.like_but_for_turning);
  EXPECT_EQ(other.like_but_for_turning, row.name);
  constexpr double delta = 0.08;
  const auto moved = [&](const EffectRow& of, double value) {
    return first_step(planted(of, {{parameters_of(*of.make()).front().name, value}}), at_rest(vehicle));
  };
  const FirstStep own = moved(row, delta), like = moved(other, 1.0 / (1.0 + delta) - 1.0);
  EXPECT_NEAR(own.linear_W_mps2.z(), like.linear_W_mps2.z(), 1e-6);
}

TEST_P(EffectTraits, NamesOthersThatAreThereAndSaysWhy) {
  for (const std::string_view name :
       {row.stand_in, row.never_beside, row.alias.effect, row.alias.unless[0], row.alias.unless[1],
        row.like_but_for_turning, row.like_unless_turning[0], row.like_unless_turning[1]})
    if (!name.empty()) {
      ASSERT_NE(find_effect(name), nullptr) << name;
      EXPECT_TRUE(find_effect(name)->diagnosable);
      EXPECT_NE(name, row.name);
    }
  EXPECT_EQ(row.needs_any == Need::nothing, row.lacking.empty());
  if (row.stand_in.empty()) return;
  const EffectRow& other = *find_effect(row.stand_in);
  EXPECT_TRUE(row.needs_any != Need::nothing || !row.hidden_by_filter.empty()) << "is always told";
  EXPECT_TRUE(other.hidden_by_filter.empty() && (other.needs_any == Need::nothing || row.asks(other.needs_any)))
      << "is as hidden as what it stands for";
}

INSTANTIATE_TEST_SUITE_P(Registry, EffectTraits, ::testing::ValuesIn(effect_names()),
                         [](const auto& tested) { return std::string(tested.param); });

int count(bool (*is)(const EffectRow&)) {
  return static_cast<int>(std::count_if(effect_registry().begin(), effect_registry().end(), is));
}

// where the diagnosis writes or looks for the one effect of a kind, there is one
TEST(EffectKinds, OfSomeThereIsExactlyOne) {
  EXPECT_EQ(count([](const EffectRow& r) { return r.describes && !r.diagnosable; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.replay_only && !r.diagnosable; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.diagnosable && r.column == ColumnFrom::nowhere; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.diagnosable && r.column == ColumnFrom::swing; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.diagnosable && r.column == ColumnFrom::speed_limit; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.diagnosable && r.air == Airflow::wind; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.in_hover == InHover::center; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.in_hover == InHover::rotor; }), 1);
  EXPECT_EQ(count([](const EffectRow& r) { return r.in_hover == InHover::weight && r.place == Place::body; }), 1);
  for (const Place place : {Place::actuation, Place::measurement})
    for (const Latency latency : {Latency::lag, Latency::delay})
      EXPECT_LE(
          std::count_if(effect_registry().begin(), effect_registry().end(),
                        [&](const EffectRow& r) { return r.diagnosable && r.place == place && r.latency == latency; }),
          1);
}

// parameters that the diagnosis writes without having fitted a column for them
TEST(EffectKinds, DeclareWhatIsWrittenOfThem) {
  const auto names = [](bool (*is)(const EffectRow&)) {
    std::vector<std::string> result;
    for (const Declared& p : parameters_of(*first_effect(is).make())) result.push_back(p.name);
    return result;
  };
  using ::testing::IsSupersetOf;
  EXPECT_THAT(names([](const EffectRow& r) { return r.diagnosable && r.column == ColumnFrom::nowhere; }),
              IsSupersetOf({"sigma_xy", "sigma_z", "correlation_time", "line_amplitude", "line_frequency"}));
  EXPECT_THAT(names([](const EffectRow& r) { return r.in_hover == InHover::weight; }), IsSupersetOf({"x", "y", "z"}));
  EXPECT_THAT(names([](const EffectRow& r) { return r.in_hover == InHover::center; }), IsSupersetOf({"x", "y", "z"}));
  EXPECT_THAT(names([](const EffectRow& r) { return r.in_hover == InHover::weight && r.place == Place::body; }),
              IsSupersetOf({"delta"}));
  EXPECT_THAT(names([](const EffectRow& r) { return r.in_hover == InHover::rotor; }), IsSupersetOf({"rotor", "loss"}));
}

}  // namespace effect_traits_test
}  // namespace gustlab::test
