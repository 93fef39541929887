#include "identification/identify.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "identification/constraints.hpp"
#include "identification/feature_library.hpp"
#include "identification/planted_flight.hpp"

namespace gustlab {
namespace identify_test {

using Eigen::MatrixXd;

MatrixXd planted_coefficients() {
  // terms: 1, theta, phi, T sin theta, T cos theta, T sin phi, T cos phi
  MatrixXd c = MatrixXd::Zero(3, 7);
  c(0, 0) = 0.4;
  c(0, 3) = -0.3;
  c(1, 2) = 0.9;
  c(1, 5) = 0.2;
  c(2, 0) = -0.5;
  c(2, 4) = 0.04;
  return c;
}

std::vector<std::vector<ResidualSamples>> flights(std::initializer_list<double> phases, AccelerationSource source) {
  const ResidualModel model(make_library("paper"), planted_coefficients());
  std::vector<std::vector<ResidualSamples>> out;
  for (double phase : phases) {
    const PlantedFlight flight =
        planted_flight([&](const FeatureInput& in) { return model.force_W_N(in); }, 4000, 0.002, phase);
    out.push_back(force_residual(flight.log, flight.vehicle, flight.known(), {.edge_s = 0.1}, source));
  }
  return out;
}

IdentifyOptions automatic(std::string_view optimizer) {
  IdentifyOptions options;
  options.optimizer = optimizer;
  return options;
}

TEST(Identify, FindsPlantedTermsWithExactSupportOnNoiseFreeLogs) {
  const MatrixXd truth = planted_coefficients();
  for (const OptimizerRow& row : optimizer_registry()) {
    for (AccelerationSource source : {AccelerationSource::accelerometer, AccelerationSource::velocity}) {
      const auto fit = flights({0.0, 1.0, 2.0}, source);
      const Identification found = identify(fit, flights({3.0}, source), automatic(row.name));
      EXPECT_TRUE(((found.fit.coefficients.array() != 0.0) == (truth.array() != 0.0)).all())
          << row.name << " lambda " << found.regression.lambda << '\n'
          << found.fit.coefficients;
      const double tolerance = source == AccelerationSource::accelerometer ? 1e-9 : 2e-3;
      EXPECT_LT((found.fit.coefficients - truth).cwiseAbs().maxCoeff(), tolerance) << row.name;
      EXPECT_LT(found.error_holdout, source == AccelerationSource::accelerometer ? 1e-9 : 1e-3);
      EXPECT_FALSE(found.holdout_is_cross_validation);
    }
  }
}

TEST(Identify, OneFlightIsCrossValidatedOverItsBlocks) {
  const auto fit = flights({0.0}, AccelerationSource::accelerometer);
  const Identification found = identify(fit, {}, automatic("stlsq"));
  EXPECT_TRUE(found.holdout_is_cross_validation);
  EXPECT_LT(found.error_holdout, 1e-9);
  EXPECT_GT(found.force_rms, 0.1);
}

TEST(Identify, WithAGivenLambdaTheSettingsArePysindys) {
  const auto fit = flights({0.0}, AccelerationSource::accelerometer);
  for (const auto& [name, refit] : {std::pair("stlsq", true), std::pair("sr3", false)}) {
    IdentifyOptions options = automatic(name);
    options.lambda = 0.01;
    const Identification found = identify(fit, {}, options);
    EXPECT_FALSE(found.choice.has_value());
    EXPECT_FALSE(found.regression.normalize_columns);
    EXPECT_EQ(found.regression.refit, refit);
    EXPECT_EQ(found.regression.ridge, 0.05);
    EXPECT_EQ(found.regression.lambda, 0.01);
  }
}

TEST(Identify, ConstraintsHoldInTheModel) {
  IdentifyOptions options = automatic("sr3");
  options.constraints = {"fx[T sin theta] + fy[T sin phi] = 0", "fz[1] = -0.7"};
  const Identification found = identify(flights({0.0, 1.0}, AccelerationSource::accelerometer), {}, options);
  EXPECT_NEAR(found.fit.coefficients(0, 3) + found.fit.coefficients(1, 5), 0.0, 1e-9);
  EXPECT_NEAR(found.fit.coefficients(2, 0), -0.7, 1e-9);
}

TEST(Identify, ExplainsThatTermsCannotBeToldApartNearHover) {
  std::vector<ResidualSamples> hover(1);
  for (int i = 0; i < 500; ++i) {
    FeatureInput in = planted_input(0.01 * i, 0.0);
    in.roll_rad *= 0.02;
    in.pitch_rad *= 0.02;
    in.thrust_N = 19.4 + 0.01 * (in.thrust_N - 19.4);
    hover[0].inputs.push_back(in);
  }
  hover[0].force_W_N = MatrixXd::Random(500, 3);
  const std::vector<std::vector<ResidualSamples>> flights = {hover};
  IdentifyOptions options;
  options.lambda = 1e-3;
  const Identification found = identify(flights, {}, options);
  EXPECT_GT(found.condition_number, 1e3);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_NE(found.notes[0].find("condition number"), std::string::npos);
  EXPECT_NE(found.notes[0].find("T cos theta / T cos phi"), std::string::npos);
  EXPECT_NE(to_markdown(found).find("note: "), std::string::npos);
}

TEST(Identify, SaysThatAWorldForceNeedsOneHeading) {
  auto fit = flights({0.0}, AccelerationSource::accelerometer);
  for (std::size_t i = 0; i < fit[0][0].inputs.size(); ++i) fit[0][0].inputs[i].yaw_rad = 1e-3 * static_cast<double>(i);
  const Identification found = identify(fit, {}, automatic("stlsq"));
  EXPECT_NE(to_markdown(found).find("heading"), std::string::npos);
}

TEST(Report, SaysHowManyTermsItDoesNotShow) {
  const auto fit = flights({0.0, 1.0}, AccelerationSource::accelerometer);
  IdentifyOptions options = automatic("stlsq");
  EXPECT_EQ(to_markdown(identify(fit, {}, options)).find("not shown"), std::string::npos);
  options.library = "paper+polynomial:2:vx,vy,vz";
  const Identification found = identify(fit, {}, options);
  const auto none = std::count_if(found.fit.coefficients.colwise().begin(), found.fit.coefficients.colwise().end(),
                                  [](const auto& column) { return column.isZero(0.0); });
  ASSERT_GT(none, 0);
  EXPECT_NE(to_markdown(found).find(fmt::format("{} of {} terms have no coefficient", none, found.terms.size())),
            std::string::npos);
}

TEST(Report, JsonHasTheKeysOfTheFormat) {
  const Identification found = identify(flights({0.0}, AccelerationSource::accelerometer), {}, automatic("stlsq"));
  const auto json = nlohmann::json::parse(to_json(found));
  EXPECT_EQ(json["terms"].size(), 7u);
  EXPECT_EQ(json["targets"], (std::vector<std::string>{"fx", "fy", "fz"}));
  ASSERT_EQ(json["coefficients"].size(), 3u);
  for (std::size_t t = 0; t < 3; ++t) {
    for (std::size_t j = 0; j < 7; ++j) {
      EXPECT_EQ(json["coefficients"][t][j].get<double>(),
                found.fit.coefficients(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(j)));
    }
  }
  for (const char* key : {"condition_number", "error_fit", "error_holdout"}) EXPECT_TRUE(json[key].is_number()) << key;
}

TEST(Report, TomlReadsBackAsTheSameEffect) {
  const Identification found = identify(flights({0.0}, AccelerationSource::accelerometer), {}, automatic("stlsq"));
  const std::vector<std::string> names = {"a.csv"};
  config::Table document = config::Table::parse(to_toml(found, names), "model.toml");
  const std::vector<EffectSpec> specs = config::read_effects(document);
  document.finish();
  ASSERT_EQ(specs.size(), 1u);
  EXPECT_EQ(specs[0].type, "sindy_residual");

  struct Reader final : Parameterized {
    ResidualModel model;
    void visit(ParameterVisitor& visitor) override { model.visit(visitor); }
  } reader;
  config::read_parameters(specs[0], reader);
  reader.model.prepare();
  const ResidualModel expected = found.model();
  EXPECT_EQ(reader.model.coefficients(), expected.coefficients());
  ASSERT_EQ(reader.model.terms().size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(reader.model.terms()[i].name(), expected.terms()[i].name());
}

TEST(Constraints, AreReadAsWritten) {
  const std::vector<FeatureTerm> terms = make_library("paper");
  const std::vector<std::string> texts = {"fx[T sin theta]+fy[T*sin(phi)]=0", " - 2*fz[1] + 0.5 fz [ phi ] = -1.5"};
  const LinearConstraints c = parse_constraints(texts, terms, residual_targets);
  MatrixXd expected = MatrixXd::Zero(2, 21);
  expected(0, 3) = expected(0, 7 + 5) = 1.0;
  expected(1, 14) = -2.0;
  expected(1, 16) = 0.5;
  EXPECT_EQ(c.C, expected);
  EXPECT_EQ(c.d, Eigen::Vector2d(0.0, -1.5));
}

TEST(Constraints, WhatIsNoneIsRefused) {
  const std::vector<FeatureTerm> terms = make_library("paper");
  for (const char* text : {"", "= 0", "fx[1]", "fx[1] = ", "fx[1] = x", "fx[1] fy[1] = 0", "tx[1] = 0", "fx[vx] = 0",
                           "fx[1 = 0", "fx = 0", "fx[1] = 0 = 0", "fx[1] + = 0", "fx[1] = 1e999"}) {
    const std::vector<std::string> texts = {text};
    EXPECT_THROW(parse_constraints(texts, terms, residual_targets), ConfigError) << text;
  }
}

}  // namespace identify_test
}  // namespace gustlab
