#include "report/diagnosis_page.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "gustlab/effect.hpp"
#include "report/diagnosis_example.hpp"
#include "report/diagnosis_words.hpp"
#include "report/page_checks.hpp"
#include "report/svg.hpp"
#include "report/trade_words.hpp"
#include "support/parameters.hpp"

namespace gustlab {
namespace diagnosis_page_test {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;
using testing::Not;

// the numbers that an effect declares
class ParameterNames final : public test::QuietVisitor {
 public:
  std::vector<std::string> found;
  void number(std::string_view name, double&, const ParameterInfo&) override { found.emplace_back(name); }
  void integer(std::string_view name, std::int64_t&, const ParameterInfo&) override { found.emplace_back(name); }
};

// The page, whose spaces before per cent signs are as any.
std::string page_as_read(const Json& diagnosis, const DiagnosisFigures& figures) {
  std::string html = diagnosis_page(diagnosis, figures);
  for (std::size_t at; (at = html.find("&#160;%")) != std::string::npos;) html.replace(at, 6, " ");
  return html;
}

TEST(DiagnosisPage, IsSelfContainedAndWellFormed) {
  const std::string html = page_as_read(example_diagnosis(), example_figures());
  EXPECT_THAT(html, testing::StartsWith("<!doctype html>"));
  expect_sound(html);
  EXPECT_EQ(html, page_as_read(example_diagnosis(), example_figures()));
}

TEST(DiagnosisPage, SaysWhatItHasInTheOrderThatIsAskedFor) {
  const std::string html = page_as_read(example_diagnosis(), example_figures());
  std::size_t at = 0;
  for (const char* wanted : {"<h1>Rotor 3 gives 7.1 % less thrust",
                             "wrong by 0.7 cm instead of 3.1 cm",
                             "It leans toward rotor 3",
                             "The vehicle weighs 8.1 % more than its model",
                             "cannot tell it from thrust scale. Without flying, a pair of scales tells the mass and a "
                             "thrust stand tells the thrust scale.",
                             "About the recordings",
                             "battery sag cannot be told",
                             "Before and after",
                             "Path from above",
                             "Position: how far off",
                             "Motors, as recorded",
                             "400 samples",
                             "What was left out",
                             "Loss of rotor 3",
                             "0.01470 ± 0.00078",
                             "N s/m",
                             "Mass or thrust scale",
                             "Where it differs",
                             "airspeed above 0.6 m/s (82 % of it)",
                             "N = 150 blocks, left out: 12 blocks with saturated commands",
                             "How much better it predicts",
                             "over 412 windows of lemniscate.csv",
                             "Left out: 3 windows across gaps",
                             "Still not explained",
                             "repeat after 0.05 s",
                             "What cannot be told",
                             "these flights do not show it",
                             "fly: low flight",
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

// a simulation that turns over three times: four pieces, and no line from half a turn to minus half a turn
TEST(DiagnosisPage, BreaksTheLineOfAnAngleAtHalfATurn) {
  DiagnosisFigures figures = example_figures();
  std::vector<double>& roll_rad = figures.window.traces[3].before;
  for (std::size_t i = 0; i < roll_rad.size(); ++i)
    roll_rad[i] = std::remainder(0.05 * static_cast<double>(i), 2.0 * std::numbers::pi);
  const std::string html = page_as_read(example_diagnosis(), figures);
  const std::size_t chart = html.find(">Roll<"), path = html.find("<path class=\"before\"", chart);
  ASSERT_NE(chart, std::string::npos);
  const std::string drawn = html.substr(path, html.find("/>", path) - path);
  EXPECT_EQ(std::count(drawn.begin(), drawn.end(), 'M'), 4) << drawn;
}

TEST(DiagnosisPage, FitsAPhoneAndADesk) {
  Json diagnosis = example_diagnosis();
  // a line of code is long
  diagnosis["next_flight"]["parameters"]["frequencies_x_hz"] = {0.0527942, 0.121427, 0.216456, 0.385397, 0.469868};
  expect_fits(page_as_read(diagnosis, example_figures()));
}

TEST(DiagnosisPage, APerCentSignBeginsNoLine) {
  EXPECT_EQ(svg::escape("8.1 % more & 3 kg"), "8.1&#160;% more &amp; 3 kg");
}

// a label ends left of the axis; of seven digits at 6.5 px each none is cut off
TEST(DiagnosisPage, LongLabelsOfAnAxisHaveRoom) {
  const auto label_ends_px = [](double least, double most) {
    svg::Series series;
    series.style = "before", series.x = {0.0, 1.0}, series.y = {least, most};
    svg::Chart chart;
    chart.series = {series};
    const std::string drawn = svg::draw(chart);
    return std::stod(drawn.substr(drawn.find("<text x=\"") + 9));
  };
  EXPECT_GE(label_ends_px(1961.88, 1961.94), 7 * 6.5);
  EXPECT_EQ(label_ends_px(0.0, 0.06), label_ends_px(-0.06, 0.0));
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
  const std::string html = page_as_read(diagnosis, figures);
  EXPECT_THAT(html, Not(HasSubstr("<b>")));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;&quot;&#39;&amp;&lt;/b&gt;"));
  expect_sound(html);
}

TEST(DiagnosisPage, WhatIsMissingIsLeftOut) {
  for (const char* verdict : {"consistent", "insufficient_data", "unexplained", "explained", "partly_explained"}) {
    const std::string html = page_as_read({{"verdict", verdict}, {"augmented_model", "augmented.toml"}}, {});
    expect_sound(html);
    for (const char* absent :
         {"<figure>", "<table>", "About the recordings", "What to fly next", "Fly the improved model"})
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
  const std::string html = page_as_read(diagnosis, figures);
  expect_sound(html);
  EXPECT_THAT(html, HasSubstr("– sure"));
}

TEST(DiagnosisPage, AnUnnamedModelIsShownAsSuch) {
  Json diagnosis = example_diagnosis();
  diagnosis["verdict"] = "unexplained";
  diagnosis["effects"] = Json::array();
  diagnosis["residual_model"] = {
      {"terms",
       {{{"channel", "force_x"}, {"term", "vx |v|"}, {"coefficient", -0.012}, {"unit", "N s²/m²"}},
        {{"channel", "force_y"}, {"term", "1"}, {"coefficient", -0.2}, {"unit", "N per unit of the term"}}}}};
  const std::string html = page_as_read(diagnosis, {});
  expect_sound(html);
  EXPECT_THAT(html, HasSubstr("An unnamed effect"));
  // the blue line is not that of the model which the other charts fly
  constexpr const char* without = "After is with the names, and without the unnamed effect.";
  EXPECT_THAT(page_as_read(diagnosis, example_figures()), HasSubstr(without));
  EXPECT_THAT(page_as_read(example_diagnosis(), example_figures()), Not(HasSubstr(without)));
  EXPECT_THAT(html, HasSubstr("<code>vx |v|</code></td><td data-label=\"coefficient\" class=\"n\">−0.0120</td>"));
  EXPECT_THAT(html, AllOf(HasSubstr("class=\"unit\">N</td>"), Not(HasSubstr("per unit of the term"))));
}

TEST(DiagnosisPage, SaysOnceWhatSeveralRecordingsHave) {
  Json diagnosis = example_diagnosis();
  diagnosis["log_findings_in_short"] = {{{"kind", "filtered"}, {"says", "2 of 3 flights: px…wz it was smoothed"}}};
  EXPECT_THAT(page_as_read(diagnosis, {}),
              HasSubstr("<ul><li><strong>Filtered</strong>: 2 of 3 flights: px…wz it was smoothed.</li></ul>"));
}

TEST(DiagnosisPage, SaysOnceWhatIsSaidOfSeveralChannels) {
  Json diagnosis = example_diagnosis();
  diagnosis["alarms"] = Json::array();
  for (const char* name : {"position x", "roll rate", "specific force z"})
    diagnosis["alarms"].push_back(
        {{"kind", "whiteness"}, {"says", fmt::format("{} is not white", name)}, {"sensor", name}});
  diagnosis["alarms"].push_back({{"kind", "omnibus"}, {"says", "the rest depends on velocity"}});
  const std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, HasSubstr("comes in runs of several samples in position x, roll rate and specific force z.</li>"));
  EXPECT_THAT(html, AllOf(HasSubstr("the rest depends on velocity.</li>"), Not(HasSubstr("is not white"))));
  // a diagnosis of before that key says each by itself
  for (Json& alarm : diagnosis["alarms"]) alarm.erase("sensor");
  EXPECT_THAT(page_as_read(diagnosis, {}),
              AllOf(HasSubstr("position x is not white.</li>"), HasSubstr("roll rate is not white.</li>")));
}

TEST(DiagnosisPage, AnEffectThatWasAskedTwiceIsLookedAtOnce) {
  Json diagnosis = example_diagnosis();
  diagnosis["rejected"] = {{{"effect", "steady_wind"}, {"why", "first"}, {"delta_score", 97.0}},
                           {{"effect", "steady_wind"}, {"why", "second"}, {"delta_score", 13.0}}};
  const std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, AllOf(HasSubstr(">first</td>"), Not(HasSubstr(">second</td>"))));
}

// the page said of one log that torques are not known, and that roll torque is wrong everywhere
TEST(DiagnosisPage, TorquesThatALogDoesNotTellAreNotJudged) {
  Json diagnosis = example_diagnosis();
  diagnosis["mismatch"] = {
      {{"channel", "torque_x"}, {"significant", true}, {"rms", 2e-4}, {"noise_rms", 1e-4}, {"unit", "N m"}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("class=\"where\">everywhere</td>"));
  DiagnosisFigures figures = example_figures();
  figures.residuals[0].channel = "torque_x";
  EXPECT_THAT(page_as_read(diagnosis, figures),
              AllOf(HasSubstr("Roll torque"), HasSubstr("Roll and pitch: how far off")));
  diagnosis["torque_told"] = true;
  diagnosis["alarms"] = {{{"kind", "floor"}, {"says", "yaw torque is disturbed"}, {"channels", {"torque_z"}}},
                         {{"kind", "omnibus"}, {"says", "lift is left"}, {"channels", {"force_z", "torque_x"}}}};
  EXPECT_THAT(page_as_read(diagnosis, figures), AllOf(HasSubstr("yaw torque is disturbed"), HasSubstr("lift is left")));
  diagnosis["disturbance"] = {
      {{"group", "torque_z"}, {"before", 0.1}, {"after", 0.09}, {"unit", "rad/s^2"}, {"correlation_time_s", 0.1}}};
  EXPECT_THAT(page_as_read(diagnosis, figures), AllOf(HasSubstr("Roll torque"), HasSubstr("Unexplained disturbance"),
                                                      Not(HasSubstr("follow the recorded attitude"))));
  diagnosis["torque_told"] = false;
  EXPECT_THAT(page_as_read(diagnosis, figures),
              AllOf(HasSubstr("not judged, as these logs do not tell fast torques"), Not(HasSubstr(">everywhere<")),
                    Not(HasSubstr(">Roll torque</text>")), Not(HasSubstr("Roll and pitch: how far off")),
                    Not(HasSubstr("Unexplained disturbance")), Not(HasSubstr("yaw torque is disturbed")),
                    HasSubstr("lift is left"), HasSubstr("follow the recorded attitude")));
}

TEST(DiagnosisPage, WhatWasNotPredictedHasNoRow) {
  Json diagnosis = example_diagnosis();
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("class=\"name\">Attitude</td>"));
  for (auto& errors : diagnosis["fit"]["attitude_rad"])
    for (auto& error : errors) error = nullptr;
  EXPECT_THAT(page_as_read(diagnosis, {}),
              AllOf(Not(HasSubstr("class=\"name\">Attitude</td>")), HasSubstr("class=\"name\">Velocity</td>")));
}

TEST(DiagnosisPage, ShowsSuspectsWithTheReasonWhyTheyHaveNoName) {
  Json diagnosis = example_diagnosis();
  EXPECT_THAT(page_as_read(diagnosis, {}), Not(HasSubstr("Suspected")));
  diagnosis["effects"] = Json::array();
  diagnosis["rejected"] = {{{"effect", "motor_lag"}, {"why", "only suspected: half of it remains"}},
                           {{"effect", "mass"}, {"why", "only suspected: half of it remains"}}};
  EXPECT_THAT(page_as_read(diagnosis, {}),
              HasSubstr("<p>Suspected, and not named because half of it remains: motor lag and mass.</p>"));
}

// it stood in the header, among what was looked at, and with 92 % among the names that came nearest
TEST(DiagnosisPage, ANameThatWasTakenBackStandsOnce) {
  Json diagnosis = example_diagnosis();
  diagnosis["effects"] = Json::array();
  diagnosis["residual_model"] = {{"terms", Json::array()}};
  diagnosis["rejected"] = {
      {{"effect", "rotor_loss (rotor 2)"}, {"why", "only suspected: columns of the motion contradict each other"}},
      {{"effect", "steady_wind"}, {"why", "does not make the predictions better"}}};
  diagnosis["evidence"] = {{{"effect", "rotor_loss"}, {"rotor", 2}, {"probability", 0.92}}};
  const std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(
      html,
      AllOf(HasSubstr("not named because columns of the motion contradict each other: loss of rotor 2.</p>"),
            HasSubstr("No effect of the catalogue came near enough"), HasSubstr("does not make the predictions")));
  // the other place is the table of numbers
  const std::size_t first = html.find("loss of rotor 2"), table = html.find("Evidence, one line");
  EXPECT_EQ(html.find("loss of rotor 2", first + 1), html.find("loss of rotor 2", table));
  EXPECT_EQ(html.rfind("loss of rotor 2"), html.find("loss of rotor 2", table));
  EXPECT_THAT(html.substr(table), AllOf(HasSubstr(">taken back</td>"), Not(HasSubstr("92 %"))));
}

// a force removed 66 % of the error and was 1 % likely, and nothing said why
TEST(DiagnosisPage, SaysWhyWhatRemovesMuchHasNoName) {
  Json diagnosis = example_diagnosis();
  const char* why = "moved along the flight it fits as well";
  diagnosis["evidence"] = {{{"effect", "constant_force"},
                            {"probability", 0.01},
                            {"weak_points", {why, "its size differs between flights"}},
                            {"recovered", {0.1, 0.66, 0.2}},
                            {"recovered_z", {1.0, 50.3, 1.0}}}};
  diagnosis["rejected"] = {
      {{"effect", "constant_force"}, {"why", std::string("its own evidence makes it 1 % likely: ") + why}}};
  std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(html,
              HasSubstr("<li><strong>Constant force</strong> removes 66 % of the error half a second ahead and has no "
                        "name, because by its evidence it is 1 % likely: moved along the flight it fits as well; "
                        "its size differs between flights.</li>"));
  EXPECT_EQ(html.find(why), html.rfind(why));  // once
  EXPECT_THAT(html, HasSubstr("makes it unlikely, for the reasons above"));
  // what removes little has its reasons in the table
  diagnosis["evidence"][0]["recovered"][1] = 0.1;
  html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, AllOf(Not(HasSubstr("<strong>Constant force</strong> removes")), HasSubstr(why)));
  // beside an unnamed model the nearest names have theirs
  diagnosis["residual_model"] = {{"terms", Json::array()}};
  EXPECT_THAT(page_as_read(diagnosis, {}),
              HasSubstr("Nearest came constant force (1 %). What speaks against constant force: moved along"));
  // and what is more likely than not
  diagnosis["suspected"] = {{{"effect", "constant_force"}, {"confidence", 0.6}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("(60 %). What speaks against constant force: moved along"));
}

TEST(OneSentence, FitsTheVerdict) {
  Json diagnosis = example_diagnosis();
  EXPECT_EQ(report::one_sentence(diagnosis),
            "Rotor 3 gives 7.1 % less thrust; rotor drag of 0.0147 N s/m holds it back; logged positions and attitudes "
            "are 12.1 ms late; and 2 things more.");
  while (diagnosis["effects"].size() > 2) diagnosis["effects"].erase(2);
  diagnosis["verdict"] = "partly_explained";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "Rotor drag of 0.0147 N s/m holds it back; and the vehicle weighs 8.1 % more than its model (or thrust "
            "scale). Something else remains.");
  diagnosis["effects"].clear();
  diagnosis["verdict"] = "unexplained";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "Something acts on crazyflie that the simulation leaves out (mostly in the push forward or back, when "
            "airspeed is above "
            "0.6 m/s), and no effect known here is sure enough to be named.");
  // no place that is not judged, or not above the noise
  for (Json& entry : diagnosis["mismatch"])
    if (!entry["channel"].get<std::string>().starts_with("torque")) entry["rms"] = entry["noise_rms"];
  EXPECT_THAT(report::one_sentence(diagnosis), HasSubstr("mostly in the pitch torque"));
  diagnosis["torque_told"] = false;
  EXPECT_THAT(report::one_sentence(diagnosis), HasSubstr("leaves out, and no effect"));
  diagnosis["verdict"] = "consistent";
  EXPECT_EQ(report::one_sentence(diagnosis),
            "The simulation of crazyflie agrees with these flights: nothing is left beyond noise and calm air.");
}

TEST(OneSentence, EveryVerdictIsReadAndNoOtherWord) {
  using enum diagnosis::Verdict;
  for (const diagnosis::Verdict verdict : {consistent, explained, partly_explained, unexplained, insufficient_data})
    EXPECT_EQ(report::verdict_of({{"verdict", to_string(verdict)}}), verdict);
  for (const Json& other : {Json{{"verdict", "Explained"}}, Json{{"verdict", 1}}, Json::object()})
    EXPECT_EQ(report::verdict_of(other), std::nullopt);
}

// measured rotor speeds drive the body: a lag that they show changes none of its predictions
TEST(GainSentence, ClaimsNoGainThatItsDigitsDoNotShow) {
  Json diagnosis = example_diagnosis();
  EXPECT_EQ(report::gain_sentence(diagnosis),
            "With what was found, the position predicted 0.5 s ahead is wrong by 0.7 cm instead of 3.1 cm, on flights "
            "that were not used to find it.");
  diagnosis["effects"].clear();
  EXPECT_EQ(report::gain_sentence(diagnosis), "");
  diagnosis["residual_model"] = {{"terms", {{{"term", "1"}}}}};
  EXPECT_THAT(report::gain_sentence(diagnosis), testing::StartsWith("With a model that has no name, the position"));
  diagnosis["effects"] = example_diagnosis()["effects"];
  EXPECT_THAT(report::gain_sentence(diagnosis),
              testing::StartsWith("With what was found and a model of the rest that has no name, the position"));
  diagnosis["fit"]["position_m"]["before"] = diagnosis["fit"]["position_m"]["after"];
  EXPECT_EQ(report::gain_sentence(diagnosis), "");
}

// of one flight the summary told the 3.0 cm alone
TEST(GainSentence, SaysWhatTheNamesGiveWhatTheModelAddsAndWhatGetsWorse) {
  Json diagnosis = example_diagnosis();
  diagnosis["residual_model"] = {{"terms", {{{"term", "1"}}}},
                                 {"fit_without", {{"position_m", {0.002, 0.0378, 0.13}}}}};
  Json& fit = diagnosis["fit"];
  fit["position_m"]["after"][1] = 0.0301, fit["position_m"]["before"][1] = 0.0332;
  fit["velocity_mps"]["after"] = {0.0211, 0.1188, 0.234};
  fit["velocity_mps"]["before"] = {0.021, 0.123, 0.229};
  fit["velocity_mps"]["hold"] = {0.04, 0.108, 0.162};
  fit["attitude_rad"]["after"][0] = 0.02, fit["attitude_rad"]["hold"][0] = 0.0199;
  EXPECT_EQ(
      report::gain_sentence(diagnosis),
      "The position predicted 0.5 s ahead is wrong by 3.3 cm in the simulation as it was, by 3.8 cm with what was "
      "named, and by 3.0 cm with a model of the rest that has no name as well, on flights that were not used to find "
      "it. Worse than before: velocity 1 s ahead (0.234 m/s instead of 0.229) and attitude 0.1 s ahead (1.15 ° "
      "instead of 0.630). Still worse than no model, which keeps the last values: velocity 0.5 and 1 s ahead.");
  // also where the position gains nothing
  fit["position_m"]["before"] = fit["position_m"]["after"];
  EXPECT_THAT(report::gain_sentence(diagnosis), testing::StartsWith("Worse than before: velocity 1 s ahead"));
  fit["velocity_mps"]["before"] = fit["velocity_mps"]["hold"] = fit["velocity_mps"]["after"];
  fit["attitude_rad"]["before"] = fit["attitude_rad"]["hold"] = fit["attitude_rad"]["after"];
  EXPECT_EQ(report::gain_sentence(diagnosis), "");
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

// what the old page said of one channel: rms 0.401, noise 0.401, p < 1e-12
TEST(DiagnosisPage, SaysNoPatternEverywhereWhereTheNoiseIsAsLarge) {
  Json diagnosis = example_diagnosis();
  Json& entry = diagnosis["mismatch"][1];
  const auto row = [&](double rms, double noise, double p_value, bool significant) {
    entry["rms"] = rms, entry["noise_rms"] = noise, entry["p_value"] = p_value, entry["significant"] = significant;
    const std::string html = page_as_read(diagnosis, {});
    const std::size_t at = html.find("ush to the side") - 1;
    return "p" + html.substr(at + 1, html.find("</tr>", at) - at);
  };
  // a sentence, and no row
  for (const double rms : {0.401, 0.259})
    for (const bool significant : {true, false})
      EXPECT_THAT(
          row(rms, 0.401, 1e-20, significant),
          AllOf(testing::StartsWith("push to the side: no larger than noise and air.</p>"), Not(HasSubstr("<td"))));
  EXPECT_THAT(row(0.5, 0.401, 0.4, false), HasSubstr("no more than noise and air"));
  EXPECT_THAT(row(0.5, 0.401, 1e-20, false), HasSubstr("a pattern, too small to matter"));
  EXPECT_THAT(row(3.1, 1.0, 0.4, false), AllOf(HasSubstr("more than noise and air, in no pattern that is sure"),
                                               Not(HasSubstr("no more than noise and air"))));
  EXPECT_THAT(row(9.27, 3.0, 1e-20, false),
              AllOf(HasSubstr("3.09 ×"), HasSubstr("more than noise and air, and still too small to matter")));
  EXPECT_THAT(row(4.0, 0.5, 1e-20, true), AllOf(HasSubstr("8.00 ×"), HasSubstr("everywhere")));
}

// what readers of real pages stumbled over
TEST(DiagnosisPage, SaysWhatFlightsWereForReferenceAndWhatTheyShow) {
  Json diagnosis = example_diagnosis();
  diagnosis["flights"][0]["role"] = "reference", diagnosis["flights"][1]["role"] = "set_aside";
  diagnosis["effects"] = Json::array();
  diagnosis["verdict"] = "unexplained";
  diagnosis["reference_effects"] = {
      {{"effect", "thrust_scale"}, {"parameters", {{"delta", {{"value", -0.05}, {"std", 0.002}, {"unit", "-"}}}}}}};
  const std::string html = page_as_read(diagnosis, example_figures());
  for (const char* wanted :
       {"1 flight to find, 1 for reference, 1 to check, 73 s in all",
        "neither the simulation nor the reference flights", "with what the reference flights show",
        "What the reference flights show already",
        ">thrust scale</td><td data-label=\"parameter\">change</td><td data-label=\"value ± 95 %\" class=\"n\">−5.00 ± "
        "0.39</td>"})
    EXPECT_THAT(html, HasSubstr(wanted));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("with what was found")), Not(HasSubstr("What was left out"))));
  diagnosis["verdict"] = "consistent";
  EXPECT_THAT(report::one_sentence(diagnosis), HasSubstr("Nothing changed since the reference flights of crazyflie"));
}

