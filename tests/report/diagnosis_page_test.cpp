#include "report/diagnosis_page.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "report/diagnosis_example.hpp"
#include "report/diagnosis_words.hpp"
#include "report/svg.hpp"

namespace gustlab {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

// the first tag that closes nothing, or is never closed; empty when all is well
std::string unbalanced(const std::string& html) {
  const std::vector<std::string> empty_tags{"meta", "line", "rect", "circle", "path"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return html.substr(at, 40);
    std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.starts_with("!")) continue;
    const bool closes = tag.starts_with("/");
    const std::string name = tag.substr(closes, tag.find_first_of(" /\n", closes) - closes);
    if (tag.ends_with("/") || std::count(empty_tags.begin(), empty_tags.end(), name)) continue;
    if (!closes) {
      open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name) return tag;
    open.pop_back();
  }
  return open.empty() ? "" : open.back();
}

void expect_sound(const std::string& html) {
  EXPECT_EQ(unbalanced(html), "");
  for (const char* wrong : {"nan", "NaN", "inf", "null", "http:", "https:", "<script", "src=", "@import", "url("})
    EXPECT_THAT(html.substr(html.find("<main>")), Not(HasSubstr(wrong)));
  EXPECT_THAT(html.substr(0, html.find("<main>")), Not(HasSubstr("http")));
}

TEST(DiagnosisPage, IsSelfContainedAndWellFormed) {
  const std::string html = diagnosis_page(example_diagnosis(), example_figures());
  EXPECT_THAT(html, testing::StartsWith("<!doctype html>"));
  expect_sound(html);
  EXPECT_EQ(html, diagnosis_page(example_diagnosis(), example_figures()));
}

TEST(DiagnosisPage, SaysWhatItHasInTheOrderThatIsAskedFor) {
  const std::string html = diagnosis_page(example_diagnosis(), example_figures());
  std::size_t at = 0;
  for (const char* wanted : {"<h1>The simulation of crazyflie",
                             "First, about the recordings",
                             "Where it differs",
                             "airspeed above 0.6 m/s (82 % of it)",
                             "What was left out",
                             "0.01470 ± 0.00078",
                             "N s/m",
                             "Mass or thrust scale",
                             "Loss of rotor 3",
                             "Still not explained",
                             "repeat after 0.05 s",
                             "How much better it predicts",
                             "over 412 windows of lemniscate.csv",
                             "Left out: 3 windows across gaps",
                             "N = 150 blocks, left out: 12 blocks with saturated commands",
                             "One held-out window",
                             "400 samples",
                             "What cannot be told",
                             "no sample below 0.3 m",
                             "What to fly next",
                             "Thrust sweep",
                             "Unexplained disturbance",
                             "Calibration",
                             "0.041 ± 0.012",
                             "Flights"}) {
    const std::size_t found = html.find(wanted, at);
    ASSERT_NE(found, std::string::npos) << wanted;
    at = found;
  }
}

TEST(DiagnosisPage, EscapesEveryText) {
  Json diagnosis = example_diagnosis();
  const std::string attack = "<b>\"'&</b>";
  diagnosis["vehicle"] = attack;
  for (const char* list : {"effects", "log_findings_in_short", "rejected", "not_identifiable", "flights", "alarms",
                           "mismatch", "disturbance"})
    for (Json& entry : diagnosis[list])
      for (auto& [key, value] : entry.items())
        if (value.is_string() && key != "role") value = attack;
  DiagnosisFigures figures = example_figures();
  figures.window.file = figures.windows_left_out = attack;
  figures.residuals[0].left_out = figures.residuals[0].channel = figures.residuals[0].variable = attack;
  figures.window.traces[0].name = figures.window.traces[0].unit = attack;
  const std::string html = diagnosis_page(diagnosis, figures);
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;&quot;&#39;&amp;&lt;/b&gt;"));
  expect_sound(html);
}

