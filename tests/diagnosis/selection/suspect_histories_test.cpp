// Effects that are a history of each flight: their scans on flights that have them.
#include "diagnosis/selection/suspect_histories.hpp"

#include <gtest/gtest.h>

#include "diagnosis/recording/recordings.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/limit_scan.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace {

// two flights of eight seconds
Recordings fly(const std::string& concealed) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, {.fit = {"multisine", "lemniscate"},
                                                         .holdout = {"circle"},
                                                         .duration_s = 8.0,
                                                         .log_rate_hz = 100.0,
                                                         .concealed = concealed});
  return check(read_recordings(trial.fit, trial.holdout, {}, std::nullopt));
}

// ready for the scans: linearised about the vehicle file, with the noise that this leaves
struct Unexplained {
  explicit Unexplained(const std::string& concealed) : recordings(fly(concealed)) {
    session.linearise(session.value(), session.all_columns());
    session.learn_noise(6, session.biases());
  }
  const Group& group(ColumnFrom column) const {
    return session.catalogue().groups()[static_cast<std::size_t>(session.catalogue().find(column))];
  }
  Recordings recordings;
  Session session{prepare(recordings.fit, recordings.vehicle, {}), recordings.vehicle, 1};
};

TEST(LimitScanOfFlights, FindsTheLimitAndGainsWhatItExplains) {
  const Unexplained limited(R"({type = "saturation", max_speed = 2120})");
  const LimitScan found = scan_limit(limited.session, limited.session.biases());
  EXPECT_NEAR(found.limit_radps, 2120.0, 30.0);
  EXPECT_GT(found.gain, decisions::least_limit_gain);
}

TEST(SuspectHistories, ALowerLimitIsSuspectedWhereItIs) {
  Unexplained limited(R"({type = "saturation", max_speed = 2120})");
  suspect_histories(limited.session, limited.session.value(), {});
  EXPECT_NEAR(limited.group(ColumnFrom::speed_limit).limit_radps, 2120.0, 30.0);
  for (const FlightData& flight : limited.session.flights())
    EXPECT_EQ(flight.limit_change.size(), flight.samples.size());
}

TEST(SuspectHistories, ASwingingLoadIsSuspectedWithItsLength) {
  Unexplained loaded(R"({type = "slung_load", mass = 0.004, length = 0.3})");
  suspect_histories(loaded.session, loaded.session.value(), {});
  EXPECT_NEAR(loaded.group(ColumnFrom::swing).swing.length_m, 0.3, 0.03);
  for (const FlightData& flight : loaded.session.flights())
    EXPECT_EQ(flight.load_force_W_mps2.size(), flight.samples.size());
}

}  // namespace
}  // namespace gustlab::diagnosis
