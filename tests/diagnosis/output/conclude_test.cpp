#include "diagnosis/output/conclude.hpp"

#include <gtest/gtest.h>

namespace gustlab::diagnosis {
namespace conclude_test {

Remainder left(const std::string& kind, double share) {
  Remainder rest;
  rest.alarms.push_back({kind, "something is left", 0.0, {}});
  rest.omnibus_share = share;
  return rest;
}

Verdict verdict(const Diagnosis& out, const Remainder& rest) { return conclude(out, rest, false, false); }

TEST(Conclude, WhatIsLeftBesideNamesMustBeSmall) {
  Diagnosis out;
  EXPECT_EQ(verdict(out, {}), Verdict::consistent);
  EXPECT_EQ(conclude(out, {}, true, false), Verdict::unexplained);
  EXPECT_EQ(conclude(out, {}, false, true), Verdict::insufficient_data);
  EXPECT_EQ(verdict(out, left("omnibus", 0.05)), Verdict::unexplained);
  out.effects.emplace_back();
  EXPECT_EQ(verdict(out, left("omnibus", 0.05)), Verdict::explained);
  EXPECT_EQ(verdict(out, left("omnibus", 0.2)), Verdict::partly_explained);
  EXPECT_EQ(verdict(out, left("floor", 0.05)), Verdict::partly_explained);
}

// an hour of flight showed a mass 0.3 % off, which is not reported, and a pattern of a fifteenth of that: "unexplained"
TEST(Conclude, WhatIsLessThanACalibrationIsNotUnexplained) {
  Diagnosis out;
  out.calibration.emplace_back();
  EXPECT_EQ(verdict(out, left("omnibus", 0.07)), Verdict::consistent);
  EXPECT_EQ(verdict(out, left("omnibus", 0.2)), Verdict::unexplained);
  EXPECT_EQ(verdict(out, left("floor", 0.07)), Verdict::unexplained);
  EXPECT_EQ(conclude(out, left("omnibus", 0.07), true, false), Verdict::unexplained);
  out.suspected.emplace_back();
  EXPECT_EQ(verdict(out, left("omnibus", 0.07)), Verdict::unexplained);
}

}  // namespace conclude_test
}  // namespace gustlab::diagnosis
