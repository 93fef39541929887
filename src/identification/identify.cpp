#include "identification/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gustlab/errors.hpp"
#include "identification/constraints.hpp"
#include "identification/feature_library.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index block_folds = 5;
// from here on single coefficients of a least-squares fit say little
constexpr double ill_conditioned = 100.0;

// Θ and the target of all parts of a flight, stacked
struct Matrices {
  MatrixXd theta, target;
  RegressionData rows(Index first, Index count) const {
    return RegressionData(theta.middleRows(first, count), target.middleRows(first, count));
  }
};

Matrices stack(std::span<const FeatureTerm> terms, std::span<const std::vector<ResidualSamples>> flights) {
  Index rows = 0, row = 0;
  for (const auto& flight : flights) {
    for (const ResidualSamples& part : flight) rows += part.force_W_N.rows();
  }
  Matrices out{MatrixXd(rows, static_cast<Index>(terms.size())), MatrixXd(rows, 3)};
  for (const auto& flight : flights) {
    for (const ResidualSamples& part : flight) {
      out.theta.middleRows(row, part.force_W_N.rows()) = feature_matrix(terms, part.inputs);
      out.target.middleRows(row, part.force_W_N.rows()) = part.force_W_N;
      row += part.force_W_N.rows();
    }
  }
  return out;
}

// whole flights, or long blocks of what there is
std::vector<RegressionData> make_folds(std::span<const FeatureTerm> terms,
                                       std::span<const std::vector<ResidualSamples>> flights) {
  std::vector<RegressionData> folds;
  if (flights.size() >= 3) {
    for (std::size_t i = 0; i < flights.size(); ++i) {
      const Matrices flight = stack(terms, flights.subspan(i, 1));
      folds.push_back(flight.rows(0, flight.theta.rows()));
    }
    return folds;
  }
  const Matrices all = stack(terms, flights);
  const Index rows = all.theta.rows();
  if (rows < block_folds)
    throw DataError(
        fmt::format("only {} samples are left (at least {} are needed); give longer logs", rows, block_folds));
  for (Index k = 0; k < block_folds; ++k) {
    const Index first = rows * k / block_folds;
    folds.push_back(all.rows(first, rows * (k + 1) / block_folds - first));
  }
  return folds;
}

// pairs of columns that are nearly the same direction: cosine of their angle
std::vector<std::string> alike(const RegressionData& data, std::span<const FeatureTerm> terms) {
  const MatrixXd unit = MatrixXd(data.theta_factor()) * data.column_norms().cwiseInverse().asDiagonal();
  const MatrixXd cosine = unit.transpose() * unit;
  std::vector<std::string> pairs;
  for (Index i = 0; i < cosine.rows(); ++i) {
    for (Index j = 0; j < i; ++j) {
      if (std::abs(cosine(i, j)) > 0.995) {
        pairs.push_back(fmt::format("{} / {} ({:.5f})", terms[static_cast<std::size_t>(j)].name(),
                                    terms[static_cast<std::size_t>(i)].name(), cosine(i, j)));
      }
    }
  }
  return pairs;
}

// largest less smallest yaw of all samples
double yaw_range_rad(std::span<const std::vector<ResidualSamples>> flights) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const auto& flight : flights) {
    for (const ResidualSamples& part : flight) {
      for (const FeatureInput& input : part.inputs) {
        least = std::min(least, input.yaw_rad);
        most = std::max(most, input.yaw_rad);
      }
    }
  }
  return most - least;
}

