#include "report/score.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace score_test {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

// a set of trials on disk, removed at the end
class ScoreTest : public testing::Test {
 protected:
  ScoreTest() : folder_(std::filesystem::path(testing::TempDir()) / "gustlab_score_test") {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~ScoreTest() override { std::filesystem::remove_all(folder_); }

  static Json hidden(const std::string& effect, double strength, Json parameters = Json::object()) {
    return {{"effect", effect}, {"parameters", parameters}, {"strength_over_limit", strength}};
  }
  static Json found(const std::string& effect, double confidence = 0.9, Json parameters = Json::object(),
                    Json alternatives = Json::array()) {
    return {{"effect", effect}, {"confidence", confidence}, {"parameters", parameters}, {"class", alternatives}};
  }
  static Json value(double v, double std) { return {{"value", v}, {"std", std}, {"unit", "m"}}; }

  // diagnosis null: the program failed on this trial
  void add(const std::string& kind, Json effects, Json named, Json more_answer = Json::object(),
           Json more = Json::object()) {
    const std::string trial = "trial" + std::to_string(++count_);
    Json answer{{"trial", trial}, {"kind", kind}, {"effects", effects}};
    answer.update(more_answer);
    std::ofstream(folder_ / "answers.jsonl", std::ios::app) << answer.dump() << "\n";
    if (named.is_null()) return;
    std::filesystem::create_directories(folder_ / trial / "diagnosis");
    Json diagnosis{{"verdict", named.empty() ? "consistent" : "explained"}, {"effects", named}};
    diagnosis.update(more);
    std::ofstream(folder_ / trial / "diagnosis" / "diagnosis.json") << diagnosis.dump();
  }
  Json score() const { return score_trials({{(folder_ / "answers.jsonl").string(), folder_.string()}}); }
  static std::string rate(const Json& entry) {
    return std::to_string(entry.at("k").get<int>()) + "/" + std::to_string(entry.at("n").get<int>());
  }
  std::string headline(const char* label) const { return rate(score().at("headline").at(label)); }

  std::filesystem::path folder_;
  int count_ = 0;
};

TEST_F(ScoreTest, MissingDiagnosisIsAFailureEverywhere) {
  add("clean", Json::array(), Json::array());
  add("clean", Json::array(), nullptr);
  add("single", {hidden("mass", 3)}, nullptr);
  add("outside", Json::array(), nullptr);
  EXPECT_EQ(headline("nothing concealed: no name"), "1/2");
  EXPECT_EQ(headline("one effect: exact"), "0/1");
  EXPECT_EQ(headline("outside the catalogue: no name"), "0/1");
  EXPECT_EQ(score().at("without_diagnosis"), 3);
  EXPECT_EQ(score().at("not_right").size(), 3u);
}

TEST_F(ScoreTest, UnreadableDiagnosisCountsAsMissing) {
  add("clean", Json::array(), Json::array());
  for (const auto& [text, says] : {std::pair{"{\"verdict\": 3", ":1:14: is no diagnosis (the JSON is not complete); "},
                                   {"{\"verdict\": \"explained\",\n \"effects\": [{\"class\": []}]}",
                                    ":2:14: is no diagnosis (there is no \"effect\"); "}}) {
    std::ofstream(folder_ / "trial1" / "diagnosis" / "diagnosis.json") << text;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(headline("nothing concealed: no name"), "0/1");
    EXPECT_THAT(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), HasSubstr(says));
  }
}

TEST_F(ScoreTest, ARotorThatNoVehicleHasIsAnUnreadableDiagnosisAndAWrongAnswer) {
  for (const double rotor : {1e300, -1e10, 9.0}) {
    add("single", {hidden("rotor_loss", 2, {{"rotor", 3}})}, {found("rotor_loss", 0.9, {{"rotor", rotor}})});
    add("single", {hidden("rotor_loss", 2, {{"rotor", 3}})},
        {found("rotor_loss", 0.9, {{"rotor", {{"value", rotor}}}})});
  }
  add("single", {hidden("rotor_loss", 2, {{"rotor", 3}})}, {found("rotor_loss#99999999999")});
  EXPECT_EQ(headline("one effect: exact"), "0/7");
  EXPECT_EQ(score().at("without_diagnosis"), 6);
  add("single", {hidden("rotor_loss", 2, {{"rotor", 1e300}})}, Json::array());
  EXPECT_THAT([&] { score(); }, testing::ThrowsMessage<DataError>(
                                    HasSubstr("answers.jsonl:8:91: not an answer (there is no rotor 1e+300)")));
}

