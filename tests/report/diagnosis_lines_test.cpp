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

// a candidate removed 66 % of the error and was 1 % likely, and nothing said why
TEST(DiagnosisLines, SayWhatSpeaksAgainstASuspectAndAgainstWhatRemovesMuchOfTheError) {
  diagnosis::Diagnosis d;
  d.vehicle = "quad";
  d.verdict = diagnosis::Verdict::unexplained;
  d.suspected = {finding("inertia", 0.62, {"inertia"})};
  const auto record = [](const char* name, double probability, double removed) {
    diagnosis::Evidence e;
    e.effect = name, e.probability = probability;
    e.recovered = {0.0, removed, 0.0}, e.recovered_z = {1.0, 9.0, 1.0};
    e.weak_points = {"it does not help on the held-out flights", "its size differs between flights"};
    return e;
  };
  d.evidence = {record("inertia", 0.62, 0.1), record("constant_force", 0.01, 0.66), record("mass", 0.01, 0.1)};
  EXPECT_EQ(diagnosis_lines(d),
            "quad: unexplained\n"
            "  only suspected: inertia (confidence 0.62)\n"
            "    what speaks against it: it does not help on the held-out flights; its size differs between flights\n"
            "  not named: constant_force, though it removes 66 % of the error 0.5 s ahead (confidence 0.01)\n"
            "    what speaks against it: it does not help on the held-out flights; its size differs between flights\n");
  // what looks like a name stands with that name
  d.effects = {finding("rotor_tilt", 0.9, {"rotor_tilt", "constant_force"})};
  EXPECT_EQ(diagnosis_lines(d).find("not named"), std::string::npos);
}

TEST(DiagnosisLines, OfNothingAreTheVerdict) {
  diagnosis::Diagnosis d;
  d.vehicle = "quad";
  d.verdict = diagnosis::Verdict::consistent;
  EXPECT_EQ(diagnosis_lines(d), "quad: consistent\n");
}

}  // namespace diagnosis_lines_test
}  // namespace gustlab