void add_notes(const RegressionData& data, double yaw_range_rad, Identification& found) {
  std::vector<std::string> absent;
  for (Index j = 0; j < data.terms(); ++j) {
    if (data.theta_factor().col(j).isZero(0.0)) absent.push_back(found.terms[static_cast<std::size_t>(j)].name());
  }
  if (!absent.empty()) {
    found.notes.push_back(
        fmt::format("Zero throughout these flights, so nothing can be said of: {}.", fmt::join(absent, ", ")));
  }
  if (found.condition_number_normalized > ill_conditioned) {
    const std::vector<std::string> pairs = alike(data, found.terms);
    std::string note = fmt::format(
        "The terms can hardly be told apart on these flights (condition number {:.3g}, with columns of equal length "
        "{:.3g}): "
        "single coefficients are uncertain, only their sum is well determined.",
        found.condition_number, found.condition_number_normalized);
    if (!pairs.empty()) note += fmt::format(" Nearly the same columns (cosine): {}.", fmt::join(pairs, ", "));
    const bool thrust_terms = std::any_of(found.terms.begin(), found.terms.end(),
                                          [](const FeatureTerm& t) { return t.name() == "T cos theta"; });
    if (thrust_terms) {
      note +=
          " Near hover T cos theta and T cos phi are both the thrust, the thrust is the weight and so the constant 1, "
          "and "
          "T sin theta is the weight times theta: larger tilts and changes of thrust, or fewer terms, separate them.";
    }
    found.notes.push_back(note);
  }
  const bool tilt_terms = std::any_of(found.terms.begin(), found.terms.end(), [](const FeatureTerm& t) {
    return t.name() == "theta" || t.name() == "phi" || t.name() == "T sin theta" || t.name() == "T sin phi";
  });
  if (tilt_terms && yaw_range_rad > 0.35) {
    found.notes.push_back(
        fmt::format("The heading changes by {:.2f} rad: the force is in the world frame but pitch and roll are about "
                    "the heading, so that terms "
                    "of tilt can stand for a world force at one heading only.",
                    yaw_range_rad));
  }
  if (!found.fit.converged && !found.regression.refit) {
    found.notes.push_back(fmt::format("{} did not converge in {} iterations: raise nu or the number of iterations.",
                                      found.optimizer, found.fit.iterations));
  }
  if ((found.fit.coefficients.array() == 0.0).all()) {
    found.notes.push_back("No term earns its place: the residual force is not predictable from these terms.");
  } else if (found.error_holdout > 0.95 * found.force_rms_holdout) {
    found.notes.push_back(fmt::format(
        "On data not used the model explains almost nothing of the residual force ({:.3g} of {:.3g} N is left).",
        found.error_holdout, found.force_rms_holdout));
  }
}

// every choice made
OptimizerOptions resolve(const IdentifyOptions& options, const OptimizerRow& optimizer,
                         std::span<const FeatureTerm> terms) {
  const bool given = options.lambda.has_value();
  OptimizerOptions out;
  out.lambda = options.lambda.value_or(0.0);
  out.nu = options.nu;
  out.penalty = options.penalty;
  out.max_terms = options.max_terms;
  out.normalize_columns = options.normalize_columns.value_or(!given);
  const bool shrinks_only = optimizer.takes_penalty && options.penalty == Regularizer::l2;
  out.refit = options.refit.value_or(given ? optimizer.refits_by_default : !shrinks_only);
  out.ridge = options.ridge.value_or(given ? 0.05 : 0.0);
  // a choice that is refitted needs the support alone
  const bool support_only = !given && out.refit;
  out.tolerance = options.tolerance.value_or(support_only ? 1e-6 : 1e-10);
  out.max_iterations = options.max_iterations.value_or(support_only ? 1000 : 100000);
  out.constraints = parse_constraints(options.constraints, terms, residual_targets);
  return out;
}

}  // namespace

Identification identify(std::span<const std::vector<ResidualSamples>> fit_flights,
                        std::span<const std::vector<ResidualSamples>> holdout_flights, const IdentifyOptions& options) {
  Identification found;
  found.terms = make_library(options.library);
  found.optimizer = options.optimizer;
  const OptimizerRow& optimizer = find_optimizer(options.optimizer);
  found.regression = resolve(options, optimizer, found.terms);

  const std::vector<RegressionData> folds = make_folds(found.terms, fit_flights);
  const RegressionData data = RegressionData::merge(folds);
  if (!options.lambda) {
    found.choice = choose_lambda(optimizer, folds, found.regression);
    found.regression.lambda = found.choice->path[found.choice->chosen].lambda;
  }
  found.fit = fit(optimizer, data, found.regression);

  found.samples = data.samples();
  found.condition_number = data.condition_number();
  found.condition_number_normalized = data.with_scaled_columns(data.column_norms().cwiseInverse()).condition_number();
  found.force_rms = rms_error(data, MatrixXd::Zero(data.targets(), data.terms()));
  found.error_fit = rms_error(data, found.fit.coefficients);
  found.holdout_is_cross_validation = holdout_flights.empty();
  if (holdout_flights.empty()) {
    found.error_holdout = cross_validated_rms(optimizer, folds, found.regression);
    found.force_rms_holdout = found.force_rms;
  } else {
    const Matrices holdout = stack(found.terms, holdout_flights);
    const RegressionData unseen = holdout.rows(0, holdout.theta.rows());
    found.error_holdout = rms_error(unseen, found.fit.coefficients);
    found.force_rms_holdout = rms_error(unseen, MatrixXd::Zero(unseen.targets(), unseen.terms()));
  }
  add_notes(data, yaw_range_rad(fit_flights), found);
  return found;
}

}  // namespace gustlab