TEST_F(ScoreTest, AClassHoldsTheTruthButTheNameItselfIsCountedApart) {
  add("single", {hidden("thrust_scale", 2)}, {found("mass", 0.5, Json::object(), {"mass", "thrust_scale"})});
  add("single", {hidden("thrust_scale", 2)}, {found("thrust_scale", 0.5, Json::object(), {"thrust_scale"})});
  add("single", {hidden("thrust_scale", 2)}, {found("mass", 0.5, Json::object(), {"mass"})});
  EXPECT_EQ(headline("one effect: exact"), "2/3");
  EXPECT_EQ(headline("one effect: exact, the name itself"), "1/3");
}

TEST_F(ScoreTest, TheRotorIsPartOfTheName) {
  const Json truth = hidden("rotor_loss", 2, {{"rotor", 3}, {"loss", 0.1}});
  add("single", {truth}, {found("rotor_loss", 0.9, {{"rotor", {{"value", 3}}}})});
  add("single", {truth}, {found("rotor_loss", 0.9, {{"rotor", {{"value", 1}}}})});
  add("single", {truth}, {found("center_of_mass", 0.9, Json::object(), {"center_of_mass", "rotor_loss#3"})});
  add("single", {truth}, {found("center_of_mass", 0.9, Json::object(), {"center_of_mass", "rotor_loss#2"})});
  EXPECT_EQ(headline("one effect: exact"), "2/4");
}

TEST_F(ScoreTest, PairsAreMatchedSoThatMostTruthsHaveAName) {
  // the first name fits both truths, the second only one of them
  add("pair", {hidden("mass", 2), hidden("inertia", 4)},
      {found("mass", 0.9, Json::object(), {"mass", "inertia"}),
       found("constant_force", 0.9, Json::object(), {"constant_force", "mass"})});
  add("pair", {hidden("mass", 2), hidden("inertia", 4)}, {found("mass"), found("inertia"), found("gust")});
  add("pair", {hidden("mass", 2), hidden("inertia", 4)}, {found("inertia")});
  add("pair", {hidden("mass", 0.5), hidden("inertia", 4)}, {found("inertia")});
  EXPECT_EQ(headline("two effects: both among the names"), "2/3");
  EXPECT_EQ(headline("two effects: exact"), "1/3");
  EXPECT_EQ(headline("two effects, one below its limit: no wrong name"), "1/1");
}

TEST_F(ScoreTest, BelowTheLimitSilenceIsRightAndAWrongNameIsNot) {
  add("single", {hidden("mass", 0.4)}, Json::array());
  add("single", {hidden("mass", 0.4)}, {found("mass")});
  add("single", {hidden("mass", 0.4)}, {found("gust")});
  EXPECT_EQ(headline("one effect below its limit: no wrong name"), "2/3");
  EXPECT_EQ(headline("one effect: exact"), "0/0");
  EXPECT_EQ(score().at("not_right").size(), 1u);
}

TEST_F(ScoreTest, PrecisionCountsFalseDiscoveriesOfCleanTrials) {
  add("clean", Json::array(), {found("mass")});
  add("single", {hidden("mass", 2)}, {found("mass")});
  add("single", {hidden("inertia", 2)}, {found("mass")});
  const Json table = score().at("effects");
  ASSERT_EQ(table.size(), 2u);
  EXPECT_EQ(table[0].at("effect"), "inertia");
  EXPECT_EQ(rate(table[0].at("recall")), "0/1");
  EXPECT_EQ(rate(table[1].at("precision")), "1/3");
  EXPECT_EQ(rate(table[1].at("recall")), "1/1");
  const Json rows = score().at("confusion").at("concealed");
  EXPECT_EQ(rows.at("(clean)").at("mass"), 1);
  EXPECT_EQ(rows.at("inertia").at("mass"), 1);
  EXPECT_EQ(rows.at("mass").at("mass"), 1);
}

