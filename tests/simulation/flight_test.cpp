#include "simulation/flight.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "gustlab/errors.hpp"
#include "simulation/recorder.hpp"
#include "support/experiments.hpp"

namespace gustlab {
namespace flight_test {

using test::read_text_experiment;
using test::small_experiment;

// asks for the same speed of every rotor, and notes what it saw
class Recording final : public Controller {
 public:
  explicit Recording(double speed_radps) : speed_radps_(speed_radps) {}
  void visit(ParameterVisitor&) override {}
  double rate_hz(const VehicleModel&) const override { return 500.0; }
  void reset(const ControllerSetup&, const Observation&) override {}
  RotorCommand update(const Observation& observation, const Reference& reference) override {
    observations.push_back(observation);
    references.push_back(reference);
    RotorCommand command;
    command.speed_radps.fill(speed_radps_);
    return command;
  }
  std::vector<Observation> observations;
  std::vector<Reference> references;

 private:
  double speed_radps_;
};

RunRecord fly_first(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const Experiment experiment = read_text_experiment(text, overrides);
  return run(experiment, plan(experiment).front());
}

TEST(Flight, CompletesAndSamplesEveryTick) {
  const RunRecord record = fly_first(small_experiment);
  EXPECT_EQ(record.outcome, Outcome::completed);
  EXPECT_DOUBLE_EQ(record.duration_s, 1.0);
  EXPECT_EQ(record.error.samples, 500u);
  EXPECT_GT(record.error.planar.rmse_m, 0.0);
  // a vehicle that never moved would be the whole arc behind: 1 s of a 5 s lap of 1.1 m radius
  EXPECT_LT(record.error.planar.max_m, 0.8 * 2.0 * pi * 1.1 / 5.0);
}

TEST(Flight, SameSpecSameBits) {
  const RunRecord once = fly_first(small_experiment), again = fly_first(small_experiment);
  EXPECT_EQ(once.error.planar.rmse_m, again.error.planar.rmse_m);
  EXPECT_EQ(once.error.rmse_z_m, again.error.rmse_z_m);
  const RunRecord other = fly_first(small_experiment, {"seed=2"});
  EXPECT_NE(once.error.planar.rmse_m, other.error.planar.rmse_m);
}

TEST(Flight, LosingMostOfItsThrustItCrashesAndKeepsItsErrors) {
  const RunRecord record = fly_first(small_experiment + "[[effect]]\ntype = \"thrust_scale\"\ndelta = -0.9\n");
  EXPECT_EQ(record.outcome, Outcome::crashed);
  // free fall from 1 m at about 0.75 to 1 g
  EXPECT_GT(record.duration_s, 0.4);
  EXPECT_LT(record.duration_s, 0.6);
  EXPECT_EQ(record.error.samples, static_cast<std::size_t>(std::ceil(record.duration_s * 500.0 - 1e-6)));
  EXPECT_GT(record.error.rmse_z_m, 0.1);
}

TEST(Flight, BeyondTheEnvelopeItEnds) {
  const RunRecord far = fly_first(small_experiment, {"max_error_m=0.01"});
  EXPECT_EQ(far.outcome, Outcome::left_envelope);
  EXPECT_LT(far.duration_s, 1.0);
  const RunRecord fast = fly_first(small_experiment, {"max_speed_mps=0.01"});
  EXPECT_EQ(fast.outcome, Outcome::left_envelope);
}

TEST(Flight, StateThatIsNoLongerFiniteIsDivergedAtItsStep) {
  const RunRecord record = fly_first(small_experiment + "[[effect]]\ntype = \"constant_force\"\nx = 1e308\n");
  EXPECT_EQ(record.outcome, Outcome::diverged);
  EXPECT_DOUBLE_EQ(record.duration_s, 0.002);
  EXPECT_EQ(record.error.samples, 1u);
}

TEST(Flight, CommandThatIsNotFiniteIsTheControllersFault) {
  const Experiment experiment = read_text_experiment(small_experiment);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Flight flight(experiment, plan(experiment).front());
    flight.controller = std::make_unique<Recording>(bad);
    TrackingError error(0.0, 500);
    const FlightEnd end = fly(flight, error, nullptr);
    EXPECT_EQ(end.outcome, Outcome::controller_nonfinite);
    EXPECT_DOUBLE_EQ(end.time_s, 0.0);
  }
}

TEST(Flight, OffboardLinkHoldsPositionAndReferenceButNotTheGyro) {
  const Experiment experiment = read_text_experiment(small_experiment, {"offboard_rate_hz=50"});
  Flight flight(experiment, plan(experiment).front());
  auto controller = std::make_unique<Recording>(1500.0);
  Recording& seen = *controller;
  flight.controller = std::move(controller);
  flight.options.max_error_m = 1e9;
  TrackingError error(0.0, 500);
  fly(flight, error, nullptr);
  ASSERT_GT(seen.observations.size(), 40u);
  for (std::size_t tick = 1; tick < 40; ++tick) {
    const bool fresh = tick % 10 == 0;
    EXPECT_EQ(seen.observations[tick].pose_time_s == seen.observations[tick].time_s, fresh) << tick;
    EXPECT_EQ(seen.observations[tick].position_W_m != seen.observations[tick - 1].position_W_m, fresh) << tick;
    EXPECT_EQ(seen.references[tick].position_W_m != seen.references[tick - 1].position_W_m, fresh) << tick;
    EXPECT_NEAR(seen.observations[tick].inertial_time_s, static_cast<double>(tick) * 0.002, 1e-12);
  }
}

TEST(Flight, OffboardLinkBringsPosesLate) {
  const Experiment experiment =
      read_text_experiment(small_experiment, {"offboard_rate_hz=50", "offboard_delay_s=0.05"});
  Flight flight(experiment, plan(experiment).front());
  auto controller = std::make_unique<Recording>(1500.0);
  Recording& seen = *controller;
  flight.controller = std::move(controller);
  flight.options.max_error_m = 1e9;
  TrackingError error(0.0, 500);
  fly(flight, error, nullptr);
  ASSERT_GT(seen.observations.size(), 100u);
  // sent every 10 ticks of 2 ms, on the way for 25; the gyroscope does not travel
  for (std::size_t tick = 0; tick < 100; ++tick) {
    const std::size_t sent = tick < 25 ? 0 : (tick - 25) / 10 * 10;
    EXPECT_NEAR(seen.observations[tick].pose_time_s, static_cast<double>(sent) * 0.002, 1e-12) << tick;
    EXPECT_NEAR(seen.observations[tick].inertial_time_s, static_cast<double>(tick) * 0.002, 1e-12);
  }
}

// GIVEN a link that loses half of its messages and makes the others late by chance WHEN flying THEN poses never go back in time, set
// points hold where a message was lost, and the same replicate meets the same link
TEST(Flight, OffboardLinkLosesAndDelaysMessages) {
  const auto seen = [](std::uint32_t replicate) {
    const Experiment experiment = read_text_experiment(
        small_experiment,
        {"offboard_rate_hz=50", "offboard_delay_s=0.02", "offboard_jitter_s=0.06", "offboard_dropout=0.5"});
    RunSpec spec = plan(experiment).front();
    spec.replicate = replicate;
    Flight flight(experiment, spec);
    auto controller = std::make_unique<Recording>(1500.0);
    Recording& recording = *controller;
    flight.controller = std::move(controller);
    flight.options.max_error_m = 1e9;
    TrackingError error(0.0, 500);
    fly(flight, error, nullptr);
    std::vector<double> pose_times_s;
    std::size_t held = 0, fresh = 0;
    for (std::size_t tick = 1; tick < recording.observations.size(); ++tick) {
      pose_times_s.push_back(recording.observations[tick].pose_time_s);
      const double age_s = recording.observations[tick].time_s - pose_times_s.back();
      if (pose_times_s.back() > 0.0) {
        EXPECT_GT(age_s, 0.0199);
      }
      if (tick % 10 == 0)
        ++(recording.references[tick].position_W_m == recording.references[tick - 1].position_W_m ? held : fresh);
    }
    EXPECT_TRUE(std::is_sorted(pose_times_s.begin(), pose_times_s.end()));
    EXPECT_GT(held, fresh / 3);
    EXPECT_GT(fresh, held / 3);
    return pose_times_s;
  };
  EXPECT_EQ(seen(1), seen(1));
  EXPECT_NE(seen(1), seen(2));
}

// GIVEN a fixed gust WHEN replicates and seeds fly THEN all meet it; with a spread of the start each begins somewhere else in it
TEST(Flight, FixedGustIsTheSameInEveryRun) {
  const auto errors = [](const std::vector<std::string>& overrides) {
    std::set<double> different;
    const Experiment experiment = read_text_experiment(small_experiment, overrides);
    for (const RunSpec& spec : plan(experiment))
      if (spec.trajectory == 0) different.insert(run(experiment, spec).error.planar.rmse_m);
    return different;
  };
  EXPECT_EQ(errors({}).size(), 3u);
  EXPECT_EQ(errors({"effect.gust.realisation=fixed"}).size(), 1u);
  EXPECT_EQ(errors({"effect.gust.realisation=fixed"}), errors({"effect.gust.realisation=fixed", "seed=2"}));
  EXPECT_EQ(errors({"effect.gust={realisation=\"fixed\", start_spread=5}"}).size(), 3u);
}

TEST(Flight, ArcsSayHowMuchOfATrajectoryIsFlown) {
  const auto arcs =
      arcs_of(read_text_experiment(small_experiment, {"duration_s=2.5", "trajectory.circle.radius_m=1.0"}));
  // half of a lap of 5 s; hover has neither length nor laps
  EXPECT_EQ(arcs[0].name, "circle");
  EXPECT_EQ(arcs[0].value, "2.5 s, 3.1 m, 0.50 laps");
  EXPECT_EQ(arcs[1].value, "2.5 s, 0.0 m");
}

// the thrust that a force law subtracts is that between the poses it saw: 40 Hz of poses against its own 50 Hz bias nothing
// GIVEN a lap between two hovers WHEN it is flown THEN the reference stands where the vehicle starts, flies the lap, and stands at its end
TEST(Flight, HoversBeforeAndAfterALap) {
  const Experiment experiment =
      read_text_experiment(small_experiment, {"trajectories=circle", "laps=1", "duration_s=0", "hover_before_s=0.5",
                                              "hover_after_s=0.25", "trajectory.circle.start=center"});
  Flight flight(experiment, plan(experiment).front());
  EXPECT_DOUBLE_EQ(flight.manoeuvre_s, 5.0);
  EXPECT_DOUBLE_EQ(flight.options.duration_s, 5.75);
  EXPECT_EQ(flight.ticks, 2875);
  EXPECT_EQ(flight.reference_at(0.25).position_W_m, flight.trajectory->start_position_W_m());
  EXPECT_EQ(flight.reference_at(0.25).velocity_W_mps, Vector3::Zero());
  EXPECT_EQ(flight.reference_at(1.5).position_W_m, flight.trajectory->at(1.0).position_W_m);
  EXPECT_EQ(flight.reference_at(1.5).velocity_W_mps, flight.trajectory->at(1.0).velocity_W_mps);
  EXPECT_EQ(flight.reference_at(5.6).position_W_m, flight.trajectory->at(5.0).position_W_m);
  EXPECT_EQ(flight.reference_at(5.6).velocity_W_mps, Vector3::Zero());
  EXPECT_NE(arcs_of(experiment).front().value.find("1.00 laps, 0.5 s of hover before, 0.25 s of hover after"),
            std::string::npos);
}

TEST(Flight, SaysWhatIsWrongWithItsLength) {
  const auto message = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      read_text_experiment(small_experiment, overrides);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message({"laps=1"}).find("stands beside \"duration_s\""), std::string::npos);
  EXPECT_NE(message({"laps=1", "duration_s=0", "trajectories=hover"}).find("has no laps"), std::string::npos);
  EXPECT_NE(message({"set_points=velocity"}).find("\"velocity\" is unknown"), std::string::npos);
}