TEST(DiagnosisPage, SaysProvedWhereSomethingIsSuspected) {
  Json diagnosis = {{"verdict", "consistent"}};
  EXPECT_THAT(report::one_sentence(diagnosis), HasSubstr("nothing is left beyond noise"));
  diagnosis["suspected"] = {{{"effect", "axial_inflow"}, {"confidence", 0.71}}};
  EXPECT_THAT(report::one_sentence(diagnosis), HasSubstr("nothing is proved beyond noise"));
}

// the card said of a change since reference flights that it is one against the model, and gave an unknown height of 0 ± 490 mm
TEST(DiagnosisPage, OfHoverBesideReferenceFlightsIsOfWhatChanged) {
  const Json number = {{"value", 0.012}, {"std", 0.002}, {"unit", "m"}};
  const Json diagnosis = {
      {"verdict", "explained"},
      {"vehicle", "crazyflie"},
      {"augmented_model", "augmented.toml"},
      {"flights", {{{"file", "a.csv"}, {"role", "fit"}}, {{"file", "b.csv"}, {"role", "reference"}}}},
      {"mismatch",
       {{{"channel", "torque_x"},
         {"significant", false},
         {"p_value", 0.9},
         {"rms", 7.84e-6},
         {"noise_rms", 0.039},
         {"unit", "N m"}}}},
      {"effects",
       {{{"effect", "center_of_mass"},
         {"place", "body"},
         {"confidence", 0.9},
         {"says", "the centre of mass is not where the model has it"},
         {"parameters", {{"x", number}, {"z", {{"value", 0.0}, {"std", 0.25}, {"unit", "m"}}}}}}}},
      {"not_identifiable", {{{"effect", "inertia"}, {"lack", "attitude_and_rate"}}}}};
  const std::string html = page_as_read(diagnosis, {});
  for (const char* wanted :
       {"farther forward than in the reference flights", "What changed since the reference flights",
        "The numbers are changes since the reference flights.", ">not told</td>",
        ">Roll torque: no larger than noise and air.</p>"})
    EXPECT_THAT(html, HasSubstr(wanted));
  for (const char* wrong : {"the model has it", "gustlab replay", "What was left out"})
    EXPECT_THAT(html, Not(HasSubstr(wrong)));
}