TEST_F(ScoreTest, IntervalsCoverAndErrorsAreRelativeToTheWholeVector) {
  const Json truth = hidden("center_of_mass", 5, {{"x", 0.003}, {"y", 0.004}});
  add("single", {truth}, {found("center_of_mass", 0.9, {{"x", value(0.0035, 0.0003)}, {"y", value(0.0045, 0.0002)}})});
  const Json parameters = score().at("parameters");
  EXPECT_EQ(rate(parameters.at("coverage")), "1/2");
  EXPECT_NEAR(parameters.at("each")[0].at("median_relative_error").get<double>(), 0.1, 1e-12);
  EXPECT_NEAR(parameters.at("each")[1].at("median_error").get<double>(), 5e-4, 1e-15);
}

TEST_F(ScoreTest, ValuesPerFlightAreComparedFlightByFlight) {
  Json truth = hidden("steady_wind", 5, {{"x", 0.0}});
  truth["per_flight"] = {{"fit_1.csv", {{"x", 1.0}}}, {"fit_2.csv", {{"x", -1.0}}}, {"holdout_1.csv", {{"x", 2.0}}}};
  Json name = found("steady_wind", 0.9, {{"x", value(0.0, 0.1)}});
  name["per_flight"] = {{"fit_1.csv", {{"x", value(1.05, 0.1)}}}, {"fit_2.csv", {{"x", value(1.0, 0.1)}}}};
  add("single", {truth}, {name});
  EXPECT_EQ(rate(score().at("parameters").at("coverage")), "1/2");
}

TEST_F(ScoreTest, CalibrationErrorIsTheMeanGapBetweenSaidAndRight) {
  // four names said at 0.95, three of them right; one at 0.55, wrong
  for (int i = 0; i < 3; ++i) add("single", {hidden("mass", 2)}, {found("mass", 0.95)});
  add("single", {hidden("mass", 2)}, {found("gust", 0.95)});
  add("single", {hidden("mass", 2)}, {found("gust", 0.55)});
  const Json reliability = score().at("reliability");
  EXPECT_EQ(reliability.at("findings"), 5);
  EXPECT_NEAR(reliability.at("expected_calibration_error").get<double>(), (4 * 0.2 + 0.55) / 5, 1e-12);
}

TEST_F(ScoreTest, WhatIsSuspectedCountsAsSaidAndNotAsNamed) {
  const auto suspects = [](const char* effect) { return Json{{"suspected", {found(effect, 0.75)}}}; };
  add("single", {hidden("mass", 2)}, Json::array(), Json::object(), suspects("mass"));
  add("single", {hidden("mass", 2)}, Json::array(), Json::object(), suspects("gust"));
  add("single", {hidden("mass", 0.5)}, Json::array(), Json::object(), suspects("mass"));  // need not be named
  add("single", {hidden("mass", 2)}, {found("mass"), found("gust")});
  EXPECT_EQ(headline("effects without a name: suspected"), "1/2");
  EXPECT_EQ(headline("names of what is not there"), "1/2");
  EXPECT_EQ(headline("one effect: exact"), "0/3");
  const Json reliability = score().at("reliability");
  EXPECT_EQ(reliability.at("findings"), 5);
  EXPECT_EQ(rate(reliability.at("bins")[0].at("right")), "2/3");
}

TEST_F(ScoreTest, PowerIsBinnedByStrength) {
  add("single", {hidden("mass", 2.9999999999)}, {found("mass")});
  add("single", {hidden("mass", 9)}, Json::array());
  const Json power = score().at("power");
  EXPECT_EQ(rate(power.at("effects").at("mass")[3]), "1/1");
  EXPECT_EQ(rate(power.at("effects").at("mass")[5]), "0/1");
  EXPECT_EQ(rate(power.at("single_exact")[3]), "1/1");
}

