// The judge: a probability from a record, monotone in all that speaks for a name.
#include "diagnosis/evidence/judge.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <string_view>

#include "diagnosis/evidence/gather_evidence.hpp"

namespace gustlab::diagnosis {
namespace judge_test {

Evidence strong() {
  Evidence e;
  e.delta_chi2 = 2000.0;
  e.held_out_delta_chi2 = 600.0, e.held_out_expected = 650.0;
  e.surrogates = {1.1, 0.005, true};
  e.clustered_inflation = 1.3;
  e.flights = {{"a", false, 1.0, 0.05}, {"b", false, 1.1, 0.05}, {"held out", true, 0.95, 0.05}};
  e.spread_flights = 0.05, e.spread_regimes = 0.1;
  e.size_in_tolerances = 5.0, e.inclusion = 1.0;
  e.horizon_s = {0.1, 0.5, 1.0}, e.recovered = {0.2, 0.3, 0.3}, e.recovered_z = {5.0, 8.0, 8.0};
  return e;
}

double probability(Evidence e) {
  judge(e);
  return e.probability;
}

TEST(Judge, NamesWhatEverythingSpeaksFor) { EXPECT_GT(probability(strong()), named_from); }

TEST(Judge, BearsALargerMomentWhereThePredictionsBecomeSurelyBetter) {
  Evidence e = strong();
  e.force_excess = -0.9, e.force_excess_sd = 0.1, e.part_lacking = 0.0;
  EXPECT_GT(probability(e), named_from);
  e.recovered_z = {};
  EXPECT_LT(probability(e), named_from);
}

TEST(Judge, RejectsAnEmptyRecord) { EXPECT_LT(probability(Evidence{}), suspected_from); }

TEST(Judge, AllThatSpeaksAgainstLowersTheProbability) {
  const std::vector<std::function<void(Evidence&)>> worse = {
      [](Evidence& e) { e.delta_chi2 = 30.0; },
      [](Evidence& e) { e.delta_chi2_with_partner = 30.0; },
      [](Evidence& e) { e.delta_chi2_alone = 5.0; },
      [](Evidence& e) { e.surrogates.inflation = 60.0; },
      [](Evidence& e) { e.surrogates.p_value = 0.5; },
      [](Evidence& e) { e.clustered_inflation = 80.0; },
      [](Evidence& e) {
        e.flights[1] = {"b", false, -0.2, 0.1};
      },
      [](Evidence& e) { e.spread_flights = 0.8; },
      [](Evidence& e) { e.spread_regimes = 0.9; },
      [](Evidence& e) { e.slow_fast = 0.6; },
      [](Evidence& e) { e.held_out_delta_chi2 = -300.0; },
      [](Evidence& e) {
        e.recovered = {-0.2, -0.3, -0.3}, e.recovered_z = {-3.0, -3.0, -3.0};
      },
      [](Evidence& e) { e.size_in_tolerances = 1.3; },
      [](Evidence& e) { e.inclusion = 0.2; },
      [](Evidence& e) { e.unpredicted_commands = 5000.0; },
      [](Evidence& e) { e.part_lacking = 0.9, e.force_excess_sd = 0.1; },
      [](Evidence& e) { e.sensors_share = 0.0; },
      [](Evidence& e) { e.at_bound = true; },
      [](Evidence& e) { e.alike = 1; },
      [](Evidence& e) { e.lone_latency = true; },
      [](Evidence& e) { e.slow_speeds_delta_chi2 = 4.0; },
      [](Evidence& e) { e.between_rows_delta_chi2 = -6.0; },
      [](Evidence& e) { e.undone = 0.8; },
      [](Evidence& e) { e.outweighed = 1.3; },
      [](Evidence& e) { e.dwarfed_by = 5000.0; },
      [](Evidence& e) { e.force_over_tilt = 0.5; }};
  for (std::size_t i = 0; i < worse.size(); ++i) {
    Evidence e = strong();
    worse[i](e);
    EXPECT_LT(probability(e), probability(strong())) << "change " << i;
  }
}

TEST(Judge, NumbersOfTheVehicleAndForcesOfEveryFlightKeepTheirSizeMoreThanALawOfThrustAndThatMoreThanOthers) {
  const std::map<std::string_view, double> expected = {{"mass", decisions::constant_differs},
                                                       {"motor_lag", decisions::constant_differs},
                                                       {"actuation_delay", decisions::constant_differs},
                                                       {"constant_force", decisions::constant_differs},
                                                       {"thrust_curve", decisions::law_differs},
                                                       {"battery_sag", decisions::law_differs},
                                                       {"thrust_scale", decisions::other_differs},
                                                       {"rotor_drag", decisions::other_differs},
                                                       {"center_of_mass", decisions::airframe_differs},
                                                       {"rotor_tilt", decisions::other_differs},
                                                       {"rotor_loss", decisions::airframe_differs},
                                                       {"inertia", decisions::airframe_differs},
                                                       {"axial_inflow", decisions::other_differs}};
  for (const auto& [name, share] : expected) EXPECT_EQ(may_differ(*find_effect(name)), share) << name;
}

// a tether pulls harder the higher the vehicle is, and is neither a constant force nor a mass
TEST(Judge, WhatNothingInFlightChangesIsTheSameAllAlongIt) {
  Evidence e = strong();
  e.may_differ = decisions::constant_differs;
  const double even = probability(e);
  e.uneven = 0.1;
  EXPECT_EQ(probability(e), even);
  e.uneven = 0.25;
  const double doubted = probability(e);
  EXPECT_LT(doubted, even);
  // of other effects it is no sure sign, but where little of them is the same
  e.may_differ = decisions::other_differs;
  EXPECT_EQ(probability(e), even);
  e.uneven = 1.6;
  EXPECT_EQ(probability(e), doubted);
}

// a centre of mass is known no better than torque trims let it be, and predicts other flights far better
TEST(Judge, WhatPredictsOtherFlightsFarBetterIsLikelier) {
  const auto with = [](double share, double z, double uneven = 0.0, bool per_flight = false) {
    Evidence e = strong();
    e.recovered = {0.0, share, 0.0}, e.recovered_z = {0.0, z, 0.0}, e.uneven = uneven, e.per_flight = per_flight;
    return probability(e);
  };
  EXPECT_LT(with(0.2, 20.0), with(0.5, 20.0));
  EXPECT_EQ(with(0.2, 20.0), with(0.0, 20.0));
  EXPECT_EQ(with(0.7, 4.0), with(0.2, 4.0));
  // what is true of some parts of a flight only may be something else
  EXPECT_EQ(with(0.7, 20.0, 0.1), with(0.2, 20.0, 0.1));
  // its values were fitted to those flights, too
  EXPECT_EQ(with(0.7, 20.0, 0.0, true), with(0.2, 20.0, 0.0, true));
}

// held-out flights that hardly excite an effect do not refute it
TEST(Judge, HeldOutFlightsSpeakOnlyOfWhatTheyExcite) {
  const auto with = [](double expected, double delta_chi2) {
    Evidence e = strong();
    e.held_out_expected = expected, e.held_out_delta_chi2 = delta_chi2;
    return probability(e);
  };
  EXPECT_EQ(with(9.0, -9.0), with(9.0, 9.0));
  EXPECT_LT(with(11.0, -11.0), with(11.0, 11.0));
}

// no model predicts to a hundredth: what rollouts lose by less is none, however surely it is seen
TEST(Judge, ALossOfLessThanAHundredthIsNone) {
  Evidence e = strong();
  e.recovered_z = {0.0, -3.0, 0.0};
  e.recovered = {0.0, -0.007, 0.0};
  const double lost_a_little = probability(e);
  e.recovered[1] = -0.02;
  EXPECT_LT(probability(e), lost_a_little);
  e.recovered[1] = e.recovered_z[1] = 0.0;
  EXPECT_EQ(probability(e), lost_a_little);
}

TEST(Judge, NumbersThatCannotBeSaidDoNotDecide) {
  Evidence e = strong();
  e.size_in_tolerances = std::numeric_limits<double>::infinity();
  e.recovered_z = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(), 0.0};
  EXPECT_GE(probability(e), 0.0);
  EXPECT_LE(probability(e), 1.0);
}

// a late pose stands or falls with gyro and attitudes, whatever the forces are
TEST(Judge, ALatePoseThatTheSensorsRefuteIsNotNamed) {
  Evidence e = strong();
  e.sensors_share = 0.0;
  EXPECT_LT(probability(e), named_from);
}

TEST(Judge, AValueAtItsBoundIsNotNamed) {
  Evidence e = strong();
  e.at_bound = true;
  EXPECT_LT(probability(e), named_from);
}

// effects that undo each other gain much one by one, and little together
TEST(Judge, WhatGainsNothingWithoutItsPartnerIsNotNamed) {
  Evidence e = strong();
  e.delta_chi2_with_partner = 12.0;
  EXPECT_LT(probability(e), named_from);
}

// an error of a hundredth of a large effect's form is one part in ten thousand of its square
TEST(Judge, WhatAnErrorOfALargerNameMayLeaveIsNotNamed) {
  Evidence e = strong();
  e.dwarfed_by = 8000.0;
  EXPECT_LT(probability(e), suspected_from);
  judge(e);
  EXPECT_GT(probability_without_others(e), named_from);
  e.dwarfed_by = 1000.0;
  EXPECT_EQ(probability(e), probability(strong()));
}

TEST(Evidence, CountsFlightsForAndAgainst) {
  Evidence e;
  e.flights = {{"a", false, 1.0, 0.1}, {"b", false, 0.6, 0.5}, {"c", false, 0.0, 0.3}, {"d", false, 0.1, 0.6}};
  EXPECT_EQ(e.flights_for(), 1);
  EXPECT_EQ(e.flights_against(), 1);
}

}  // namespace judge_test
}  // namespace gustlab::diagnosis