TEST(DiagnosisPage, OfHoverAloneSaysNoMore) {
  const Json diagnosis = {{"verdict", "consistent"},
                          {"vehicle", "crazyflie"},
                          {"not_identifiable", {{{"effect", "inertia"}, {"lack", "attitude_and_rate"}}}}};
  EXPECT_EQ(report::one_sentence(diagnosis),
            "In hover the flights of crazyflie agree with each other; nothing else can be told from them.");
}

TEST(DiagnosisPage, SaysAtTheTopWhatWouldHelpWhereCommandsWereSampled) {
  Json diagnosis = {{"verdict", "insufficient_data"},
                    {"vehicle", "crazyflie"},
                    {"not_identifiable",
                     {{{"effect", "inertia"}, {"lack", "excitation"}, {"why", "one thing"}},
                      {{"effect", "mass"}, {"lack", "excitation"}, {"why", "another"}}}}};
  EXPECT_THAT(report::one_sentence(diagnosis), ::testing::EndsWith("Log at the loop's rate."));
  diagnosis["not_identifiable"][0]["lack"] = "attitude_and_rate";
  EXPECT_THAT(report::one_sentence(diagnosis), ::testing::EndsWith("is right or wrong."));
}

// the same line twice hides the first
TEST(DiagnosisPage, DrawsNoSecondModelWhereNothingWasFitted) {
  Json diagnosis = example_diagnosis();
  for (const char* list : {"effects", "calibration"}) diagnosis[list] = Json::array();
  diagnosis["verdict"] = "insufficient_data";
  DiagnosisFigures figures = example_figures();
  figures.residuals.clear();
  const std::string html = page_as_read(diagnosis, figures);
  EXPECT_THAT(html, AllOf(HasSubstr("class=\"before\""), Not(HasSubstr("<path class=\"after\""))));
  EXPECT_THAT(html, Not(HasSubstr("with what was found")));
}

