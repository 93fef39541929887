#include "diagnosis/output/residual_effect.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "config/toml.hpp"
#include "control/feature_terms.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "diagnosis/validation/generic_bases.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::most_terms, decisions::least_closed, decisions::most_lost;
constexpr std::array<std::string_view, 6> channel_name = {"force_x",  "force_y",  "force_z",
                                                          "torque_x", "torque_y", "torque_z"};

// one column: a term that is a force along, or a moment about, one axis
struct Column {
  FeatureTerm term;
  int channel;  // 0–2 force, 3–5 torque
};

struct Library {
  bool world = false;  // axes of the force
  std::vector<Column> columns;
};

// constant, linear, quadratic with and without sign, and products, of the given variables
std::vector<FeatureTerm> terms_of(const std::vector<std::string>& variables, bool with_sign) {
  std::vector<std::string> names = {"1"};
  for (std::size_t i = 0; i < variables.size(); ++i) {
    names.push_back(variables[i]);
    names.push_back(variables[i] + "^2");
    if (with_sign) {
      names.push_back(variables[i] + " abs " + variables[i]);
      names.push_back(variables[i] + " speed");
    }
    for (std::size_t j = i + 1; j < variables.size(); ++j) names.push_back(variables[i] + " " + variables[j]);
  }
  if (with_sign) names.emplace_back("speed");
  std::vector<FeatureTerm> terms;
  for (const std::string& name : names) terms.push_back(FeatureTerm::parse(name));
  return terms;
}

// forces and torques of velocity in body axes, and forces of position in world axes
std::vector<Library> libraries() {
  Library moving, placed;
  placed.world = true;
  for (int channel = 0; channel < 6; ++channel) {
    for (const FeatureTerm& term : terms_of({"vx_B", "vy_B", "vz_B"}, true)) moving.columns.push_back({term, channel});
    if (channel < 3)
      for (const FeatureTerm& term : terms_of({"px", "py", "pz"}, false)) placed.columns.push_back({term, channel});
  }
  return {moving, placed};
}

// m/s² and rad/s² per unit of the term, as columns beside those of the catalogue
BasisFamily family_of(const Session& session, const Library& library) {
  BasisFamily family;
  family.size = static_cast<int>(library.columns.size());
  family.set = [&session, &library](std::size_t f, std::size_t k, Eigen::Ref<SpatialAccelerations> columns) {
    const Motion& m = session.flights()[f].motion[k];
    const Matrix3 R = m.attitude_WB.toRotationMatrix();
    FeatureInput input;
    input.position_W_m = m.position_W_m;
    input.velocity_W_mps = m.velocity_W_mps;
    set_angles(input, R);
    for (std::size_t j = 0; j < library.columns.size(); ++j) {
      const Column& column = library.columns[j];
      const int axis = column.channel % 3;
      const bool turned = column.channel < 3 && !library.world;
      columns.block<3, 1>(column.channel < 3 ? 0 : 3, static_cast<Eigen::Index>(j)) =
          column.term.value(input) * (turned ? Vector3(R.col(axis)) : Vector3(Vector3::Unit(axis)));
    }
  };
  return family;
}

struct Found {
  const Library* library = nullptr;
  SparseFit fit;
};

// the effect that describes without naming
std::string_view description() {
  return first_effect([](const EffectRow& row) { return row.describes; }).name;
}

