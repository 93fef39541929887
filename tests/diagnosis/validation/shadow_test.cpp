// Names beside physics that no catalogue holds, and logs that were smoothed before they were written.
#include "diagnosis/validation/shadow.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/validation/regimes.hpp"
#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const char* const spring = R"({type = "sindy_residual", frame = "world", terms = ["1", "px", "py"], fx = [0.02, -0.06, 0], fy = [0, 0, -0.06], fz = [0, 0, 0]})";

test::TrialSettings settings(const std::string& concealed, double noise = 1.0) {
  return {.fit = {"lemniscate", "multisine"}, .holdout = {"circle"}, .duration_s = 9.0, .noise = noise, .concealed = concealed};
}

// Forward and backward through a filter of first order, twice: what was measured alone, as labs do before they publish. A quiet
// gyro, because a smoothed command hides the thrust that a noisy one makes.
constexpr double quiet = 0.1;
void smooth(const DiagnoseOptions& trial, double time_constant_s) {
  const auto measured = [](const std::string& name) { return !is_rotor_column(name); };
  test::change(trial, measured, [&](const FlightLog& log, std::vector<double>& values) {
    const double keep = std::exp(-(log.time_s[1] - log.time_s[0]) / time_constant_s);
    const auto once = [&](auto first, auto last) {
      for (double state = *first; first != last; ++first) *first = state = keep * state + (1.0 - keep) * *first;
    };
    for (int pass = 0; pass < 2; ++pass) once(values.begin(), values.end()), once(values.rbegin(), values.rend());
  });
}

TEST(Shadow, LatePoseStandsWhereGyroAndAttitudesTellIt) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose(test::fly_trial(folder, settings(std::string(spring) + R"(, {type = "pose_delay", delay = 0.015})")));
  ASSERT_THAT(d.alarms, Not(IsEmpty()));
  ASSERT_THAT(d.effects, ElementsAre(Field(&EffectFinding::effect, "pose_delay"))) << to_json(d).dump(1);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.015, 0.002);
  EXPECT_EQ(d.verdict, Verdict::partly_explained);
}

// even, and worth more than all that is left: it would stand, unless the sensors by themselves say that the pose is not late
TEST(Shadow, LatePoseStandsOrFallsByWhatGyroAndAttitudesTell) {
  const TemporaryFolder folder;
  const FlightLog log = read_flight_log(test::fly_trial(folder, settings("")).fit.front());
  const VehicleModel vehicle = read_vehicle(log.meta.vehicle, log.path);
  const Session session({prepare_flight(log, vehicle, {})}, vehicle, 1);
  Selection selection;
  selection.noise_nominal = selection.noise_selected = session.noise;
  for (double& variance : selection.noise_nominal.variance) variance *= 100.0;
  Remainder rest;
  rest.alarms.push_back({"omnibus", "something", 0.1, {}});
  rest.omnibus_gain = 10.0;
  const auto stands = [&](std::optional<double> told_s) {
    Diagnosis d;
    EffectFinding late;
    late.effect = "pose_delay";
    late.parameters = {{"delay", "s", 0.02, 0.001}};
    late.gain = 1000.0;
    late.astray = 0.0;
    d.effects.push_back(late);
    withdraw_shadows(session, selection, rest, 0.0, "", [&] { return told_s; }, d);
    EXPECT_EQ(d.effects.size() + d.rejected.size(), 1U);
    return d.rejected.empty();
  };
  EXPECT_TRUE(stands(std::nullopt));
  EXPECT_TRUE(stands(0.015));
  EXPECT_FALSE(stands(0.0));
  EXPECT_FALSE(stands(0.005));
}

TEST(Shadow, EvenMeansAlikeInEveryRegime) {
  Regimes even{.variable = "speed", .share = {1.0, 1.0, 1.0}, .deviation = {0.05, 0.05, 0.05}};
  EXPECT_NEAR(most_astray({even}), 0.05 * std::sqrt(2.0), 1e-12);
  Regimes uneven = even;
  uneven.share = {0.6, 1.0, 1.4};
  uneven.spread = 0.4;
  EXPECT_GT(most_astray({even, uneven}), 0.4);
  Regimes untold = even;
  untold.deviation = {0.05, 0.05, 1.0};
  EXPECT_EQ(most_astray({even, untold}), 1.0);
}

TEST(SmoothedLog, IsSaidAndItsDragNamed) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, settings(R"({type = "rotor_drag", at_hover = 0.02})", quiet));
  smooth(trial, 0.01);
  const Diagnosis d = diagnose(trial);
  EXPECT_THAT(d.log_findings, Contains(Field(&LogFinding::kind, "filtered")));
  ASSERT_THAT(d.effects, ElementsAre(Field(&EffectFinding::effect, "rotor_drag"))) << to_json(d).dump(1);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.02, 0.003);
  EXPECT_THAT(d.not_identifiable, Contains(AllOf(Field(&NotIdentifiable::effect, "steady_wind"), Field(&NotIdentifiable::why, HasSubstr("see constant_force")))));
  EXPECT_THAT(d.notes, Contains(HasSubstr("which the commands did not pass")));
}

TEST(SmoothedLog, WithoutMissingPhysicsNamesNothing) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, settings("", quiet));
  smooth(trial, 0.01);
  EXPECT_THAT(diagnose(trial).effects, IsEmpty());
}

}  // namespace
}  // namespace gustlab::diagnosis