TEST(DiagnosisPage, EndsSentencesOnceAndRoundsShares) {
  Json diagnosis = example_diagnosis();
  diagnosis["log_findings_in_short"] = {{{"kind", "unit"}, {"says", "is it the right unit?"}}};
  diagnosis["mismatch"][0]["rms"] = 1.996 * 0.0007;
  diagnosis["evidence"] = {{{"effect", "mass"},
                            {"probability", 0.9},
                            {"delta_chi2", 147956.0},
                            {"surrogate_p", 0.005},
                            {"recovered", {0.1, -0.894, 0.2}},
                            {"recovered_z", {1.0, 50.3, 1.0}}},
                           {{"effect", "gust"}, {"recovered", {0.0, 0.0, 0.0}}, {"recovered_z", {0.0, 0.0, 0.0}}}};
  const std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, AllOf(HasSubstr("is it the right unit?</li>"), HasSubstr("2.00 ×"), Not(HasSubstr("e+02"))));
  for (const char* wanted :
       {">148000</td>", ">0.005</td>", ">−89 %</td>", "held-out error removed, 0.5 s\" class=\"n\">–",
        "by so many standard errors: quadratic drag (9.1) and steady wind (14.2)"})
    EXPECT_THAT(html, HasSubstr(wanted));
  EXPECT_THAT(html, Not(HasSubstr("(z = ")));
}

// a page said of lift that it is no larger than the noise, beside a curve of it with small bars
TEST(DiagnosisPage, ACurveOfWhatIsWithinTheNoiseSaysSo) {
  Json diagnosis = example_diagnosis();
  const char* note = "from one moment to the next, noise and air make as much";
  EXPECT_THAT(page_as_read(diagnosis, example_figures()), Not(HasSubstr(note)));
  for (Json& entry : diagnosis["mismatch"]) entry["rms"] = entry["noise_rms"];
  EXPECT_THAT(page_as_read(diagnosis, example_figures()), HasSubstr(note));
}