TEST(DiagnosisPage, WhatIsMissingIsLeftOut) {
  for (const char* verdict : {"consistent", "insufficient_data", "unexplained", "explained", "partly_explained"}) {
    const std::string html = diagnosis_page({{"verdict", verdict}, {"augmented_model", "augmented.toml"}}, {});
    expect_sound(html);
    for (const char* absent : {"<figure>", "<table>", "First, about", "What to fly next", "Fly the improved model"})
      EXPECT_THAT(html, Not(HasSubstr(absent)));
  }
}

TEST(DiagnosisPage, NumbersThatAreNotKnownAreADash) {
  Json diagnosis = example_diagnosis();
  diagnosis["effects"][0]["confidence"] = nullptr;
  diagnosis["effects"][0]["parameters"]["at_hover"]["std"] = nullptr;
  diagnosis["mismatch"][0]["noise_rms"] = 0.0;
  diagnosis["mismatch"][1]["rms"] = nullptr;
  DiagnosisFigures figures = example_figures();
  figures.residuals[0].after_mean.assign(8, std::numeric_limits<double>::infinity());
  const std::string html = diagnosis_page(diagnosis, figures);
  expect_sound(html);
  EXPECT_THAT(html, HasSubstr("– sure"));
}

TEST(DiagnosisPage, AnUnnamedModelIsShownAsSuch) {
  Json diagnosis = example_diagnosis();
  diagnosis["verdict"] = "unexplained";
  diagnosis["effects"] = Json::array();
  diagnosis["residual_model"] = {
      {"terms", {{{"channel", "force_x"}, {"term", "vx |v|"}, {"coefficient", -0.012}, {"unit", "N s²/m²"}}}}};
  const std::string html = diagnosis_page(diagnosis, {});
  expect_sound(html);
  EXPECT_THAT(html, HasSubstr("An unnamed effect"));
  EXPECT_THAT(html, HasSubstr("<code>vx |v|</code></td><td class=\"n\">−0.0120</td>"));
}

TEST(DiagnosisPage, SaysOnceWhatSeveralRecordingsHave) {
  Json diagnosis = example_diagnosis();
  diagnosis["log_findings_in_short"] = {{{"kind", "filtered"}, {"says", "2 of 3 flights: px…wz it was smoothed"}}};
  EXPECT_THAT(diagnosis_page(diagnosis, {}),
              HasSubstr("<ul><li><strong>Filtered</strong>: 2 of 3 flights: px…wz it was smoothed.</li></ul>"));
}

TEST(DiagnosisPage, ShowsSuspectsWithTheReasonWhyTheyHaveNoName) {
  Json diagnosis = example_diagnosis();
  EXPECT_THAT(diagnosis_page(diagnosis, {}), Not(HasSubstr("Suspected")));
  diagnosis["effects"] = Json::array();
  diagnosis["rejected"] = {{{"effect", "motor_lag"}, {"why", "only suspected: half of it remains"}},
                           {{"effect", "mass"}, {"why", "only suspected: half of it remains"}}};
  EXPECT_THAT(diagnosis_page(diagnosis, {}),
              HasSubstr("<p>Suspected, and not named because half of it remains: motor lag and mass.</p>"));
}

TEST(OneSentence, FitsTheVerdict) {
  Json diagnosis = example_diagnosis();
  EXPECT_EQ(
      report::one_sentence(diagnosis),
      "The simulation of crazyflie leaves out rotor drag, loss of rotor 3 and steady wind and has the wrong mass (or "
      "thrust scale), and the recording itself has pose delay; the position predicted 0.5 s ahead is then wrong by 7.4 "
      "mm instead of "
      "3.1 cm, on flights that were not used to find it.");
  while (diagnosis["effects"].size() > 1) diagnosis["effects"].erase(1);
  diagnosis["verdict"] = "partly_explained";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "The simulation of crazyflie leaves out rotor drag (lateral force against the motion, proportional to "
            "rotor speed); the "
            "position predicted 0.5 s ahead is then wrong by 7.4 mm instead of 3.1 cm, on flights that were not used "
            "to find it; "
            "something else remains.");
  diagnosis["effects"].clear();
  diagnosis["verdict"] = "unexplained";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "Something acts on crazyflie that the simulation leaves out (mostly in the push forward or back, when "
            "airspeed is above "
            "0.6 m/s), and no effect known here explains enough of it to be named.");
  diagnosis["residual_model"] = {{"terms", Json::array()}};
  EXPECT_THAT(report::one_sentence(diagnosis),
              HasSubstr("to be named; with a model that has no name, the position predicted 0.5 s ahead is"));
  diagnosis["verdict"] = "consistent";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "The simulation of crazyflie agrees with these flights: nothing is left beyond noise and calm air.");
}

