#include "diagnosis/validation/holdout.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "diagnosis/selection/pendulum.hpp"

namespace gustlab::diagnosis {

Eigen::VectorXd carry_over(const Catalogue& from, const Eigen::VectorXd& value, const Catalogue& to) {
  // (group, parameter) → mean over flights
  std::map<std::pair<std::string, int>, std::pair<double, int>> mean;
  for (int c = 0; c < from.size(); ++c) {
    const Column& column = from.columns()[static_cast<std::size_t>(c)];
    if (column.group < 0) continue;
    auto& [sum, count] = mean[{from.groups()[static_cast<std::size_t>(column.group)].label, column.parameter}];
    sum += value[c];
    ++count;
  }
  Eigen::VectorXd result = to.nominal();
  for (int c = 0; c < to.size(); ++c) {
    const Column& column = to.columns()[static_cast<std::size_t>(c)];
    if (column.group < 0) continue;
    const auto found = mean.find({to.groups()[static_cast<std::size_t>(column.group)].label, column.parameter});
    if (found != mean.end()) result[c] = found->second.first / found->second.second;
  }
  return result;
}

namespace {

// the held-out flights get the histories that were found, a swing driven by the vehicle as it flew
void suspect_what_was_found(const Session& fitted, const Selection& selection, Session& session) {
  const int load = fitted.catalogue().find(ColumnFrom::swing);
  if (load >= 0 && selection.find(load)) {
    const Group& group = fitted.catalogue().groups()[static_cast<std::size_t>(load)];
    session.linearise(session.catalogue().nominal(), {});
    session.learn_noise(1, {});
    session.noise = selection.noise_selected;
    std::vector<std::vector<Vector3>> force;
    for (std::size_t f = 0; f < session.flights().size(); ++f)
      force.push_back(pendulum_force(session.flights()[f], session.smoothed[f], session.vehicle().mass_kg, group.swing,
                                     selection.value[group.columns.front()]));
    session.suspect_load(group.swing, std::move(force));
  }
  const int limit = fitted.catalogue().find(ColumnFrom::speed_limit);
  if (limit >= 0 && selection.find(limit))
    session.suspect_limit(fitted.catalogue().groups()[static_cast<std::size_t>(limit)].limit_radps);
}

}  // namespace

HoldoutTest test_holdout(const Session& fitted, const Selection& selection, std::vector<FlightData> holdout,
                         std::vector<FlightData> own_rate, int jobs) {
  HoldoutTest test;
  Session session(std::move(holdout), fitted.vehicle(), jobs, std::move(own_rate));
  const Catalogue& catalogue = session.catalogue();
  session.noise = selection.noise_selected;
  const Eigen::VectorXd value = carry_over(fitted.catalogue(), selection.value, catalogue);

  // columns that any finding uses, and the biases
  std::vector<std::vector<int>> used;
  std::vector<int> wanted = session.biases();
  for (const Finding& finding : selection.findings) {
    const int g = catalogue.find(fitted.catalogue().groups()[static_cast<std::size_t>(finding.group)].label);
    used.push_back(g < 0 ? std::vector<int>{} : catalogue.groups()[static_cast<std::size_t>(g)].columns);
    wanted.insert(wanted.end(), used.back().begin(), used.back().end());
  }
  std::sort(wanted.begin(), wanted.end());
  suspect_what_was_found(fitted, selection, session);
  session.linearise(value, wanted);
  session.take_weights(fitted);
  Grams grams = session.grams();
  Eigen::VectorXd natural(catalogue.size());
  for (int c = 0; c < catalogue.size(); ++c) natural[c] = catalogue.columns()[static_cast<std::size_t>(c)].natural;
  const Eigen::VectorXd coefficient = (value - catalogue.nominal()).cwiseQuotient(natural);
  grams.shift(coefficient);
  test.rows = grams.rows;

  // loss when the findings in `out` are not there: shared coefficients fixed, values per flight and biases free
  const auto loss_without = [&](const std::vector<bool>& out) {
    Eigen::VectorXd fixed = Eigen::VectorXd::Zero(catalogue.size());
    std::vector<int> free = session.biases();
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (out[i]) continue;
      for (const int c : used[i]) {
        if (catalogue.columns()[static_cast<std::size_t>(c)].flight < 0) fixed[c] = coefficient[c];
        else free.push_back(c);
      }
    }
    Grams rest = grams;
    rest.shift(-fixed);
    return solve(rest.total(), free).loss;
  };
  const Eigen::MatrixXd projected = project_out(grams.total(), session.biases());
  const std::vector<bool> none(used.size(), false), all(used.size(), true);
  test.loss_selected = loss_without(none);
  test.loss_nominal = loss_without(all);
  for (std::size_t i = 0; i < used.size(); ++i) {
    std::vector<bool> out = none;
    out[i] = true;
    test.gain.push_back(loss_without(out) - test.loss_selected);
    Eigen::VectorXd fitted_part = Eigen::VectorXd::Zero(catalogue.size() + 1);
    for (const int c : used[i]) fitted_part[c] = coefficient[c];
    test.expected.push_back(fitted_part.dot(projected * fitted_part));
  }
  return test;
}

}  // namespace gustlab::diagnosis
