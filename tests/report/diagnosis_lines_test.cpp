// What `gustlab diagnose` prints: a name is not more certain on a terminal than on the page.
#include <gtest/gtest.h>

#include "report/diagnosis_lines.hpp"

namespace gustlab {
namespace diagnosis_lines_test {

diagnosis::EffectFinding finding(const char* name, double confidence, std::vector<std::string> alike) {
  diagnosis::EffectFinding effect;
  effect.effect = name;
  effect.confidence = confidence;
  effect.classmates = std::move(alike);
  return effect;
}

TEST(DiagnosisLines, SayWhichNamesWouldDoAsWell) {
  diagnosis::Diagnosis d;
  d.vehicle = "quad";
  d.verdict = diagnosis::Verdict::partly_explained;
  d.effects = {finding("mass", 0.951, {"mass", "thrust_scale"}), finding("rotor_drag", 0.9, {"rotor_drag"}),
               finding("rotor_tilt", 0.9, {"rotor_tilt", "constant_force", "attitude_offset"})};
  d.effects[0].parameters = {{"delta", "-", 0.08204, 0.01}};
  d.effects[1].parameters = {{"at_hover", "N s/m", 0.3, 0.01}};
  d.effects.push_back(finding("steady_wind", 0.9, {"steady_wind"}));
  d.effects.back().parameters = {{"x", "m/s", -10.6, 0.5}};
  d.effects.back().per_flight = {{"a.csv", {}}, {"b.csv", {}}};
  d.suspected = {finding("inertia", 0.62, {"inertia"})};
  EXPECT_EQ(diagnosis_lines(d),
            "quad: partly_explained\n"
            "  mass delta = 0.08204 (confidence 0.95)\n"
            "    or thrust_scale: these flights cannot tell the two apart\n"
            "  rotor_drag at_hover = 0.3 N s/m (confidence 0.90)\n"
            "  rotor_tilt (confidence 0.90)\n"
            "    or constant_force or attitude_offset: these flights cannot tell them apart\n"
            "  steady_wind x = -10.6 m/s (means of 2 flights, confidence 0.90)\n"
            "  only suspected: inertia (confidence 0.62)\n");
}

TEST(DiagnosisLines, OfNothingAreTheVerdict) {
  diagnosis::Diagnosis d;
  d.vehicle = "quad";
  d.verdict = diagnosis::Verdict::consistent;
  EXPECT_EQ(diagnosis_lines(d), "quad: consistent\n");
}

}  // namespace diagnosis_lines_test
}  // namespace gustlab
