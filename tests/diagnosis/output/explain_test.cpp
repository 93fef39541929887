// Sentences and tables from findings that are made by hand.
#include "diagnosis/output/explain.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace explain_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::SizeIs;

EffectFinding finding(const std::string& effect, std::vector<NamedValue> parameters) {
  EffectFinding result;
  result.effect = effect;
  result.parameters = std::move(parameters);
  return result;
}

// type and first value, as the file is read again
std::vector<std::pair<std::string, std::string>> read_again(const Diagnosis& d) {
  config::Table table = config::Table::parse(augmented_toml(d), "augmented.toml");
  std::vector<std::pair<std::string, std::string>> result;
  for (const EffectSpec& spec : config::read_effects(table))
    result.emplace_back(spec.type, spec.values.front().first + " = " + spec.values.front().second);
  return result;
}

TEST(AugmentedVehicle, HoldsTotalsAndWhatTheReferenceFlightsShowedUnlessItChanged) {
  Diagnosis d;
  d.vehicle = "crazyflie";
  d.reference_effects = {finding("mass", {{"delta", "-", 0.02, 0.001}}),
                         finding("rotor_loss", {{"rotor", "-", 2.0, 0.0}, {"loss", "-", 0.05, 0.01}}),
                         finding("rotor_drag", {{"at_hover", "N s/m", 0.01, 0.001}})};
  EffectFinding mass = finding("mass", {{"delta", "-", 0.03, 0.001}});
  mass.total = {{"delta", "-", 0.05, 0.001}};  // a change of 3 % beside the 2 % of the reference flights
  d.effects = {mass, finding("rotor_loss", {{"rotor", "-", 3.0, 0.0}, {"loss", "-", 0.1, 0.01}})};
  d.calibration = {finding("rotor_drag", {{"at_hover", "N s/m", 0.0125, 0.001}})};
  // the loss of another rotor is another effect
  EXPECT_THAT(read_again(d), ElementsAre(std::pair<std::string, std::string>("rotor_loss", "rotor = 2"),
                                         std::pair<std::string, std::string>("mass", "delta = 0.05"),
                                         std::pair<std::string, std::string>("rotor_loss", "rotor = 3"),
                                         std::pair<std::string, std::string>("rotor_drag", "at_hover = 0.0125")));
}

class Explained : public ::testing::Test {
 protected:
  static FlightData flight(bool collective_only, double yaw_rate_radps = 0.0) {
    const VehicleModel vehicle = test::crazyflie();
    const auto motion = [&](double time_s) {
      Motion at;
      at.attitude_WB = Eigen::AngleAxisd(yaw_rate_radps * time_s, Vector3::UnitZ());
      at.body_rate_B_radps.z() = yaw_rate_radps;
      return at;
    };
    FlightData flight =
        test::flight_of(vehicle, 20.0, 0.02, motion, [&](double) { return test::all_at(vehicle.hover_speed_radps()); });
    flight.collective_only = collective_only;
    return flight;
  }
  explicit Explained(bool collective_only = false, const VehicleModel& vehicle = test::crazyflie(),
                     std::vector<FlightData> filtered = {}, double second_yaw_rate_radps = 0.0)
      : session({flight(collective_only), flight(collective_only, second_yaw_rate_radps)}, vehicle, 1,
                std::move(filtered)) {
    session.linearise(session.value(), session.all_columns());
    selection.value = session.value();
    selection.deviation = Eigen::VectorXd::Zero(session.catalogue().size());
    selection.noise_selected = session.noise;
    // these flights tell of everything that there is
    selection.grams.columns = session.catalogue().size();
    selection.grams.block = {1e4 *
                             Eigen::MatrixXd::Identity(session.catalogue().size() + 1, session.catalogue().size() + 1)};
    selection.grams.cluster = {0}, selection.grams.flight = {0}, selection.grams.time_s = {0.0},
    selection.grams.known = {false};
    selection.grams.clusters = 1, selection.grams.rows = 1e4;
  }
  int column(const char* group) const {
    return session.catalogue().group(session.catalogue().find(group)).columns.front();
  }
  void found(const char* group, double change, double probability) {
    Finding& f = selection.findings.emplace_back();
    f.group = session.catalogue().find(group);
    f.delta_chi2 = 400.0;
    selection.value[column(group)] += change;
    Evidence& record = challenge.records.emplace_back();
    record.group = f.group, record.probability = probability;
    challenge.regimes.emplace_back();
  }
  void withdrawn(const char* group, double delta_chi2, double probability) {
    Evidence& gone = challenge.withdrawn.emplace_back();
    gone.group = session.catalogue().find(group);
    gone.delta_chi2 = delta_chi2, gone.probability = probability;
  }
  Diagnosis explained() const {
    Diagnosis d;
    explain(session, selection, challenge, d);
    return d;
  }
  Session session;
  Selection selection;
  Challenge challenge;
};