// Flies it with a controller that records; what that saw lives as long as the flight.
const Recording& fly_recorded(const Experiment& experiment, Flight& flight) {
  auto recording = std::make_unique<Recording>(experiment.vehicle.hover_speed_radps());
  const Recording& seen = *recording;
  flight.controller = std::move(recording);
  TrackingError error(0.0, static_cast<std::size_t>(flight.ticks));
  fly(flight, error, nullptr);
  return seen;
}

TEST(Flight, StreamedSetPointsHoldPositionAndHeadingAlone) {
  const Experiment experiment = read_text_experiment(small_experiment, {"set_points=position"});
  Flight flight(experiment, plan(experiment).front());
  const Recording& seen = fly_recorded(experiment, flight);
  ASSERT_GT(seen.references.size(), 100u);
  EXPECT_EQ(seen.references[100].position_W_m, flight.trajectory->at(100 * flight.tick_s).position_W_m);
  EXPECT_EQ(seen.references[100].velocity_W_mps, Vector3::Zero());
  EXPECT_EQ(seen.references[100].acceleration_W_mps2, Vector3::Zero());
}

// up to the hand-over the vehicle's own loop flies; then the controller starts afresh, with what it sees then
TEST(Flight, HandsOverAfterTakeOff) {
  const Experiment experiment = read_text_experiment(small_experiment, {"hand_over_s=0.5"});
  Flight flight(experiment, plan(experiment).front());
  const Recording& seen = fly_recorded(experiment, flight);
  ASSERT_EQ(seen.observations.size(), static_cast<std::size_t>(flight.ticks - 250));
  EXPECT_DOUBLE_EQ(seen.observations.front().time_s, 0.5);
  // the first loop flew after the reference
  EXPECT_GT(seen.observations.front().velocity_W_mps.norm(), 0.05);
}

