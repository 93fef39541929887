// What findings say in diagnosis.json (FORMATS.md §4), and how evidence is counted, against numbers that were worked out by hand.
#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/result/evidence.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {
namespace to_json_test {

using nlohmann::ordered_json;

TEST(ToJson, SaysEveryFindingUnderItsKey) {
  Diagnosis d;
  d.verdict = Verdict::partly_explained;
  d.vehicle = "v";
  d.mismatch = {{"force_x", true, 1e-9, 0.01, 0.001, "N", {{"airspeed_mps", 0.6, 0.82}}, {"a_lag"}}};
  EffectFinding& drag = d.effects.emplace_back();
  drag.effect = "rotor_drag";
  drag.confidence = 0.98;
  drag.parameters = {{"at_hover", "N s/m", 0.0147, 0.0004}};
  drag.classmates = {"rotor_drag"};
  drag.confusable = {{"quadratic_drag", false, 9.1, 41.0}};
  d.log_findings = {{"a.csv", "vbat", "frozen", 1.0, 2.0, "it never changes"}};
  d.rejected = {{"steady_wind", -3.1, "no gain"}};
  d.not_identifiable = {{"ground_effect", "too high"}, {"slung_load", "still", Lack::excitation, "swings"}};
  d.alarms = {{"omnibus", "something is left", NAN, {"force_x"}}};
  d.disturbance = {{"force_xy", 0.31, 0.06, "m/s^2", 0.15}};
  const ordered_json json = to_json(d);
  const auto expect = [&](const char* key, const char* text) {
    const ordered_json wanted = ordered_json::parse(text);
    for (const auto& [name, value] : wanted.items()) EXPECT_EQ(json[key][0][name], value) << key << " " << name;
  };
  EXPECT_EQ(json["verdict"], "partly_explained");
  expect("mismatch",
         R"({"channel": "force_x", "significant": true, "p_value": 1e-9, "rms": 0.01, "noise_rms": 0.001, "unit": "N",
                         "where": [{"variable": "airspeed_mps", "above": 0.6, "share": 0.82}], "effects": ["a_lag"]})");
  expect("effects", R"({"effect": "rotor_drag", "confidence": 0.98, "class": ["rotor_drag"],
                        "parameters": {"at_hover": {"value": 0.0147, "std": 0.0004, "unit": "N s/m"}},
                        "confusable_with": [{"effect": "quadratic_drag", "equivalent": false, "z": 9.1, "delta_score": 41.0}]})");
  expect("log_findings", R"({"file": "a.csv", "column": "vbat", "kind": "frozen", "from_s": 1.0, "to_s": 2.0,
                             "says": "it never changes"})");
  expect("rejected", R"({"effect": "steady_wind", "delta_score": -3.1, "why": "no gain"})");
  expect("not_identifiable", R"({"effect": "ground_effect", "why": "too high"})");
  EXPECT_EQ(
      json["not_identifiable"][1],
      ordered_json::parse(R"({"effect": "slung_load", "why": "still", "lack": "excitation", "shows_in": "swings"})"));
  for (int k = 0; k <= static_cast<int>(Lack::excitation); ++k)
    EXPECT_EQ(lack_named(to_string(static_cast<Lack>(k))), static_cast<Lack>(k));
  EXPECT_EQ(lack_named("nothing of the kind"), Lack::other);
  // what is no number has none
  expect("alarms", R"({"kind": "omnibus", "says": "something is left", "size": null, "channels": ["force_x"]})");
  expect("disturbance",
         R"({"group": "force_xy", "before": 0.31, "after": 0.06, "unit": "m/s^2", "correlation_time_s": 0.15})");
}

TEST(Evidence, CountsFlightsByShareAndError) {
  Evidence e;
  const std::pair<double, double> share_and_error[] = {{0.9, 0.2},   // for
                                                       {0.9, 0.5},   // its error is too large
                                                       {0.4, 0.1},   // neither
                                                       {0.1, 0.3},   // against
                                                       {0.1, 0.5}};  // its error reaches the whole size
  for (const auto& [share, error] : share_and_error) e.flights.push_back({"a.csv", false, share, error});
  EXPECT_EQ(e.flights_for(), 1);
  EXPECT_EQ(e.flights_against(), 1);
}

TEST(Evidence, ItsGainIsCountedInUnitsOfTheLargerInflation) {
  Evidence e;
  e.delta_chi2 = 120.0;
  EXPECT_EQ(e.robust_delta_chi2(), 120.0);
  e.delta_chi2_with_partner = 90.0;
  EXPECT_EQ(e.robust_delta_chi2(), 90.0);
  e.surrogates.inflation = 3.0;
  e.clustered_inflation = 2.0;
  EXPECT_EQ(e.robust_delta_chi2(), 30.0);
  e.surrogates.movable = false;
  EXPECT_EQ(e.robust_delta_chi2(), 45.0);
}

}  // namespace to_json_test
}  // namespace gustlab::diagnosis