// where the logs tell no torque a size of it means nothing
TEST(DiagnosisPage, ShowsNoSizeOfWhatIsNotJudged) {
  Json diagnosis = example_diagnosis();
  diagnosis["torque_told"] = false;
  const std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, AllOf(HasSubstr("<p>Pitch torque: not judged, as these logs do not tell fast torques.</p>"),
                          Not(HasSubstr("pitch torque</td>"))));
}

// the page of one flight spoke of a second one to check, and of flights that were not used
TEST(DiagnosisPage, OneFlightIsSaidToBeCutAndNoFlightIsSaidToCheck) {
  Json diagnosis = example_diagnosis();
  diagnosis["flights"] = {{{"file", "a.csv"}, {"role", "fit"}, {"duration_s", 40.0}},
                          {{"file", "a.csv"}, {"role", "holdout"}, {"duration_s", 20.0}}};
  const std::string cut = page_as_read(diagnosis, example_figures());
  for (const char* wanted : {"1 flight, its first two thirds to find and its last third to check, 60 s in all",
                             "on the last third of the flight, which was not used to find it",
                             "On the last third of the flight, which was not used to find the effects.",
                             "The last third was never used to choose or to fit an effect"})
    EXPECT_THAT(cut, HasSubstr(wanted));
  EXPECT_THAT(cut, AllOf(Not(HasSubstr("On held-out flights")), Not(HasSubstr("1 to check"))));
  diagnosis["flights"] = {{{"file", "a.csv"}, {"role", "fit"}, {"duration_s", 40.0}},
                          {{"file", "b.csv"}, {"role", "reference"}, {"duration_s", 20.0}}};
  diagnosis.erase("fit");
  EXPECT_THAT(page_as_read(diagnosis, {}),
              AllOf(HasSubstr("1 flight to find, 1 for reference, none to check, 60 s in all"),
                    Not(HasSubstr("Held-out flights were never"))));
}

// one page said that commands are 41 ms late or that motors lag, that both are too small to matter, and that a lag is not there
TEST(DiagnosisPage, DoesNotContradictWhatItNames) {
  Json diagnosis = example_diagnosis();
  diagnosis["effects"][0] = {{"effect", "actuation_delay"},
                             {"place", "actuation"},
                             {"confidence", 0.96},
                             {"says", "the rotors obey a command of a while ago"},
                             {"parameters", {{"delay", {{"value", 0.041}, {"std", 0.003}, {"unit", "s"}}}}},
                             {"class", {"actuation_delay", "motor_lag"}}};
  diagnosis["mismatch"].push_back({{"channel", "actuation"},
                                   {"significant", false},
                                   {"p_value", 1e-38},
                                   {"rms", 0.032},
                                   {"noise_rms", 0.004},
                                   {"unit", "s"}});
  diagnosis["rejected"].push_back({{"effect", "motor_lag"},
                                   {"delta_score", -10.8},
                                   {"why", "does not make the predictions better"},
                                   {"would_show", {{"time_constant", {{"value", 0.011}, {"unit", "s"}}}}}});
  diagnosis["evidence"] = {{{"effect", "motor_lag"}, {"probability", 0.004}, {"delta_chi2", 500.0}}};
  const std::string html = page_as_read(diagnosis, {});
  const auto row = [&](const std::string& begin, const std::string& of) {
    const std::size_t at = html.find(of, html.find(begin));
    return html.substr(at, html.find("</tr>", at) - at);
  };
  EXPECT_THAT(
      row("Where it differs", "answer to commands"),
      AllOf(HasSubstr("more than noise and air: what was found acts here"), Not(HasSubstr("too small to matter"))));
  EXPECT_THAT(row("Looked at and not named", "motor lag"),
              AllOf(HasSubstr("in place of actuation delay it would fit as well; beside it little is left for it"),
                    Not(HasSubstr("does not make")), Not(HasSubstr("11 ms"))));
  EXPECT_THAT(row("Evidence, one line", "motor lag"),
              AllOf(HasSubstr("in place of actuation delay"), Not(HasSubstr("0 %"))));
}

TEST(DiagnosisPage, TheOrderOfJudgingShowsWhereANameWent) {
  Json diagnosis = example_diagnosis();
  EXPECT_THAT(page_as_read(diagnosis, {}), Not(HasSubstr("In which order")));
  const Json lag = {{"effect", "motor_lag"}, {"probability", 0.93}},
             loss = {{"effect", "rotor_loss"}, {"rotor", 3}, {"probability", 0.12}};
  diagnosis["history"] = {
      {{"names", {lag, loss}},
       {"minus_two_log_likelihood", 812.4},
       {"withdrawn", {"rotor_loss#3"}},
       {"in_its_place", "center_of_mass"},
       {"answer", false}},
      {{"names", {lag}}, {"minus_two_log_likelihood", 801.2}, {"withdrawn", Json::array()}, {"answer", true}},
      {{"names", Json::array()}, {"minus_two_log_likelihood", 840.0}, {"withdrawn", Json::array()}, {"answer", false}}};
  const std::string html = page_as_read(diagnosis, {});
  const std::string part = html.substr(html.find("In which order"));
  EXPECT_THAT(
      part, AllOf(HasSubstr("motor lag (93 %) and loss of rotor 3 (12 %)"),
                  HasSubstr("loss of rotor 3 withdrawn for its rival centre of mass"), HasSubstr("this is the answer"),
                  HasSubstr("no name</td>"), HasSubstr("costs a name"), HasSubstr("801")));
}

// lift was 144 times the noise on a page that began with "nothing changed"; which of two rotors; 1.64 × 10⁻⁵ ms
TEST(DiagnosisPage, WhatIsOnlyLikelyIsSaidWithItsSize) {
  Json diagnosis = example_diagnosis();
  diagnosis["verdict"] = "consistent";
  diagnosis["suspected"] = {diagnosis["effects"][1], diagnosis["effects"][2]};
  diagnosis["effects"] = Json::array();
  diagnosis["flights"][0]["role"] = "reference";
  diagnosis["suspected"][0]["confidence"] = 0.77;
  diagnosis["evidence"] = {{{"effect", "rotor_loss"}, {"rotor", 3}, {"probability", 0.01}}};
  diagnosis["mismatch"][0]["rms"] = 1e-9;
  const std::string html = page_as_read(diagnosis, {});
  for (const char* wanted :
       {"Nothing is proved to have changed since the reference flights of crazyflie beyond noise and calm air.",
        "More likely than not, and not proved: the vehicle weighs 8.1 % more than its model (77 %) and rotor 3 gives",
        ">loss of rotor 3</td>"})
    EXPECT_THAT(html, HasSubstr(wanted));
}

// "swings 49 mm below it" beside 49 ± 530 mm; what differs in hover is no simulation; a remark alone is nothing unexplained
TEST(DiagnosisPage, SaysNoMoreThanWasFound) {
  Json diagnosis = example_diagnosis();
  diagnosis["effects"] = {{{"effect", "slung_load"},
                           {"confidence", 0.92},
                           {"parameters",
                            {{"mass", {{"value", 0.0957}, {"std", 0.003}, {"unit", "kg"}}},
                             {"length", {{"value", 0.049}, {"std", 0.27}, {"unit", "m"}}}}}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr(">A load of 96 g swings below it<"));
  diagnosis["effects"][0]["parameters"]["length"]["std"] = 0.004;
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr(">A load of 96 g swings 49 mm below it<"));

  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("The difference between simulation and recording"));
  diagnosis["not_identifiable"] = {{{"effect", "inertia"}, {"lack", "attitude_and_rate"}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("The difference from the flights taken as normal, in hover"));
  diagnosis["flights"][0]["role"] = "reference";
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("The difference from the reference flights, in hover"));

  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("Still not explained, and remarks"));
  diagnosis["alarms"] = Json::array();
  diagnosis["notes"] = {"no flight was held out by the user"};
  EXPECT_THAT(page_as_read(diagnosis, {}), AllOf(HasSubstr(">Remarks<"), Not(HasSubstr("Still not explained"))));
}