TEST_F(ScoreTest, ClosureIsTheShareOfWhatCouldBeRecovered) {
  const Json fit{{"horizon_s", {0.1, 0.5}},
                 {"position_m", {{"before", {0.010, 0.100}}, {"after", {0.010, 0.030}}, {"noise", {0.0099, 0.020}}}}};
  add("single", {hidden("mass", 2)}, {found("mass")}, Json::object(), {{"fit", fit}});
  add("single", {hidden("mass", 2)}, {found("mass")}, {{"oracle", {{"position_m", {{"after", {0.001, 0.015}}}}}}},
      {{"fit", fit}});
  const Json each = score().at("closure").at("each");
  // at 0.1 s nothing could be recovered
  ASSERT_EQ(each.size(), 1u);
  EXPECT_EQ(each[0].at("trials"), 2);
  // floors: 0.020, and with the oracle's 0.015 together 0.025
  EXPECT_NEAR(each[0].at("median").get<double>(), 0.5 * (0.070 / 0.080 + 0.070 / 0.075), 1e-12);
}

TEST_F(ScoreTest, OutsideTheCatalogueSilenceIsRightAndTheChannelCounts) {
  const Json mismatch{
      {"mismatch",
       {{{"channel", "force_x"}, {"significant", true}}, {{"channel", "torque_z"}, {"significant", false}}}}};
  const auto stranger = [](double strength, Json channels) -> Json {
    return {{"outside", {{"name", "fan_jet"}, {"strength_over_limit", strength}, {"channels", channels}}}};
  };
  add("outside", Json::array(), Json::array(), stranger(3.0, {"force_x", "force_y"}), mismatch);
  add("outside", Json::array(), {found("mass")}, stranger(3.0, {"torque_z"}), mismatch);
  add("outside", Json::array(), Json::array(), stranger(0.2, {"force_z"}), mismatch);
  EXPECT_EQ(headline("outside the catalogue: no name"), "2/3");
  EXPECT_EQ(headline("outside the catalogue, visible: channel located"), "1/2");
  EXPECT_EQ(headline("outside the catalogue, visible: channels said that are right"), "1/2");
  EXPECT_THAT(score_markdown(score()), HasSubstr("fan_jet x3"));
}

TEST_F(ScoreTest, MarkdownNamesWhatIsNotRight) {
  add("single", {hidden("rotor_loss", 2, {{"rotor", 3}})},
      {found("mass", 0.71, Json::object(), {"mass", "thrust_scale"})});
  const std::string text = score_markdown(score());
  EXPECT_THAT(text, HasSubstr("rotor_loss#3 x2"));
  EXPECT_THAT(text, HasSubstr("mass 0.71~thrust_scale"));
}

TEST_F(ScoreTest, AnswersThatAreNoneAreRefusedWithTheirLine) {
  std::ofstream(folder_ / "answers.jsonl") << "\n{\"trial\": \"t\"}\n";
  try {
    score();
    FAIL() << "accepted";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("answers.jsonl:2:1: not an answer"));
  }
  std::filesystem::remove(folder_ / "answers.jsonl");
  EXPECT_THROW(score(), DataError);
}