TEST_F(Explained, IsNamedSuspectedOrCalibrationByItsProbabilityAndItsSize) {
  found("mass", 0.05, 0.97);
  found("rotor_drag", 0.01, 0.6);
  found("thrust_curve", 0.001, 0.99);
  selection.findings.back().calibration = true;
  const Diagnosis d = explained();
  EXPECT_THAT(d.effects, ElementsAre(Field(&EffectFinding::effect, "mass")));
  EXPECT_THAT(d.suspected, ElementsAre(Field(&EffectFinding::effect, "rotor_drag")));
  EXPECT_THAT(d.calibration, ElementsAre(Field(&EffectFinding::effect, "thrust_curve")));
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.05, 1e-15);
  EXPECT_EQ(d.effects[0].confidence, 0.97);
}

TEST(WhatPushesAlike, IsAClassUnlessBothAreNamed) {
  Diagnosis d;
  for (const char* name : {"rotor_drag", "mass"}) {
    EffectFinding& effect = d.effects.emplace_back();
    effect.effect = name, effect.classmates = {name};
  }
  class_what_pushes_alike(d);
  EXPECT_THAT(d.effects[0].classmates, ElementsAre("rotor_drag"));
  EXPECT_THAT(d.effects[1].classmates, ElementsAre("mass", "thrust_scale"));
  d.effects[1].classmates = {"mass"};
  d.suspected.emplace_back().effect = "thrust_scale";
  class_what_pushes_alike(d);
  EXPECT_THAT(d.effects[1].classmates, ElementsAre("mass"));
}

// it stays beside the others while they are judged, and is no suspicion
TEST_F(Explained, IsRejectedBelowOneHalf) {
  found("rotor_drag", 0.01, 0.45);
  const Diagnosis d = explained();
  EXPECT_THAT(d.suspected, IsEmpty());
  EXPECT_THAT(d.rejected, Contains(AllOf(Field(&Rejected::effect, "rotor_drag"),
                                         Field(&Rejected::why, HasSubstr("makes it 45 % likely")))));
}

TEST_F(Explained, ADiagnosisSaysThatTorquesWereJudged) { EXPECT_EQ(to_json(explained())["torque_told"], true); }

// the logs tell the thrust of all rotors together
struct ExplainedThrust : Explained {
  ExplainedThrust() : Explained(true) {}
};

TEST_F(ExplainedThrust, ADiagnosisSaysThatNoTorqueWasJudged) { EXPECT_EQ(to_json(explained())["torque_told"], false); }

TEST_F(Explained, BesideReferenceFlightsTheChangeIsSaidAndTheTotalKept) {
  session.compare_with({});
  found("rotor_drag", 0.01, 0.97);  // 0.0072 are the vehicle file's
  const Diagnosis d = explained();
  ASSERT_EQ(d.effects.size(), 1u);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.01, 1e-12);
  EXPECT_NEAR(d.effects[0].total[0].value, 0.0172, 1e-12);
}

TEST_F(Explained, ARivalThatDoesAsWellSharesTheClassAndAWorseOneDoesNot) {
  found("mass", 0.05, 0.97);
  const int thrust = session.catalogue().find("thrust_scale"), drag = session.catalogue().find("rotor_drag");
  selection.findings[0].rivals = {{thrust, 0.5, 3.0, false}, {drag, 40.0, 30.0, false}};
  Diagnosis d = explained();
  ASSERT_EQ(d.effects.size(), 1u);
  EXPECT_THAT(d.effects[0].classmates, ElementsAre("mass", "thrust_scale"));
  EXPECT_EQ(d.effects[0].confusable.size(), 2u);
  // a spread that is as large as the difference, where half of the gain would be lost, makes no equal
  selection.findings[0].rivals[0].delta_chi2 = 0.6 * selection.findings[0].delta_chi2;
  EXPECT_THAT(explained().effects[0].classmates, ElementsAre("mass"));
  // what may as well be a trim of another name is calibration
  selection.findings[0].rivals[0] = {thrust, 0.5, 3.0, true};
  d = explained();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.calibration, ElementsAre(Field(&EffectFinding::effect, "mass")));
}

struct ExplainedFiltered : Explained {
  ExplainedFiltered() : Explained(false, test::crazyflie(), {flight(false), flight(false)}) {}
};