// a log with a total thrust alone had a legend of one rotor
TEST(DiagnosisPage, ATotalThrustIsNoRotor) {
  DiagnosisFigures figures = example_figures();
  EXPECT_THAT(page_as_read(example_diagnosis(), figures),
              AllOf(HasSubstr(">Motors, as recorded"), HasSubstr(">rotor 4<")));
  figures.window.motors.resize(1);
  figures.window.motors.front().name = "total thrust";
  EXPECT_THAT(page_as_read(example_diagnosis(), figures),
              AllOf(HasSubstr(">Total thrust, as recorded"), HasSubstr(">total thrust<"), Not(HasSubstr(">rotor 1<"))));
}

// commands are answered late, as two lags would show
Json late_answer(double rms_s, double noise_s) {
  Json diagnosis = example_diagnosis();
  diagnosis["mismatch"].push_back({{"channel", "actuation"},
                                   {"significant", true},
                                   {"rms", rms_s},
                                   {"noise_rms", noise_s},
                                   {"unit", "s"},
                                   {"effects", {"a_lag", "another_lag"}}});
  return diagnosis;
}

std::string answer_row(const Json& diagnosis) {
  const std::string html = page_as_read(diagnosis, {});
  const std::size_t at = html.find("answer to commands");
  return html.substr(at, std::min(html.find("</tr>", at), html.find("</p>", at)) - at);
}

// a lag of 820 ms "everywhere" beside "how late a torque is, is not told" made every other bar invisible
TEST(DiagnosisPage, ALagThatCannotBeToldIsNotJudged) {
  Json diagnosis = late_answer(0.82, 0.003);
  const auto row = [&] { return answer_row(diagnosis); };
  EXPECT_THAT(row(), HasSubstr("820 ms"));
  for (const char* name : {"a_lag", "another_lag"}) {
    EXPECT_THAT(row(), HasSubstr("820 ms")) << "one of the two would show";
    diagnosis["not_identifiable"].push_back({{"effect", name}, {"why", "it was filtered"}, {"lack", "raw_sensors"}});
  }
  EXPECT_THAT(row(), AllOf(HasSubstr("not judged, as a lag and another lag are not identifiable in these flights"),
                           Not(HasSubstr("820"))));
}

// 58 ms of a lag, 14 times what is reported, were "too small to matter"
TEST(DiagnosisPage, ALagThatExplainsTooLittleIsNotCalledSmall) {
  Json diagnosis = late_answer(0.058, 0.004);
  diagnosis["mismatch"].back()["significant"] = false;
  diagnosis["mismatch"].back()["p_value"] = 1e-6;
  EXPECT_THAT(answer_row(diagnosis), HasSubstr("it would explain too little to be sure of it"));
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("of times, the least that is reported."));
}

// 609 ms of a lag, where a wind was named that does as well
TEST(DiagnosisPage, ALagThatLooksLikeWhatIsNamedIsNotJudged) {
  Json diagnosis = late_answer(0.609, 0.004);
  const auto row = [&] { return answer_row(diagnosis); };
  diagnosis["effects"][0]["class"] = {diagnosis["effects"][0]["effect"], "a_lag"};
  EXPECT_THAT(row(), HasSubstr("609 ms"));
  diagnosis["effects"][0]["class"].push_back("another_lag");
  EXPECT_THAT(row(),
              AllOf(HasSubstr("not judged, as a lag and another lag cannot be told from "), Not(HasSubstr("609"))));
  // 993 ms of a line through zero beside a lag of 247 ms that was found
  diagnosis["effects"][0]["effect"] = "a_lag";
  EXPECT_THAT(row(), AllOf(HasSubstr("a lag acts here, and its size stands above"), Not(HasSubstr("609"))));
}