// an [[effect]] table, and the same for the report
void write(const Found& found, const VehicleModel& vehicle, std::string& toml, nlohmann::ordered_json& json) {
  std::vector<std::string> names;
  std::array<std::vector<double>, 6> value;
  json["terms"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < found.fit.chosen.size(); ++i) {
    const Column& column = found.library->columns[static_cast<std::size_t>(found.fit.chosen[i])];
    auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), column.term.name()) - names.begin());
    if (at == names.size()) {
      names.push_back(column.term.name());
      for (auto& list : value) list.push_back(0.0);
    }
    Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
    if (column.channel < 3) wrench[column.channel] = vehicle.mass_kg * found.fit.coefficient[i];
    else wrench.tail<3>() = vehicle.inertia_B_kgm2.col(column.channel - 3) * found.fit.coefficient[i];
    for (std::size_t c = 0; c < 6; ++c) value[c][at] += wrench[static_cast<Eigen::Index>(c)];
    json["terms"].push_back({{"channel", channel_name[static_cast<std::size_t>(column.channel)]},
                             {"term", column.term.name()},
                             {"coefficient", wrench[column.channel]},
                             {"unit", column.channel < 3 ? "N per unit of the term" : "N m per unit of the term"}});
  }
  const auto list = [](const std::vector<double>& numbers) {
    std::vector<std::string> texts;
    for (const double number : numbers) texts.push_back(config::shortest(number));
    return fmt::format("[{}]", fmt::join(texts, ", "));
  };
  toml = fmt::format(
      "\n[[effect]]  # without a name: a description of what is left, in SI units\ntype = \"{}\"\nframe = "
      "\"{}\"\nterms = [\"{}\"]\n",
      description(), found.library->world ? "world" : "body", fmt::join(names, "\", \""));
  constexpr std::array<const char*, 6> key = {"fx", "fy", "fz", "tx", "ty", "tz"};
  for (std::size_t c = 0; c < 6; ++c)
    if (c < 3 || std::any_of(value[c].begin(), value[c].end(), [](double v) { return v != 0.0; }))
      toml += fmt::format("{} = {}\n", key[c], list(value[c]));
}

// errors half a second ahead without and with the model, and the share of what is above noise that is gone
struct Proof {
  std::string_view quantity;
  double without = 0.0, with = 0.0, closed = 0.0;
};
std::vector<Proof> compare(const nlohmann::ordered_json& without, const nlohmann::ordered_json& with) {
  std::vector<Proof> proofs;
  for (const std::string_view name : fit_quantity_names) {
    const double before = half_a_second_ahead(without, name, "after"), after = half_a_second_ahead(with, name, "after"),
                 noise = half_a_second_ahead(without, name, "noise");
    if (before > 1.05 * noise) proofs.push_back({name, before, after, (before - after) / (before - noise)});
  }
  std::stable_sort(proofs.begin(), proofs.end(), [](const Proof& a, const Proof& b) { return a.closed > b.closed; });
  return proofs;
}

// Linearises the flights with the effects that are written into the augmented vehicle, which stay beside what is sought; their columns.
std::vector<int> linearise_beside(const Diagnosis& out, const Selection& selection, Session& session) {
  const Catalogue& catalogue = session.catalogue();
  std::set<std::string> kept;
  for (const auto* list : {&out.effects, &out.calibration})
    for (const EffectFinding& effect : *list) kept.insert(effect.effect);
  Eigen::VectorXd value = catalogue.nominal();
  std::vector<int> beside = session.biases();
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    if (!kept.contains(std::string(group.row->name))) continue;
    for (const int c : group.columns) {
      value[c] = selection.value[c];
      beside.push_back(c);
    }
  }
  // the noise that was learnt took what is sought here for chance: a calm room is not disturbed as much
  session.noise = selection.noise_selected;
  const auto floor = reference_floor(session.vehicle());
  for (std::size_t g = 0; g < disturbance_groups; ++g)
    session.noise.variance[g] = std::min(session.noise.variance[g], floor[g] * floor[g]);
  session.linearise(value, beside);
  std::erase_if(beside, [&](int c) {
    return std::none_of(session.linear().begin(), session.linear().end(), [&](const LinearFlight& f) {
      return std::find(f.columns.begin(), f.columns.end(), c) != f.columns.end();
    });
  });
  return beside;
}

}  // namespace

