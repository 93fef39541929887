#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "identification/identify.hpp"

namespace gustlab {
namespace {

using config::shortest;

std::string markdown_row(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

// libraries longer than this show their active terms only
constexpr std::size_t most_rows = 12;

// how the model was found, in one line
std::string settings(const Identification& found) {
  std::string out = fmt::format("{}, lambda {:.6g}", found.optimizer, found.regression.lambda);
  if (found.optimizer == "sr3") {
    const char* penalty = found.regression.penalty == Regularizer::l0   ? "L0"
                          : found.regression.penalty == Regularizer::l1 ? "L1"
                                                                        : "L2";
    out += fmt::format(", {}, nu {:.6g}", penalty, found.regression.nu);
  }
  if (found.choice) out += ", lambda chosen by cross-validation";
  if (found.regression.normalize_columns) out += ", columns of equal length";
  if (found.regression.refit) out += ", refitted on its terms";
  return out;
}

}  // namespace

std::string to_json(const Identification& found) {
  nlohmann::ordered_json out;
  for (const FeatureTerm& term : found.terms) out["terms"].push_back(term.name());
  out["targets"] = residual_targets;
  out["unit"] = "N";
  for (Eigen::Index t = 0; t < found.fit.coefficients.rows(); ++t) {
    const Eigen::VectorXd row = found.fit.coefficients.row(t);
    out["coefficients"].push_back(std::vector<double>(row.begin(), row.end()));
  }
  out["condition_number"] = found.condition_number;
  out["condition_number_normalized"] = found.condition_number_normalized;
  out["error_fit"] = found.error_fit;
  out["error_holdout"] = found.error_holdout;
  out["holdout"] = found.holdout_is_cross_validation ? "cross_validation" : "flights";
  out["force_rms"] = found.force_rms;
  out["force_rms_holdout"] = found.force_rms_holdout;
  out["samples"] = found.samples;
  out["optimizer"] = found.optimizer;
  out["lambda"] = found.regression.lambda;
  out["lambda_chosen"] = found.choice.has_value();
  out["iterations"] = found.fit.iterations;
  out["converged"] = found.fit.converged;
  out["notes"] = found.notes;
  return config::json_text(out, 2) + "\n";
}

std::string to_markdown(const Identification& found) {
  std::string out =
      fmt::format("Residual force, N in the world frame ({}; {} samples)\n\n", settings(found), found.samples);
  std::vector<std::string> head = {"term"}, rule = {"---"};
  for (std::string_view target : residual_targets) {
    head.emplace_back(target);
    rule.emplace_back("---:");
  }
  out += markdown_row(head) + markdown_row(rule);
  int left_out = 0;
  for (std::size_t j = 0; j < found.terms.size(); ++j) {
    const bool active = !found.fit.coefficients.col(static_cast<Eigen::Index>(j)).isZero(0.0);
    if (!active && found.terms.size() > most_rows) {
      ++left_out;
      continue;
    }
    std::vector<std::string> cells = {found.terms[j].name()};
    for (Eigen::Index t = 0; t < found.fit.coefficients.rows(); ++t) {
      const double value = found.fit.coefficients(t, static_cast<Eigen::Index>(j));
      cells.push_back(value == 0.0 ? "" : fmt::format("{:.6g}", value));
    }
    out += markdown_row(cells);
  }
  if (left_out > 0)
    out += fmt::format("\n{} of {} terms have no coefficient and are not shown\n", left_out, found.terms.size());
  out += fmt::format(
      "\nresidual force, rms per axis: {:.4g} N, of which the model leaves {:.4g} N where it was fitted; "
      "{} {:.4g} N, of which {:.4g} N are left; condition number {:.4g}, with columns of equal length {:.4g}\n",
      found.force_rms, found.error_fit,
      found.holdout_is_cross_validation ? "cross-validated, each fold by what the others find at this lambda,"
                                        : "on the held-out flights",
      found.force_rms_holdout, found.error_holdout, found.condition_number, found.condition_number_normalized);
  for (const std::string& note : found.notes) out += "\nnote: " + note + "\n";
  return out;
}

std::string to_csv(const Identification& found) {
  std::string out = "target,term,coefficient\n";
  for (std::size_t t = 0; t < residual_targets.size(); ++t) {
    for (std::size_t j = 0; j < found.terms.size(); ++j) {
      const double value = found.fit.coefficients(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(j));
      if (value != 0.0) out += fmt::format("{},{},{}\n", residual_targets[t], found.terms[j].name(), shortest(value));
    }
  }
  return out;
}

std::string to_toml(const Identification& found, std::span<const std::string> flights) {
  std::string names, terms;
  std::array<std::string, 3> forces;
  for (const std::string& flight : flights) names += (names.empty() ? "" : ", ") + flight;
  const ResidualModel model = found.model();
  for (std::size_t i = 0; i < model.terms().size(); ++i) {
    const char* comma = i == 0 ? "" : ", ";
    terms += fmt::format("{}\"{}\"", comma, model.terms()[i].name());
    for (std::size_t t = 0; t < 3; ++t) {
      forces[t] += comma + shortest(model.coefficients()(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(i)));
    }
  }
  return fmt::format(
      "# the force that the known model leaves over, identified by `gustlab identify` from {}\n"
      "# {}; {} samples; rms per axis {:.4g} N before, {:.4g} N left, {:.4g} N {}\n"
      "# fx, fy, fz: N in the world frame per unit of each term; T: total thrust, N; angles: rad\n"
      "[[effect]]\n"
      "type = \"sindy_residual\"\n"
      "terms = [{}]\n"
      "fx = [{}]\n"
      "fy = [{}]\n"
      "fz = [{}]\n",
      names, settings(found), found.samples, found.force_rms, found.error_fit, found.error_holdout,
      found.holdout_is_cross_validation ? "cross-validated" : "on held-out flights", terms, forces[0], forces[1],
      forces[2]);
}

}  // namespace gustlab