// a delay of 0 ± 30 ms was a small correction, and could not be told
TEST(DiagnosisPage, WhatCannotBeToldIsNoCalibration) {
  Json diagnosis = example_diagnosis();
  diagnosis["calibration"] = {
      {{"effect", "a_delay"}, {"parameters", {{"delay", {{"value", 0.0}, {"std", 0.015}, {"unit", "s"}}}}}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr(">a delay</td>"));
  diagnosis["not_identifiable"] = {{{"effect", "a_delay"}, {"why", "it was filtered"}, {"lack", "raw_sensors"}}};
  EXPECT_THAT(page_as_read(diagnosis, {}), Not(HasSubstr("<td class=\"name\">a delay</td>")));
}

// "2.2e-07 N s²", "0.00077 kg", "0.17" of what
TEST(DiagnosisPage, WhatWouldShowHasAUnitOrAName) {
  Json diagnosis = example_diagnosis();
  const auto of = [&](const char* effect, const char* parameter, double value, const char* unit) {
    diagnosis["rejected"] = {
        {{"effect", effect}, {"why", "no"}, {"would_show", {{parameter, {{"value", value}, {"unit", unit}}}}}}};
    const std::string html = page_as_read(diagnosis, {});
    const std::size_t at = html.find(">", html.find("data-label=\"would show from\"")) + 1;
    return html.substr(at, html.find("</td>", at) - at);
  };
  EXPECT_EQ(of("flapping_torque", "coefficient", 2.16e-7, "N s^2"), "2.2 × 10⁻⁷ N s²");
  EXPECT_EQ(of("slung_load", "mass", 7.7e-4, "kg"), "0.77 g");
  EXPECT_EQ(of("battery_sag", "exponent", 0.17, "-"), "exponent 0.17");
  EXPECT_EQ(of("battery_sag", "rate", 2.2e-4, "1/s"), "1.3 %/min");
  EXPECT_EQ(of("mass", "delta", 0.0056, "-"), "0.56 %");
  EXPECT_EQ(of("yaw_offset", "z", 0.00295, "rad"), "0.17°");
  EXPECT_EQ(of("translational_lift", "coefficient", 1234.0, "N"), "1200 N");
}

// x, y and z of a vector are said as directions
TEST(DiagnosisPage, AnAxisIsSaidInWords) {
  Json diagnosis = example_diagnosis();
  const Json number = {{"value", 0.0543}, {"std", 0.0017}, {"unit", "rad"}};
  while (diagnosis["effects"].size() > 1) diagnosis["effects"].erase(1);
  diagnosis["calibration"] = Json::array();
  const auto names = [&](const char* effect, const char* parameter) {
    diagnosis["effects"][0]["effect"] = effect;
    diagnosis["effects"][0]["parameters"] = {{parameter, number}};
    const std::string html = page_as_read(diagnosis, {});
    for (const char* words : {"forward", "left", "up", "roll", "pitch", "toward world x", "change in roll", "height"})
      if (html.find(fmt::format("<td data-label=\"parameter\" class=\"name\">{}</td>", words)) != std::string::npos)
        return std::string(words);
    return std::string();
  };
  EXPECT_EQ(names("rotor_tilt", "x"), "forward");
  EXPECT_EQ(names("center_of_mass", "z"), "up");
  EXPECT_EQ(names("constant_force", "x"), "toward world x");
  EXPECT_EQ(names("attitude_offset", "y"), "pitch");
  EXPECT_EQ(names("inertia", "delta_x"), "change in roll");
}

// three lines that say that something is left
// a page said "no larger than the noise", "a pattern is left" and "3.3 times as much as in a calm room" of one channel
TEST(DiagnosisPage, RemarksDoNotContradictTheTableOfChannels) {
  Json diagnosis = example_diagnosis();
  diagnosis["mismatch"].push_back(
      {{"channel", "torque_x"}, {"significant", true}, {"rms", 2.0}, {"noise_rms", 1.0}, {"unit", "N m"}});
  Json& entry = diagnosis["mismatch"][2];
  entry = {{"channel", "force_z"}, {"significant", true}, {"rms", 0.138}, {"noise_rms", 0.137}, {"unit", "N"}};
  diagnosis["torque_told"] = false;
  diagnosis["alarms"] = {{{"kind", "omnibus"},
                          {"says", "what is left of force_z follows how the vehicle moves"},
                          {"channels", {"force_z", "torque_x"}}},
                         {{"kind", "floor"},
                          {"says", "lift is disturbed 3.3 times as much as in a calm room, slowly"},
                          {"channels", {"force_z"}}}};
  std::string html = page_as_read(diagnosis, {});
  EXPECT_THAT(
      html,
      AllOf(HasSubstr(">Lift: no larger than noise and air.</p>"),
            HasSubstr("of lift follows how the vehicle moves, and is no larger than noise and air.</li>"),
            HasSubstr("in a calm room, slowly: no name explains it, and it is counted as noise and "
                      "air above.</li>"),
            // a row of dashes each, before
            HasSubstr("<p>Pitch torque and roll torque: not judged, as these logs do not tell fast torques.</p>")));
  entry["rms"] = 0.5;
  html = page_as_read(diagnosis, {});
  EXPECT_THAT(html, AllOf(HasSubstr("follows how the vehicle moves.</li>"), HasSubstr("a calm room, slowly.</li>"),
                          Not(HasSubstr("no larger than noise and air"))));
}

// a page said that nothing in the catalogue explains a constant force, beside the evidence of the constant force of the catalogue
TEST(DiagnosisPage, AnUnnamedModelSaysWhichNamesCameNearest) {
  Json diagnosis = example_diagnosis();
  diagnosis["residual_model"] = {{"terms", Json::array()}};
  EXPECT_THAT(page_as_read(diagnosis, {}), HasSubstr("No effect of the catalogue came near enough to be judged"));
  diagnosis["evidence"] = Json::array();
  for (const auto& [name, probability] : {std::pair{"mass", 0.9},
                                          {"ground_effect", 0.7},
                                          {"thrust_scale", 0.6},
                                          {"fans", 0.001},
                                          {"constant_force", 0.31},
                                          {"axial_inflow", 0.002},
                                          {"quadratic_drag", 0.01}})
    diagnosis["evidence"].push_back({{"effect", name}, {"probability", probability}});
  // mass is named, thrust scale looks like it, and ground effect is not identifiable
  EXPECT_THAT(
      page_as_read(diagnosis, {}),
      AllOf(HasSubstr(">ground effect</td><td data-label=\"probability\" class=\"n\">not identifiable</td>"),
            HasSubstr("No name was sure enough for the rest, which takes 80 %. Nearest came constant force (31 %), "
                      "quadratic drag (1 %) and axial inflow (less than 1 %)."),
            Not(HasSubstr("Nothing in the catalogue"))));
}

// the path of four seconds was a diagonal; drawn is the prediction in which the lines are farthest apart
TEST(DiagnosisPage, ThePathFromAboveIsWhereTheModelsDiffer) {
  DiagnosisFigures figures = example_figures();
  auto& x = figures.window.traces[0];
  auto& y = figures.window.traces[1];
  const auto path = [&] {
    const std::string html = page_as_read(example_diagnosis(), figures);
    const std::size_t at = html.find("Path from above");
    return html.substr(at, html.find("</svg>", at) - at);
  };
  const auto points = [](const std::string& svg, const std::string& style) {
    const std::size_t at = svg.find("<path class=\"" + style);
    const std::string line = svg.substr(at, svg.find("/>", at) - at);
    return std::count(line.begin(), line.end(), 'L') + std::count(line.begin(), line.end(), 'M');
  };
  x.before[190] += 0.5;  // with what was found it is as it was flown: two lines, and not three
  x.before[290] += 0.5, x.after[290] -= 0.5;
  std::string svg = path();
  EXPECT_THAT(svg, HasSubstr("Path from above, 14.0 to 15.0 s"));
  EXPECT_THAT(svg, AllOf(HasSubstr(">x [m]<"), HasSubstr(">y [m]<")));
  // each begins where the vehicle was
  for (const char* style : {"measured", "before", "after"}) EXPECT_EQ(points(svg, style), 100) << style;
  // the prediction breaks off: what follows is none
  y.before[110] += 2.0, y.after[110] -= 2.0;
  for (auto* trace : {&x, &y}) trace->before[150] = trace->after[150] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(path(), HasSubstr("Path from above, 13.0 to 13.5 s"));
  // of one model: where it is farthest from what was flown
  for (auto& trace : figures.window.traces) trace.after.clear();
  y.before[110] -= 2.0;
  x.before[190] -= 0.5, x.before[290] -= 0.5, x.before[390] += 0.5;
  svg = path();
  EXPECT_THAT(svg, AllOf(HasSubstr("Path from above, 15.0 to 16.0 s"), Not(HasSubstr("class=\"after\""))));
  // what was found changes nothing here, as a place of the accelerometer: the path was all of the stretch
  figures.window = example_figures().window;
  for (auto& trace : figures.window.traces) trace.before = trace.after;
  for (auto* line : {&figures.window.traces[1].before, &figures.window.traces[1].after}) (*line)[290] += 3.0;
  EXPECT_THAT(path(), HasSubstr("Path from above, 14.0 to 15.0 s"));
}

TEST(DiagnosisPage, SaysOnceOnWhatTheRestDepends) {
  Json diagnosis = example_diagnosis();
  diagnosis["alarms"] = {{{"kind", "omnibus"}, {"says", "what is left depends on position"}},
                         {{"kind", "omnibus"}, {"says", "what is left depends on velocity"}},
                         {{"kind", "omnibus"}, {"says", "what is left depends on time"}}};
  EXPECT_THAT(
      page_as_read(diagnosis, {}),
      HasSubstr("<li><strong>A pattern is left</strong>: what is left depends on position, velocity and time.</li>"));
}

TEST(TradeWords, EveryEffectThatADiagnosisNamesHasThem) {
  for (const EffectRow& row : effect_registry()) {
    if (!row.diagnosable) continue;
    EXPECT_TRUE(report::has_trade_words(std::string(row.name))) << row.name;
    // whatever the signs, and with numbers that are not there
    for (const double value : {0.1, -0.1}) {
      Json effect{{"effect", row.name}, {"parameters", Json::object()}};
      EXPECT_NE(report::headline_of(effect), "") << row.name;
      const auto made = row.make();
      ParameterNames names;
      made->visit(names);
      for (const std::string& name : names.found)
        effect["parameters"][name] = {{"value", value}, {"std", 0.01}, {"unit", "-"}};
      const std::string line = report::headline_of(effect);
      EXPECT_THAT(line, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf")), Not(HasSubstr("_")))) << row.name;
      EXPECT_NE(report::notice_of(effect), "") << row.name;
    }
  }
}

TEST(TradeWords, SayASignADirectionAndAReference) {
  Json mass{{"effect", "mass"}, {"parameters", {{"delta", {{"value", -0.0512}, {"std", 0.001}, {"unit", "-"}}}}}};
  EXPECT_EQ(report::headline_of(mass), "The vehicle weighs 5.1 % less than its model");
  mass["total"] = {{"delta", {{"value", 0.1}}}};
  EXPECT_EQ(report::headline_of(mass), "The vehicle weighs 5.1 % less than in the reference flights");
  const Json centre{{"effect", "center_of_mass"},
                    {"parameters",
                     {{"x", {{"value", -0.003}, {"std", 0.0001}, {"unit", "m"}}},
                      {"y", {{"value", 0.001}, {"std", 0.002}, {"unit", "m"}}},
                      {"z", {{"value", 0.02}, {"std", 0.001}, {"unit", "m"}}}}}};
  EXPECT_EQ(report::headline_of(centre),
            "The centre of mass sits 3.0 mm farther back and 20 mm higher than the model has it");
  EXPECT_THAT(report::notice_of(centre), HasSubstr("lasting trim"));
  Json high = centre;
  high["parameters"].erase("x");
  EXPECT_THAT(report::notice_of(high), HasSubstr("a point above its middle"));
  // the areas of its table, and no sum of theirs
  Json drag = {{"effect", "quadratic_drag"},
               {"parameters",
                {{"area_xy", {{"value", 0.0558}, {"std", 0.0035}, {"unit", "m^2"}}},
                 {"area_z", {{"value", 0.118}, {"std", 0.0066}, {"unit", "m^2"}}}}}};
  EXPECT_EQ(report::headline_of(drag),
            "The body's drag holds it back at speed (drag area 0.056 m² level and 0.12 m² in a climb)");
  drag["parameters"]["area_z"]["std"] = 0.1;
  EXPECT_THAT(report::headline_of(drag), HasSubstr("(drag area 0.056 m² level)"));
}

TEST(TradeWords, InHoverNumbersAreChangesAgainstNormalFlights) {
  const Json mass{{"effect", "mass"}, {"parameters", {{"delta", {{"value", 0.06}, {"std", 0.001}, {"unit", "-"}}}}}};
  Json diagnosis{{"not_identifiable", {{{"effect", "inertia"}, {"lack", "attitude_and_rate"}}}},
                 {"flights", {{{"file", "a.csv"}, {"role", "fit"}}}}};
  EXPECT_EQ(report::headline_of(mass, diagnosis), "The vehicle weighs 6.0 % more than in the flights taken as normal");
  diagnosis["flights"].push_back({{"file", "b.csv"}, {"role", "reference"}});
  EXPECT_EQ(report::headline_of(mass, diagnosis), "The vehicle weighs 6.0 % more than in the reference flights");
  // a gyroscope that is missing is no hover recording, and reference flights that showed this effect say so in the effect
  diagnosis["not_identifiable"][0]["lack"] = "body_rate";
  EXPECT_EQ(report::headline_of(mass, diagnosis), "The vehicle weighs 6.0 % more than its model");
}

TEST(TradeWords, AnUnnamedTermIsLikeSomethingThatIsKnown) {
  const auto like = [](const char* channel, const char* term, double coefficient) {
    return report::likeness({{"channel", channel}, {"term", term}, {"coefficient", coefficient}}, 10.0);
  };
  EXPECT_EQ(like("force_x", "vx_B", -0.3), "like rotor drag of 0.300 N s/m");
  EXPECT_EQ(like("force_z", "1", -0.8), "like 8.00 % more weight");
  EXPECT_EQ(like("force_y", "vy_B abs vy_B", -0.0049), "like a drag area of 0.00800 m²");
  EXPECT_EQ(like("torque_x", "1", 0.02), "like a centre of mass 2.00 mm aside");
  EXPECT_EQ(like("force_x", "vx_B", 0.3), "a push along its own motion, which no drag gives");
  EXPECT_EQ(like("torque_z", "vx_B vy_B", 0.3), "");
  // a name that only begins or ends like a place
  EXPECT_EQ(like("force_x", "speed", -0.0035), "a push that grows with speed, whichever way it flies");
  EXPECT_THAT(like("force_y", "px", 0.1), HasSubstr("depends on the place"));
  EXPECT_THAT(like("force_y", "vx_B pz", 0.1), HasSubstr("depends on the place"));
}

TEST(TradeWords, WhatWouldTellIsALoggerAFileOrAFlight) {
  using diagnosis::Lack;
  EXPECT_EQ(report::remedy_for(Lack::excitation, "fast level flight"), "fly: fast level flight");
  EXPECT_THAT(report::remedy_for(Lack::accelerometer), HasSubstr("sensor_combined"));
  EXPECT_THAT(report::remedy_for(Lack::vehicle_file), HasSubstr("vehicle.toml"));
  EXPECT_EQ(report::remedy_for(Lack::other), "");
}

TEST(DiagnosisPage, WhatWouldTellStandsBesideTheReason) {
  Json diagnosis = example_diagnosis();
  diagnosis["not_identifiable"] = {{{"effect", "slung_load"},
                                    {"why", "these flights do not show it (it shows in: √(g / length) (slow))"},
                                    {"lack", "excitation"},
                                    {"shows_in", "√(g / length) (slow)"}},
                                   // the words of a reason choose nothing
                                   {{"effect", "inertia"}, {"why", "no accelerometer, no torque and no command"}},
                                   {{"effect", "motor_lag"}, {"why", "because"}, {"lack", "torque"}}};
  const std::string page = page_as_read(diagnosis, {});
  EXPECT_THAT(page,
              HasSubstr("<td>these flights do not show it</td><td class=\"where\">fly: √(g / length) (slow)</td>"));
  EXPECT_THAT(page, HasSubstr("<td>no accelerometer, no torque and no command</td><td class=\"where\">–</td>"));
  EXPECT_THAT(page, HasSubstr("<td>because</td><td class=\"where\">log body rate and every motor"));
}

TEST(Words, ASentenceKeepsFilesAndKeys) {
  EXPECT_EQ(report::in_plain_words("force_x: fit_a.csv, battery_sag (rotor_drag) environment.ground_z_m"),
            "push forward or back: fit_a.csv, battery sag (rotor drag) environment.ground_z_m");
}

TEST(Svg, EqualScalesMakeACircleRound) {
  svg::Chart chart;
  chart.equal_scales = true;
  chart.series.push_back({"before", svg::Mark::dots, {-1, 1, 0, 0}, {0, 0, -1, 1}, {}, {}});
  const std::string drawn = svg::draw(chart);
  std::vector<double> x, y;
  for (std::size_t at = drawn.find("<circle"); at != std::string::npos; at = drawn.find("<circle", at + 1)) {
    x.push_back(std::stod(drawn.substr(drawn.find("cx=\"", at) + 4)));
    y.push_back(std::stod(drawn.substr(drawn.find("cy=\"", at) + 4)));
  }
  ASSERT_EQ(x.size(), 4u);
  EXPECT_NEAR(x[1] - x[0], y[2] - y[3], 0.21);
}

TEST(Svg, TicksAreRoundAndInside) {
  EXPECT_THAT(svg::ticks(0.0, 1.03, 5, false), testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.5, 1.0}));
  // of one tick alone nobody reads a size
  EXPECT_THAT(svg::ticks(-48.0, 36.0, 4, false),
              testing::Pointwise(testing::DoubleNear(1e-12), {-40.0, -20.0, 0.0, 20.0}));
  EXPECT_THAT(svg::ticks(0.0, 0.83, 4, false),
              testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.2, 0.4, 0.6, 0.8}));
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

}  // namespace diagnosis_page_test
}  // namespace gustlab