TEST(Flight, SeldomPosesDoNotBiasTheMeasuredForce) {
  const RunRecord record = fly_first(R"(
format = "gustlab-experiment/1"
name = "seldom"
vehicle = "iris"
trajectories = ["hover"]
controllers = ["asindy"]
duration_s = 10.0
step_s = 0.0025
offboard_rate_hz = 40.0
)");
  EXPECT_LT(record.error.rmse_z_m, 1e-3);
}

TEST(Flight, FinerStepsConvergeToTheSameFlight) {
  const auto rmse = [](const char* step) { return fly_first(small_experiment, {step}).error.planar.rmse_m; };
  const double coarse = rmse("step_s=0.002"), middle = rmse("step_s=0.001"), fine = rmse("step_s=0.0005");
  EXPECT_LT(std::abs(fine - middle), 0.7 * std::abs(middle - coarse));
  EXPECT_LT(std::abs(fine - coarse), 0.05 * coarse);
}

// paired comparison: the gust of a replicate is the same for every controller and every trajectory
TEST(Flight, EveryControllerMeetsTheSameGusts) {
  const Experiment experiment = read_text_experiment(small_experiment, {"controllers=[\"pid\", \"geometric\"]"});
  std::vector<std::vector<double>> forces;
  for (const RunSpec& spec : plan(experiment)) {
    if (spec.replicate != 2) continue;
    Flight flight(experiment, spec);
    TrackingError error(0.0, 500);
    FlightRecorder recorder(experiment, flight);
    fly(flight, error, &recorder);
    forces.push_back(*recorder.take().find("fx"));
  }
  ASSERT_EQ(forces.size(), 4u);
  ASSERT_EQ(forces[0].size(), 500u);
  EXPECT_NE(forces[0].back(), 0.0);
  for (const auto& force : forces)
    for (std::size_t row = 0; row < force.size(); ++row) EXPECT_NEAR(force[row], forces[0][row], 1e-15);
}

