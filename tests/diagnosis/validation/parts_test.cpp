// A force and a moment that belong together are of one size.
#include <gmock/gmock.h>

#include "diagnosis/validation/parts.hpp"
#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace parts_test {

using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;
using ::testing::Not;

Diagnosis diagnose_concealed(const std::string& concealed) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"multisine", "lemniscate"};
  trial.holdout = {"multisine"};
  trial.concealed = concealed;
  return diagnose(test::fly_trial(folder, trial));
}

// What an accelerometer behind a filter's delay of three rows records.
void delay_accelerometer(FlightData& flight) {
  flight.late.force_s = 3.0 * flight.sample_s;
  for (std::size_t k = flight.samples.size(); k-- > 3;)
    flight.samples[k].specific_force_B_mps2 = flight.samples[k - 3].specific_force_B_mps2;
}

// Effects fitted to one flight of fourteen seconds, and how the force of the first compares with its moment.
Parts parts_of(const std::vector<std::string>& effects, const std::string& concealed, bool late = false,
               double delta_chi2 = 0.0) {
  const TemporaryFolder folder;
  std::vector<std::string> sensors{"pose", "gyroscope"};
  if (late) sensors.push_back("accelerometer");
  const DiagnoseOptions trial = test::fly_trial(
      folder, {.fit = {"multisine"}, .holdout = {"multisine"}, .sensors = sensors, .concealed = concealed});
  const FlightLog log = read_flight_log(trial.fit.front());
  const VehicleModel vehicle = read_vehicle(log.meta.vehicle, log.path);
  FlightData flight = prepare_flight(log, vehicle, {});
  if (late) delay_accelerometer(flight);
  Session session({std::move(flight)}, vehicle, 1);
  Selection selection;
  for (const std::string& effect : effects) selection.findings.emplace_back().group = session.catalogue().find(effect);
  const std::vector<int> columns = session.with_biases(selection.groups());
  selection.value = session.value();
  for (int step = 0; step < 2; ++step) {
    session.linearise(selection.value, columns);
    session.learn_noise(3, columns);
    const Fit fit = solve(session.grams(columns).total(), columns);
    for (std::size_t i = 0; i < columns.size(); ++i)
      selection.value[columns[i]] +=
          fit.coefficient[static_cast<Eigen::Index>(i)] * session.catalogue().column(columns[i]).natural;
  }
  session.linearise(selection.value, session.all_columns());
  for (Finding& finding : selection.findings) finding.delta_chi2 = delta_chi2;
  return parts(session, selection).front();
}

TEST(Parts, OfAnInflowAreOfOneSizeAndThoseOfADampingAloneAreNot) {
  const Parts inflow = parts_of({"axial_inflow"}, R"({type = "axial_inflow", at_hover = 0.02})");
  ASSERT_GT(inflow.deviation, 0.0);
  EXPECT_LT(std::abs(inflow.excess), std::max(0.3, 3.0 * inflow.deviation));
  // the same moment, and a force that takes the first one's away
  const Parts damping = parts_of(
      {"axial_inflow"},
      R"({type = "axial_inflow", at_hover = 0.02}, {type = "sindy_residual", frame = "world", terms = ["vz"], fx = [0], fy = [0], fz = [0.02]})");
  ASSERT_GT(damping.deviation, 0.0);
  EXPECT_LT(damping.excess, -0.5);
  EXPECT_LT(damping.excess, -3.0 * damping.deviation);
  EXPECT_GT(damping.lacking, 0.4);
  EXPECT_GT(damping.lacking, 3.0 * damping.deviation);
}

// the moment says how large the inflow is, and its force is there: what pushes as well is something else
TEST(Parts, OfAnInflowLackNothingBesideAFurtherForce) {
  const Parts inflow = parts_of(
      {"axial_inflow"},
      R"({type = "axial_inflow", at_hover = 0.02}, {type = "sindy_residual", frame = "world", terms = ["vz"], fx = [0], fy = [0], fz = [-0.02]})");
  EXPECT_GT(inflow.excess, 0.5);
  EXPECT_GT(inflow.excess, 3.0 * inflow.deviation);
  EXPECT_LT(inflow.lacking, 0.3);
}

// what the push tells is less than a twentieth of all that was found
TEST(Parts, AreNotComparedWhereThePushIsASmallShare) {
  const Parts inflow = parts_of({"axial_inflow"}, R"({type = "axial_inflow", at_hover = 0.02})", false, 1e9);
  EXPECT_EQ(inflow.excess, 0.0);
  EXPECT_EQ(inflow.deviation, 0.0);
  EXPECT_EQ(inflow.lacking, 0.0);
}

TEST(Parts, OfADragAreOfOneSizeThoughTheAccelerometerIsLate) {
  const Parts drag =
      parts_of({"rotor_drag", "flapping_torque"},
               R"({type = "rotor_drag", at_hover = 0.3},{type="flapping_torque", coefficient=1e-6})", true);
  ASSERT_GT(drag.deviation, 0.0);
  EXPECT_LT(std::abs(drag.excess), 3.0 * drag.deviation);
}

TEST(PartsTrials, OfAnInflowAgree) {
  const Diagnosis d = diagnose_concealed(R"({type = "axial_inflow", at_hover = 0.02})");
  EXPECT_THAT(d.effects, Contains(Field(&EffectFinding::effect, "axial_inflow"))) << to_json(d).dump(1);
}

// it turns the vehicle as an inflow would, and does not push
TEST(PartsTrials, OfADampingAloneAreNoInflow) {
  const Diagnosis d = diagnose_concealed(
      R"({type = "axial_inflow", at_hover = 0.02}, {type = "sindy_residual", frame = "world", terms = ["vz"], fx = [0], fy = [0], fz = [0.02]})");
  EXPECT_THAT(d.effects, Each(Field(&EffectFinding::effect, Not("axial_inflow")))) << to_json(d).dump(1);
}

}  // namespace parts_test
}  // namespace gustlab::diagnosis