SparseFit matching_pursuit(const Eigen::MatrixXd& gram, int beside, double rows) {
  SparseFit sparse;
  const int offered = static_cast<int>(gram.cols()) - 1 - beside;
  std::vector<int> columns(static_cast<std::size_t>(beside));
  std::iota(columns.begin(), columns.end(), 0);
  const double before = solve(gram, columns).loss;
  sparse.loss = before;
  while (sparse.chosen.size() < most_terms) {
    int best = -1;
    double least = sparse.loss - std::max(decisions::term_materiality * std::max(rows, before),
                                          decisions::term_relative_materiality * (before - sparse.loss));
    for (int j = 0; j < offered; ++j) {
      if (std::ranges::count(sparse.chosen, j) > 0) continue;
      columns.push_back(beside + j);
      const double with = solve(gram, columns).loss;
      columns.pop_back();
      if (with < least) {
        least = with;
        best = j;
      }
    }
    if (best < 0) break;
    columns.push_back(beside + best);
    sparse.chosen.push_back(best);
    sparse.loss = least;
  }
  const Fit fit = solve(gram, columns);
  for (std::size_t i = 0; i < sparse.chosen.size(); ++i)
    sparse.coefficient.push_back(fit.coefficient[beside + static_cast<Eigen::Index>(i)]);
  return sparse;
}

void offer_residual(Session& session, const Selection& selection, const std::vector<FlightLog>& holdout, int jobs,
                    Diagnosis& out) {
  if (out.fit.is_null()) return;
  const std::vector<int> beside = linearise_beside(out, selection, session);
  const std::vector<Library> all = libraries();
  Found best;
  for (const Library& library : all) {
    SparseFit fit = matching_pursuit(gram_with(session, family_of(session, library), beside),
                                     static_cast<int>(beside.size()), selection.degrees_of_freedom);
    if (!fit.chosen.empty() && (!best.library || fit.loss < best.fit.loss)) best = {&library, std::move(fit)};
  }

  // proof on the held-out flights, with and without
  const auto flown = [&](const std::string& residual) {
    config::Table found = config::Table::parse(augmented_toml(out) + residual, "augmented.toml");
    return verify(holdout, session.vehicle(), config::read_effects(found), jobs);
  };
  const auto show = [&](Verification&& verified) {
    out.fit = std::move(verified.fit);
    out.window = std::move(verified.window);
    out.window_file = verified.window_file;
  };
  Verification without = flown("");
  if (!best.library) return show(std::move(without));
  std::string toml;
  nlohmann::ordered_json json = {{"effect", description()}, {"frame", best.library->world ? "world" : "body"}};
  write(best, session.vehicle(), toml, json);
  Verification with = flown(toml);
  const std::vector<Proof> proofs = compare(without.fit, with.fit);
  if (proofs.empty() || !(proofs.front().closed > least_closed) || !(proofs.back().closed > -most_lost)) {
    out.notes.push_back(fmt::format(
        "a model of what is left, a sum of {} terms, is not offered: it does not predict the held-out flights better",
        best.fit.chosen.size()));
    return show(std::move(without));
  }
  const Proof& most = proofs.front();
  std::string quantity(most.quantity.substr(0, most.quantity.rfind('_')));
  std::replace(quantity.begin(), quantity.end(), '_', ' ');
  json["says"] = fmt::format(
      "it closes {:.0f} % of the held-out error above noise in {} half a second ahead that is left without it",
      100.0 * std::min(most.closed, 1.0), quantity);
  json["share_closed"] = nlohmann::ordered_json::object();
  for (const Proof& proof : proofs) json["share_closed"][std::string(proof.quantity)] = proof.closed;
  for (const std::string_view name : fit_quantity_names)
    json["fit_without"][std::string(name)] = without.fit.at(std::string(name)).at("after");
  out.residual_model = std::move(json);
  out.residual_toml = std::move(toml);
  show(std::move(with));
}

}  // namespace gustlab::diagnosis
