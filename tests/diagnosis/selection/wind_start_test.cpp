// Winds that begin where a force of every flight beside a drag left off.
#include "diagnosis/selection/wind_start.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "support/trials.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace wind_start_test {

using ::testing::Contains;
using ::testing::ElementsAre;

class WindStart : public ::testing::Test {
 protected:
  const Catalogue catalogue{
      test::crazyflie(), 2, {.observable = Need::attitude | Need::motion | Need::torque | Need::accelerometer}};
  const int force = catalogue.find("constant_force"), wind = catalogue.find("steady_wind"),
            linear = catalogue.find("rotor_drag"), quadratic = catalogue.find("quadratic_drag");
  const std::vector<int>& columns(int group) const { return catalogue.group(group).columns; }
  // a drag of 0.02 N s/m, and 0.04 N toward x in the first flight, 0.01 N toward y in the second
  Eigen::VectorXd fitted() const {
    Eigen::VectorXd value = catalogue.nominal();
    value[columns(linear).front()] = 0.02;
    for (const int c : columns(force)) {
      const Column& column = catalogue.column(c);
      if (column.flight == 0 && column.name == "x") value[c] = 0.04;
      if (column.flight == 1 && column.name == "y") value[c] = 0.01;
    }
    return value;
  }
  double wind_of(const Eigen::VectorXd& value, int flight, const std::string& axis) const {
    for (const int c : columns(wind))
      if (const Column& column = catalogue.column(c); column.flight == flight && column.name == axis) return value[c];
    return std::numeric_limits<double>::quiet_NaN();
  }
};

TEST_F(WindStart, StandsInForTheForceOfTheCatalogue) { EXPECT_EQ(force_like_wind(catalogue), force); }

TEST_F(WindStart, DoesWhatForceAndDragDid) {
  const std::vector<StartedSet> sets = winds_instead(catalogue, {linear, force}, fitted());
  ASSERT_EQ(sets.size(), 2u);  // one for each drag

  EXPECT_THAT(sets[0].groups, ElementsAre(linear, wind));
  EXPECT_NEAR(wind_of(sets[0].value, 0, "x"), 0.04 / 0.02, 1e-12);
  EXPECT_NEAR(wind_of(sets[0].value, 1, "y"), 0.01 / 0.02, 1e-12);
  for (const int c : columns(force)) EXPECT_EQ(sets[0].value[c], 0.0);

  EXPECT_THAT(sets[1].groups, ElementsAre(quadratic, wind));
  EXPECT_EQ(sets[1].value[columns(linear).front()], catalogue.nominal()[columns(linear).front()]);
  const double area_m2 = sets[1].value[columns(quadratic).front()], first_mps = wind_of(sets[1].value, 0, "x"),
               second_mps = wind_of(sets[1].value, 1, "y");
  EXPECT_NEAR(first_mps, 4.0, 1e-12);
  EXPECT_NEAR(second_mps, 1.0, 1e-12);
  // damping of motion along the mean wind
  EXPECT_NEAR(air_density_kgpm3 * area_m2 * 0.5 * (first_mps + second_mps), 0.02, 1e-12);
}

TEST_F(WindStart, NeedsADragThatDamps) {
  Eigen::VectorXd value = fitted();
  value[columns(linear).front()] = 0.0;
  EXPECT_TRUE(winds_instead(catalogue, {linear, force}, value).empty());
}

TEST(WindTrials, AreNotForcesOfEveryFlight) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"lemniscate", "multisine"};
  trial.holdout = {"circle"};
  trial.concealed = R"({type = "quadratic_drag", area_xy = 0.006, area_z = 0.006}, {type = "steady_wind", x = 4.0})";
  const Diagnosis d = diagnose(test::fly_trial(folder, trial));
  std::vector<std::string> names;
  for (const EffectFinding& effect : d.effects) {
    names.push_back(effect.effect);
    const double value = effect.parameters.front().value, wanted = effect.effect == "steady_wind" ? 4.0 : 0.006;
    EXPECT_NEAR(value, wanted, 0.4 * wanted) << effect.effect;
  }
  EXPECT_THAT(names, ElementsAre("quadratic_drag", "steady_wind")) << to_json(d).dump(1);
}

// 60 ms are as long as the commands' swings: linearised about such a lag, the model says next to nothing of flights without one
TEST(LatencyTrials, KnowWhatFlightsWithoutALongLagWouldBe) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"lemniscate", "multisine"};
  trial.holdout = {"circle"};
  trial.concealed = R"({type = "motor_lag", time_constant = 0.08})";
  const Diagnosis d = diagnose(test::fly_trial(folder, trial));
  ASSERT_THAT(d.effects, Contains(::testing::Field(&EffectFinding::effect, "motor_lag"))) << to_json(d).dump(1);
  for (const Evidence& record : d.evidence)
    if (record.effect == "motor_lag") {
      EXPECT_GT(record.delta_chi2, 2.0 * record.delta_chi2_alone);  // alone: by the linear model
    }
}

}  // namespace wind_start_test
}  // namespace gustlab::diagnosis