// measured rotor speeds drive the body: a lag that they show changes none of its predictions
TEST(OneSentence, ClaimsNoGainThatItsDigitsDoNotShow) {
  Json diagnosis = example_diagnosis();
  ASSERT_THAT(report::one_sentence(diagnosis), HasSubstr("instead of"));
  diagnosis["fit"]["position_m"]["before"] = diagnosis["fit"]["position_m"]["after"];
  EXPECT_THAT(report::one_sentence(diagnosis), Not(HasSubstr("instead of")));
}

TEST(Words, NumbersHaveTheDigitsTheyDeserve) {
  EXPECT_EQ(report::with_half_width(14.71, 0.78), "14.71 ± 0.78");
  EXPECT_EQ(report::with_half_width(-3.2e-8, 4e-10), "(−3.200 ± 0.040) × 10⁻⁸");
  EXPECT_EQ(report::with_half_width(1234.0, 56.0), "1234 ± 56");
  EXPECT_EQ(report::with_half_width(-0.0001, 2.0), "0.0 ± 2.0");
  EXPECT_EQ(report::figure(0.0), "0");
  EXPECT_EQ(report::figure(-1.5e7), "−1.50 × 10⁷");
  EXPECT_EQ(report::probability(2.4e-9), "2 × 10⁻⁹");
  EXPECT_EQ(report::sure(0.9999), "more than 99 %");
  EXPECT_EQ(report::plain_label("rotor_loss#3"), "loss of rotor 3");
  EXPECT_EQ(report::plain_variable("body_rate_radps").unit, "rad/s");
}

TEST(Svg, TicksAreRoundAndInside) {
  EXPECT_THAT(svg::ticks(0.0, 1.03, 5, false), testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.5, 1.0}));
  EXPECT_THAT(svg::ticks(-1.2, 1.2, 5, false),
              testing::Pointwise(testing::DoubleNear(1e-12), {-1.0, -0.5, 0.0, 0.5, 1.0}));
  EXPECT_THAT(svg::ticks(0.008, 0.3, 4, true),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.01, 0.02, 0.05, 0.1, 0.2}));
  EXPECT_THAT(svg::ticks(0.0008, 3.0, 4, true),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.001, 0.01, 0.1, 1.0}));
}

TEST(Svg, BreaksLinesWhereNothingIsKnownAndKeepsWithinItsFrame) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  svg::Chart chart;
  chart.series.push_back({"before", svg::Mark::line, {0, 1, 2, 3, 4}, {0, 1, nan, 1, 0}, {}, {}});
  const std::string drawn = svg::draw(chart);
  EXPECT_THAT(drawn, testing::ContainsRegex("d=\"M[0-9. ]*L[0-9. ]*M[0-9. ]*L[0-9. ]*\""));
  EXPECT_EQ(unbalanced(drawn), "");
  chart.series[0].y.assign(5, nan);
  EXPECT_EQ(svg::draw(chart), "");
  // a constant series and a logarithm of zero have no width of their own
  chart.series[0].y = {2, 2, 2, 2, 2};
  EXPECT_THAT(svg::draw(chart), Not(HasSubstr("nan")));
  chart.log_y = true;
  chart.series[0].y = {0, -1, 2, 2, nan};
  EXPECT_THAT(svg::draw(chart), Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace gustlab