TEST(Recorder, LogAgreesWithTheTruthItWasMadeOf) {
  const Experiment experiment = read_text_experiment(small_experiment, {"log_rate_hz=27.77777777777778"});
  Flight flight(experiment, plan(experiment).front());
  TrackingError error(0.0, 500);
  FlightRecorder recorder(experiment, flight);
  fly(flight, error, &recorder);
  const FlightLog log = recorder.take();
  // every 18th tick of 500 Hz
  ASSERT_EQ(log.rows(), 28u);
  EXPECT_EQ(log.meta.hold, Hold::unknown);
  for (std::size_t row = 0; row < log.rows(); ++row) {
    EXPECT_NEAR(log.time_s[row], 0.036 * static_cast<double>(row), 1e-12);
    EXPECT_NEAR(log.find("awx")->at(row) * 0.0282, log.find("fx")->at(row), 1e-9);
  }
  for (const LogColumn& column : log.columns) EXPECT_EQ(column.values.size(), log.rows()) << column.name;
  EXPECT_EQ(log.find("pz")->front(), 1.0);
  // thrust is about the weight: an accelerometer at hover reads g upwards
  EXPECT_NEAR(log.find("az")->front(), 9.81, 0.2);
}

TEST(Recorder, SensorsAreNoisyAndTruthIsNot) {
  const std::string noisy = small_experiment + "[[effect]]\ntype = \"measurement_noise\"\nposition_sd = 0.01\n";
  const auto first_position = [&](const char* source) {
    const Experiment experiment = read_text_experiment(noisy, {std::string("log_source=") + source});
    Flight flight(experiment, plan(experiment).front());
    TrackingError error(0.0, 500);
    FlightRecorder recorder(experiment, flight);
    fly(flight, error, &recorder);
    return recorder.take().find("pz")->front();
  };
  EXPECT_EQ(first_position("truth"), 1.0);
  EXPECT_NE(first_position("sensors"), 1.0);
}

}  // namespace flight_test
}  // namespace gustlab
