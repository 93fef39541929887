// How much further a body turns between the rows of a log than the rates on them say.
#include "diagnosis/alignment/between_rows.hpp"

#include <gtest/gtest.h>

#include "diagnosis/model/propagation.hpp"
#include "diagnosis/recording/sensor_latency.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace between_rows_test {

// The attitudes of a log without noise say it.
double share_by_attitude(const FlightData& flight) {
  double further = 0.0, squared = 0.0;
  for (std::size_t k = 0; k + 1 < flight.samples.size(); ++k) {
    const Sample &now = flight.samples[k], &next = flight.samples[k + 1];
    const Vector3 turn = 0.5 * (next.time_s - now.time_s) * (now.body_rate_B_radps + next.body_rate_B_radps);
    further += (log_rotation(now.attitude_WB, next.attitude_WB) - turn).dot(turn);
    squared += turn.squaredNorm();
  }
  return further / squared;
}

// The loop runs at 500 Hz and sets new attitudes at 50 Hz.
test::TrialSettings quiet(double log_rate_hz) {
  return {.vehicle = "neurobem_racer",
          .fit = {"circle"},
          .holdout = {"lemniscate"},
          .sensors = {"pose", "velocity", "gyroscope", "accelerometer"},
          .duration_s = 15.0,
          .log_rate_hz = log_rate_hz,
          .noise = 0.0,
          .air_sd_N = 0.15};
}

FlightData flown(double log_rate_hz) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, quiet(log_rate_hz));
  const Recordings recordings = check(read_recordings(trial.fit, trial.holdout, {}, std::nullopt));
  return prepare(recordings.fit, recordings.vehicle, {}).front();
}

TEST(TurnBetweenRows, IsThatOfTheAttitudes) {
  for (const double rate_hz : {50.0, 100.0}) {
    const FlightData flight = flown(rate_hz);
    const double share = share_by_attitude(flight);
    EXPECT_GT(share, 0.001);
    EXPECT_NEAR(turn_between_rows({flight}).share, share, 0.25 * share) << rate_hz;
  }
}

// The gyroscope is half a step of 2 ms behind the attitudes; what turns between the rows looks like more.
TEST(TurnBetweenRows, IsNoLatencyOfTheGyroscope) {
  const FlightData flight = flown(50.0);
  EXPECT_GT(rate_latency_s({flight}), 0.0012);
  EXPECT_NEAR(rate_latency_s({flight}, {further_turns(flight)}), 0.001, 0.0001);
}

TEST(TurnBetweenRows, IsNoneWhereEveryCommandIsLogged) {
  EXPECT_NEAR(turn_between_rows({flown(500.0)}).share, 0.0, 1e-4);
}

TEST(TurnBetweenRows, IsNoneWithoutCommandsOfEachRotor) {
  FlightData flight = flown(50.0);
  flight.collective_only = true;
  EXPECT_EQ(turn_between_rows({flight}).share, 0.0);
}

}  // namespace between_rows_test
}  // namespace gustlab::diagnosis
