// Effects that are a history of each flight: found whether an accelerometer feels them or not, and told from a gust.
#include <gmock/gmock.h>

#include "diagnosis/selection/pendulum.hpp"
#include "diagnosis/selection/swing_fit.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace history_test {

class HistoryTrials : public ::testing::TestWithParam<bool> {
 protected:
  static Diagnosis diagnose_concealed(const std::string& concealed,
                                      std::vector<std::string> fit = {"lemniscate", "multisine"}) {
    const TemporaryFolder folder;
    test::TrialSettings trial;
    trial.fit = std::move(fit);
    trial.holdout = {"circle"};
    if (GetParam()) trial.sensors.emplace_back("accelerometer");
    trial.concealed = concealed;
    return diagnose(test::fly_trial(folder, trial));
  }
};

TEST_P(HistoryTrials, FindsASlungLoad) {
  const Diagnosis d = diagnose_concealed(R"({type = "slung_load", mass = 0.004, length = 0.3})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "slung_load");
  EXPECT_NEAR(test::value_of(d.effects[0], "mass"), 0.004, 0.0002);
  EXPECT_NEAR(test::value_of(d.effects[0], "length"), 0.3, 0.015);
}

TEST_P(HistoryTrials, FindsALowerSpeedLimit) {
  const Diagnosis d = diagnose_concealed(R"({type = "saturation", max_speed = 2120})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "saturation");
  EXPECT_NEAR(test::value_of(d.effects[0], "max_speed"), 2120.0, 30.0);
}

TEST_P(HistoryTrials, DoesNotHangAWeightlessLoadOnAPeriodicGust) {
  const Diagnosis d = diagnose_concealed(R"({type = "gust", line_amplitude = 0.012, line_frequency = 3.0})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "gust");
}

INSTANTIATE_TEST_SUITE_P(Accelerometer, HistoryTrials, ::testing::Bool(),
                         [](const auto& with) { return with.param ? "with" : "without"; });

// below a vehicle at rest, out to almost level and back for a minute
TEST(Swing, NeitherGainsNorLosesEnergyByItself) {
  FlightData flight;
  for (int k = 0; k < 6000; ++k) {
    Sample sample;
    sample.time_s = 0.01 * k;
    flight.samples.push_back(sample);
    flight.motion.emplace_back();
  }
  const std::vector<Vector3> force = swinging_force(flight, {0.4, 0.0, 0.0}, {.cable_W = {0.95, 0.0}});
  const auto strongest = [&](std::size_t first) {
    double most = 0.0;
    for (std::size_t k = first; k < first + 300; ++k) most = std::max(most, force[k].norm());
    return most;
  };
  // m g (3 - 2 cos) at the bottom, per kg
  EXPECT_NEAR(strongest(0), 9.80665 * (3.0 - 2.0 * std::sqrt(1.0 - 0.95 * 0.95)), 0.3);
  EXPECT_NEAR(strongest(5700), strongest(0), 0.1);
}

}  // namespace history_test
}  // namespace gustlab::diagnosis