// half a second of a filtered log tells no load that swings; one that is lifted has no weight below nothing
TEST_F(ExplainedFiltered, AMassMayHang) {
  found("mass", 0.05, 0.97);
  EXPECT_THAT(explained().effects[0].classmates, Contains("slung_load"));
  selection.value[column("mass")] = -0.05;
  EXPECT_THAT(explained().effects[0].classmates, ::testing::Not(Contains("slung_load")));
}

// along one heading a push that stays in the body is one that stays in the world
TEST_F(Explained, ATiltMayBeAForceWhereNoFlightTurns) {
  found("rotor_tilt", 0.05, 0.97);
  EXPECT_THAT(explained().effects[0].classmates, ElementsAre("rotor_tilt", "steady_wind", "constant_force"));
  // a wind that was found beside it is not what it may be instead
  found("steady_wind", 1.0, 0.97);
  EXPECT_THAT(explained().effects[0].classmates, ElementsAre("rotor_tilt", "constant_force"));
}

struct ExplainedTurning : Explained {
  ExplainedTurning() : Explained(false, test::crazyflie(), {}, 1.0) {}
};

TEST_F(ExplainedTurning, ATiltIsNoForceWhereOneDoes) {
  found("rotor_tilt", 0.05, 0.97);
  EXPECT_THAT(explained().effects[0].classmates, ElementsAre("rotor_tilt"));
}

TEST_F(Explained, WhatEndedAtItsBoundIsRejectedForThat) {
  const int inertia = session.catalogue().find("inertia"), mass = session.catalogue().find("mass");
  selection.alone = {{inertia, 300.0}, {mass, 20.0}};
  selection.at_bounds = {inertia};
  const Diagnosis d = explained();
  const auto why = [&](const std::string& effect) {
    const auto at = std::ranges::find(d.rejected, effect, &Rejected::effect);
    return at == d.rejected.end() ? std::string() : at->why;
  };
  EXPECT_THAT(why("inertia"), HasSubstr("the largest or smallest that is allowed"));
  EXPECT_THAT(why("mass"), HasSubstr("too little better"));
}

TEST_F(Explained, WhatFlightsDoNotExciteIsSaidOnce) {
  for (int rotor = 1; rotor <= 4; ++rotor) {
    const int c = column(("rotor_loss#" + std::to_string(rotor)).c_str());
    selection.grams.block[0](c, c) = 0.0;
  }
  const Diagnosis d = explained();
  int times = 0;
  for (const NotIdentifiable& n : d.not_identifiable)
    if (n.effect == "rotor_loss") {
      ++times;
      EXPECT_THAT(n.why, HasSubstr("do not show"));
    }
  EXPECT_EQ(times, 1);
  for (const NotIdentifiable& n : d.not_identifiable) EXPECT_NE(n.effect, "mass");
}

TEST(WhatChannelsShow, OfTimeAreWhatMakesACommandOrAPoseLate) {
  std::vector<Mismatch> channels(3);
  channels[0].channel = "force_x", channels[1].channel = "actuation", channels[2].channel = "timing";
  say_what_channels_show(channels);
  EXPECT_THAT(channels[0].effects, IsEmpty());
  EXPECT_THAT(channels[1].effects, ElementsAre("motor_lag", "actuation_delay"));
  EXPECT_THAT(channels[2].effects, ElementsAre("pose_delay"));
}

// a page named "rotor loss" twice, and no rotor
TEST_F(Explained, AWithdrawnLossSaysOfWhichRotor) {
  withdrawn("rotor_loss#3", 12.0, 0.01);
  const Diagnosis d = explained();
  ASSERT_FALSE(d.rejected.empty());
  EXPECT_EQ(d.rejected[0].effect, "rotor_loss (rotor 3)");
}

TEST_F(Explained, WithdrawnNamesComeFirstAmongTheRejected) {
  withdrawn("gyro_scale", 12.0, 0.08);
  selection.alone = {{session.catalogue().find("mass"), 3.0}, {session.catalogue().find("rotor_loss#2"), 7.0}};
  const Diagnosis d = explained();
  ASSERT_EQ(d.rejected.size(), 3u);
  EXPECT_EQ(d.rejected[0].effect, "gyro_scale");
  EXPECT_THAT(d.rejected[0].why, HasSubstr("8 % likely"));
  EXPECT_EQ(d.rejected[1].effect, "rotor_loss (rotor 2)");
  EXPECT_EQ(d.rejected[2].effect, "mass");
}

