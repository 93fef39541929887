// From flight logs to a sparse model of the residual force: samples, regression, choice of λ, errors.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/residual_model.hpp"
#include "identification/force_residual.hpp"
#include "identification/model_selection.hpp"

namespace gustlab {

// N in the world frame, named as the disturbance columns of a log
inline constexpr std::array<std::string_view, 3> residual_targets = {"fx", "fy", "fz"};

struct IdentifyOptions {
  std::string library = "paper";
  std::string optimizer = "sr3";
  std::vector<std::string> constraints;
  double nu = 1.0;
  Regularizer penalty = Regularizer::l0;
  int max_terms = 0;
  // absent: chosen by cross-validation
  std::optional<double> lambda;
  // absent: as PySINDy where λ is given (columns as they are; ridge 0.05; refit after stlsq only), and what suits a
  // choice among terms of different units where it is not (columns of equal length; no ridge; refit, but not after an
  // L2 penalty)
  std::optional<bool> normalize_columns, refit;
  std::optional<double> ridge, tolerance;
  std::optional<int> max_iterations;
};

struct Identification {
  std::vector<FeatureTerm> terms;
  std::string optimizer;
  OptimizerOptions regression;         // as used, λ included
  Fit fit;                             // coefficients: targets × terms, N per unit of the term
  std::optional<LambdaChoice> choice;  // when λ was chosen
  std::int64_t samples = 0;
  double condition_number = 0.0;             // of Θ
  double condition_number_normalized = 0.0;  // of Θ with columns of length one
  double error_fit = 0.0;                    // N, root mean square over samples and targets
  double error_holdout = 0.0;      // N, on flights not used, or on each fold by what the others find at this λ
  double force_rms = 0.0;          // N, of the residual force itself where it was fitted
  double force_rms_holdout = 0.0;  // N, where error_holdout was measured
  bool holdout_is_cross_validation = false;
  std::vector<std::string> notes;  // what a reader should know, in sentences

  ResidualModel model() const { return ResidualModel(terms, fit.coefficients); }
};

// `fit` and `holdout`: one entry per flight, each with its unbroken parts. With no held-out flight the error is
// cross-validated: over flights when there are at least 3, otherwise over five consecutive blocks of the samples.
Identification identify(std::span<const std::vector<ResidualSamples>> fit_flights,
                        std::span<const std::vector<ResidualSamples>> holdout_flights, const IdentifyOptions& options);

// {terms, targets, coefficients: [target][term], condition_number, error_fit, error_holdout, …} (FORMATS.md §6)
std::string to_json(const Identification& found);
// A table for people, as Markdown.
std::string to_markdown(const Identification& found);
// target, term, coefficient: one line for each that is not zero.
std::string to_csv(const Identification& found);
// An `[[effect]] type = "sindy_residual"` that any experiment can include.
std::string to_toml(const Identification& found, std::span<const std::string> flights);

}  // namespace gustlab
