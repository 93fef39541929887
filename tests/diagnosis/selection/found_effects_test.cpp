// What a selection found, as numbers: against means and errors by hand.
#include "diagnosis/selection/found_effects.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace found_effects_test {

class FoundEffects : public ::testing::Test {
 protected:
  FoundEffects() {
    selection.value = catalogue.nominal();
    selection.deviation = Eigen::VectorXd::Zero(catalogue.size());
  }
  const Group& group(const std::string& label) const { return catalogue.group(catalogue.find(label)); }
  void found(const std::string& label) { selection.findings.emplace_back().group = catalogue.find(label); }

  Catalogue catalogue{test::crazyflie(), 2, {.observable = Need::attitude | Need::motion | Need::torque}};
  Selection selection;
};

// a standard error, and beside it a share of what the model's own form may be off by
double error(double deviation, double change) { return std::hypot(deviation, decisions::model_form * change); }

TEST_F(FoundEffects, OfEveryFlightsOwnValuesTheMeanCounts) {
  for (const int c : group("constant_force").columns) {
    const Column& column = catalogue.column(c);
    if (column.name != "x") continue;
    selection.value[c] = column.flight == 0 ? 0.04 : 0.02;
    selection.deviation[c] = column.flight == 0 ? 0.003 : 0.001;
  }
  const auto x_of = [&](int flight) { return values_of(catalogue, selection, group("constant_force"), flight)[0]; };
  EXPECT_EQ(x_of(-1).name, "x");
  EXPECT_EQ(x_of(-1).unit, "N");
  EXPECT_NEAR(x_of(-1).value, 0.03, 1e-15);
  EXPECT_NEAR(x_of(-1).deviation, 0.5 * std::hypot(error(0.003, 0.04), error(0.001, 0.02)), 1e-15);
  EXPECT_NEAR(x_of(1).value, 0.02, 1e-15);
  EXPECT_NEAR(x_of(1).deviation, error(0.001, 0.02), 1e-15);
  EXPECT_EQ(values_of(catalogue, selection, group("constant_force"), -1).size(), 3u);
}

// a crazyflie's file has a lag of 12.5 ms: only what was added may be of the wrong form
TEST_F(FoundEffects, TheErrorOfTheFormIsOfTheChange) {
  const int c = group("motor_lag").columns.front();
  selection.value[c] = 0.0225, selection.deviation[c] = 0.0002;
  EXPECT_NEAR(values_of(catalogue, selection, group("motor_lag"), -1)[0].deviation, error(0.0002, 0.01), 1e-12);
}

TEST_F(FoundEffects, HistoriesSayWhatTheirScanFound) {
  catalogue.set_swing({0.4, 0.02, 0.003});
  catalogue.set_speed_limit(2100.0);
  const auto load = values_of(catalogue, selection, group("slung_load"), -1);
  ASSERT_EQ(load.size(), 2u);
  EXPECT_EQ(load[0].name, "length");
  EXPECT_EQ(load[0].value, 0.4);
  EXPECT_NEAR(load[0].deviation, std::hypot(0.003, decisions::cable_form * 0.4), 1e-15);
  EXPECT_EQ(load[1].name, "mass");
  const auto limit = values_of(catalogue, selection, group("saturation"), -1);
  ASSERT_EQ(limit.size(), 1u);
  EXPECT_EQ(limit[0].value, 2100.0);
}

TEST_F(FoundEffects, FlyInTheOrderOfTheFindingsWithTheirRotor) {
  found("rotor_loss#3");
  found("mass");
  selection.value[group("rotor_loss#3").columns.front()] = 0.125;
  selection.value[group("mass").columns.front()] = 0.0123456789012345;
  const std::vector<EffectSpec> effects = effects_found(catalogue, selection);
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effects[0].type, "rotor_loss");
  EXPECT_THAT(effects[0].values, ::testing::ElementsAre(std::pair<std::string, std::string>("rotor", "3"),
                                                        std::pair<std::string, std::string>("loss", "0.125")));
  EXPECT_EQ(effects[1].type, "mass");
  EXPECT_EQ(std::stod(effects[1].values[0].second), 0.0123456789012345);  // to the last bit
}

}  // namespace found_effects_test
}  // namespace gustlab::diagnosis