// the page said of what removed 66 % of the error that it is 1 % likely, and not why
TEST_F(Explained, AWithdrawnNameSaysWhatSpeaksAgainstIt) {
  withdrawn("gyro_scale", 12.0, 0.08);
  challenge.withdrawn[0].features = {{"surrogate", 0.0}, {"gain", 1.0}};
  challenge.withdrawn[0].surrogates.p_value = 0.9;
  const Diagnosis d = explained();
  EXPECT_EQ(d.rejected[0].why, "its own evidence makes it 8 % likely: moved along the flight it fits as well");
  ASSERT_THAT(d.evidence, SizeIs(1));
  EXPECT_THAT(d.evidence[0].weak_points, ElementsAre("moved along the flight it fits as well"));
}

// a page listed one force twice: with what it had gained, and with what it would gain now beyond what its numbers cost
TEST_F(Explained, AWithdrawnNameIsSaidOnceWithTheScoreThatItHasNow) {
  withdrawn("constant_force", 12234.0, 0.01);
  withdrawn("gyro_scale", 12.0, 0.08);
  selection.alone = {{session.catalogue().find("mass"), 3.0}, {session.catalogue().find("constant_force"), 5.0}};
  const Diagnosis d = explained();
  std::vector<std::pair<std::string, double>> said;
  for (const Rejected& rejected : d.rejected) said.emplace_back(rejected.effect, rejected.score);
  using Said = std::pair<std::string, double>;
  // of one that the selection does not ask of again, what it gained less the price of its number
  EXPECT_THAT(said,
              ElementsAre(Said("constant_force", 5.0), Said("gyro_scale", 12.0 - std::log(1e4)), Said("mass", 3.0)));
  EXPECT_THAT(d.rejected[0].why, HasSubstr("1 % likely"));
}

// a page said that these flights tell nothing of an effect, and listed it with a score of 174288
TEST_F(Explained, WhatIsNotIdentifiableIsNotListedAsLookedAt) {
  withdrawn("translational_lift", 174288.0, 0.005);
  selection.alone = {{session.catalogue().find("translational_lift"), 7.0},
                     {session.catalogue().find("gyro_scale"), 6.0},
                     {session.catalogue().find("mass"), 5.0}};
  ASSERT_THAT(explained().rejected, SizeIs(3));
  for (const char* unseen : {"translational_lift", "gyro_scale"})
    for (const int c : session.catalogue().group(session.catalogue().find(unseen)).columns)
      selection.grams.block[0](c, c) = 0.0;
  const Diagnosis d = explained();
  EXPECT_THAT(d.not_identifiable, IsSupersetOf({Field(&NotIdentifiable::effect, "translational_lift"),
                                                Field(&NotIdentifiable::effect, "gyro_scale")}));
  EXPECT_THAT(d.rejected, ElementsAre(Field(&Rejected::effect, "mass")));
}

TEST_F(Explained, WhatIsNamedOrSuspectedIsNotSaidToBeNotIdentifiable) {
  found("mass", 0.05, 0.97);
  found("rotor_drag", 0.01, 0.6);
  for (const char* name : {"mass", "rotor_drag"}) selection.grams.block[0](column(name), column(name)) = 0.0;
  for (const NotIdentifiable& n : explained().not_identifiable) {
    EXPECT_NE(n.effect, "mass");
    EXPECT_NE(n.effect, "rotor_drag");
  }
}

// information of 1e4 of every number in typical sizes: five standard errors are a twentieth of it
TEST_F(Explained, OfEveryEffectThatFlightsWouldShowIsSaidThatItIsNotThere) {
  found("mass", 0.05, 0.97);
  const auto& groups = session.catalogue().groups();
  for (int g = 0; g < std::ssize(groups); ++g)
    if (groups[static_cast<std::size_t>(g)].candidate && !selection.find(g)) selection.alone.emplace_back(g, -1.0 - g);
  const Diagnosis d = explained();
  for (const EffectRow& row : effect_registry()) {
    if (!row.diagnosable || row.column == ColumnFrom::nowhere) continue;
    const auto has = [&](const auto& list) {
      return std::ranges::any_of(list, [&](const auto& entry) { return entry.effect.starts_with(row.name); });
    };
    EXPECT_TRUE(has(d.effects) || has(d.rejected) || has(d.not_identifiable)) << row.name;
  }
  const auto scale = std::ranges::find(d.rejected, "thrust_scale", &Rejected::effect);
  ASSERT_NE(scale, d.rejected.end());
  ASSERT_EQ(scale->would_show.size(), 1u);
  const Column& number = session.catalogue().columns()[static_cast<std::size_t>(column("thrust_scale"))];
  EXPECT_NEAR(scale->would_show[0].value, 0.05 * number.natural, 1e-12);
}