// GIVEN answers with a mistake in the second line WHEN scored THEN the message has its place, in our words
TEST_F(ScoreTest, AnswersSayWhereTheyAreWrong) {
  const std::string mass = R"({"effect": "mass", "parameters": {"delta": 0.1}})";
  for (const auto& [line, says] : std::vector<std::pair<std::string, std::string>>{
           {R"({"trial": "t", "kind": "singel", "effects": []})",
            ":24: not an answer (\"singel\" is no kind of trial); use one of clean, scatter, single, pair, many, "
            "outside, nothing; did you mean \"single\"?"},
           {R"({"trial": "t", "effects": [{"effect": "masss"}]})", ":39: not an answer (\"masss\" is no effect); "},
           {R"({"trial": "../t", "effects": []})", ":11: not an answer (\"../t\" is no folder below "},
           {R"({"trial": "a/../..", "effects": []})", ":11: not an answer ("},
           {R"({"trial": ".", "effects": []})", ":11: not an answer ("},
           {R"({"trial": "", "effects": []})", ":11: not an answer ("},
           {R"({"trial": "/tmp", "effects": []})", ":11: not an answer ("},
           {R"({"trial": "t", "effects": [)" + mass +
                R"(, {"effect": "rotor_drag", "parameters": {"at_hover": "a"}}]})",
            ":130: not an answer (expected a number); "},
           {R"({"trial": "t", "effects": [{"effect": "mass", "per_flight": {"fit_1.csv": {"x": null}}}]})",
            ":81: not an answer (expected a number); "},
           {R"({"trial": "t", "effects": [{}]})", ":28: not an answer (there is no \"effect\"); "},
           {R"({"trial": "t", "effects": 3})", ":27: not an answer (expected an array); "},
           {R"({"trial": "t", "effects": [1e999]})", ":28: not an answer (\"1e999\" is no value of JSON); "},
           {R"({"trial": "t", "effects": [],})", ":30: not an answer (expected a key in quotation marks); "},
           {R"({"trial": "t")", ":14: not an answer (the JSON is not complete); "},
           {R"({"trial": "t)", ":11: not an answer (a quotation mark is not closed); "},
           {R"({"trial": "t"} {})", ":16: not an answer (the JSON ended before this); "},
           {std::string("{\"trial\": 1\0 2}", 14), ":11: not an answer (\"1\\x00\" is no value of JSON); "},
           {R"(name = "x")", ":1: not an answer (\"name\" is no value of JSON); "}}) {
    std::ofstream(folder_ / "answers.jsonl") << "\n" << line << "\n";
    EXPECT_THAT([&] { score(); }, testing::ThrowsMessage<DataError>(testing::AllOf(
                                      HasSubstr("answers.jsonl:2" + says), testing::Not(HasSubstr("json.exception")))))
        << line;
  }
}

TEST_F(ScoreTest, ATrialThatStandsTwiceIsRefused) {
  const std::string answers = (folder_ / "answers.jsonl").string(), folder = folder_.string();
  const auto stands_twice = [](const char* place) {
    return testing::ThrowsMessage<DataError>(
        testing::AllOf(HasSubstr(std::string("answers.jsonl:") + place + ": trial \"trial1\" stands twice (first at "),
                       HasSubstr("answers.jsonl:1:10); leave one out")));
  };
  add("clean", Json::array(), Json::array());
  EXPECT_THAT([&] { score_trials({{answers, folder}, {answers, folder + "/."}}); }, stands_twice("1:10"));
  // of another folder it is another one
  std::filesystem::create_directories(folder_ / "other");
  EXPECT_EQ(score_trials({{answers, folder}, {answers, folder + "/other"}}).at("trials"), 2);
  count_ = 0;
  add("clean", Json::array(), Json::array());
  EXPECT_THAT([&] { score(); }, stands_twice("2:10"));
}

// other simulators say "nothing", and conceal physics that no effect is called by
TEST_F(ScoreTest, ForeignAnswersAreRead) {
  add("nothing", Json::array(), Json::array());
  add("outside", {{{"effect", "slosh"}, {"rotor", nullptr}, {"parameters", {{"share", 0.1}, {"axis", "x"}}}}},
      Json::array());
  EXPECT_EQ(headline("nothing concealed: no name"), "1/1");
  EXPECT_EQ(headline("outside the catalogue: no name"), "1/1");
}

TEST_F(ScoreTest, WithoutANameNothingIsSaidOfConfidence) {
  add("clean", Json::array(), Json::array());
  EXPECT_THAT(score_markdown(score()), testing::AllOf(HasSubstr("how far to trust a confidence cannot be told"),
                                                      testing::Not(HasSubstr("Brier score"))));
}

}  // namespace score_test
}  // namespace gustlab