// of which nine parts of ten look like the mass that was found, and then all of it
TEST_F(Explained, WhatLooksLikeANameWouldShowFromALargerSizeOnAndNotBeyondItsBounds) {
  found("mass", 0.05, 0.97);
  selection.alone = {{session.catalogue().find("thrust_scale"), -1.0}};
  const int mass = column("mass"), thrust = column("thrust_scale");
  Eigen::MatrixXd& gram = selection.grams.block[0];
  const auto would_show = [&](double alike) {
    gram(mass, thrust) = gram(thrust, mass) = alike * 1e4;
    const Diagnosis d = explained();
    const auto scale = std::ranges::find(d.rejected, "thrust_scale", &Rejected::effect);
    return scale == d.rejected.end() ? std::vector<NamedValue>{} : scale->would_show;
  };
  const double natural = session.catalogue().column(thrust).natural;
  ASSERT_EQ(would_show(std::sqrt(0.9)).size(), 1u);
  EXPECT_NEAR(would_show(std::sqrt(0.9))[0].value, 0.05 * natural / std::sqrt(0.1), 1e-6 * natural);
  EXPECT_THAT(would_show(1.0), IsEmpty());
}

// a centre of mass costs three numbers
TEST_F(Explained, AnEffectOfManyNumbersWouldShowFromWhatPaysForThem) {
  selection.alone = {{session.catalogue().find("center_of_mass"), -1.0}};
  selection.grams.rows = 1e6;
  const Diagnosis d = explained();
  const auto center = std::ranges::find(d.rejected, "center_of_mass", &Rejected::effect);
  ASSERT_NE(center, d.rejected.end());
  ASSERT_EQ(center->would_show.size(), 3u);
  const double chance = SubsetSearch(session.catalogue(), session.vehicle(), 0.0).gained_by_chance();
  EXPECT_NEAR(
      center->would_show[0].value,
      std::sqrt((3.0 * std::log(1e6) + chance) / 1e4) * session.catalogue().column(column("center_of_mass")).natural,
      1e-9);
}

struct ExplainedWithoutDrag : Explained {
  static VehicleModel vehicle() {
    VehicleModel vehicle = test::crazyflie();
    vehicle.effects.clear();
    return vehicle;
  }
  ExplainedWithoutDrag() : Explained(false, vehicle()) {}
};

// the page said from which wind on it would show in a log of a vehicle that nothing holds back
TEST_F(ExplainedWithoutDrag, AWindThatNothingFeelsIsNotSaidToBeAbsent) {
  const int wind = session.catalogue().find("steady_wind");
  selection.alone = {{wind, -3.0}};
  const auto said = [&] { return explained().rejected.at(0); };
  EXPECT_THAT(said().why, HasSubstr("no wind is felt"));
  EXPECT_THAT(said().would_show, IsEmpty());
  found("rotor_drag", 0.01, 0.97);
  EXPECT_THAT(said().why, HasSubstr("does not make the predictions better"));
  EXPECT_EQ(said().would_show.size(), 3u);
}

// 40 s of flights hold 80 pieces of half a second
TEST_F(Explained, AGustIsItsPartsTimesTheMass) {
  GustParts parts;
  parts.horizontal_mps2 = 0.5, parts.vertical_mps2 = 0.2, parts.time_s = 0.5;
  Diagnosis d;
  explain_gust(session, parts, d);
  ASSERT_EQ(d.effects.size(), 1u);
  const std::vector<NamedValue>& values = d.effects[0].parameters;
  ASSERT_EQ(values.size(), 3u);
  const double mass = session.vehicle().mass_kg, pieces = 40.0 / 0.5;
  EXPECT_NEAR(values[0].value, 0.5 * mass, 1e-15);
  // two axes: the standard error of a deviation is 1/√(2n) of it, n = 2 pieces
  EXPECT_NEAR(values[0].deviation, 0.5 * mass * (1.0 / std::sqrt(2.0 * pieces) + decisions::model_form), 2e-3 * mass);
  EXPECT_NEAR(values[1].value, 0.2 * mass, 1e-15);
  EXPECT_NEAR(values[2].deviation, 0.5 * std::sqrt(2.0 / pieces), 1e-3);
  // and a line by itself
  parts.horizontal_mps2 = 0.0, parts.line_mps2 = 0.3, parts.line_radps = 2.2;
  explain_gust(session, parts, d);
  ASSERT_EQ(d.effects[1].parameters.size(), 2u);
  EXPECT_NEAR(d.effects[1].parameters[0].value, 0.3 * mass, 1e-15);
  EXPECT_EQ(d.effects[1].parameters[1].value, 2.2);
}

}  // namespace explain_test
}  // namespace gustlab::diagnosis
