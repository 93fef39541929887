#include "diagnosis/validation/holdout.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/selection/suspect_histories.hpp"

namespace gustlab::diagnosis {

Eigen::VectorXd carry_over(const Catalogue& from, const Eigen::VectorXd& value, const Catalogue& to) {
  // (group, parameter) → mean over flights
  std::map<std::pair<std::string, int>, std::pair<double, int>> mean;
  for (int c = 0; c < from.size(); ++c) {
    const Column& column = from.column(c);
    if (column.group < 0) continue;
    auto& [sum, count] = mean[{from.group(column.group).label, column.parameter}];
    sum += value[c];
    ++count;
  }
  Eigen::VectorXd result = to.nominal();
  for (int c = 0; c < to.size(); ++c) {
    const Column& column = to.column(c);
    if (column.group < 0) continue;
    const auto found = mean.find({to.group(column.group).label, column.parameter});
    if (found != mean.end()) result[c] = found->second.first / found->second.second;
  }
  return result;
}

namespace {

// The findings on the held-out flights: shared coefficients as they were fitted, values per flight free.
class OnHeldOut {
 public:
  OnHeldOut(const Session& fitted, const Selection& selection, Session& session)
      : fitted_(fitted),
        s_(session),
        catalogue_(session.catalogue()),
        search_(catalogue_, fitted.vehicle(), 0.0),
        natural_(catalogue_.size()),
        value_(carry_over(fitted.catalogue(), selection.value, catalogue_)),
        wanted_(session.biases()) {
    for (int c = 0; c < catalogue_.size(); ++c) natural_[c] = catalogue_.column(c).natural;
    for (const Finding& finding : selection.findings) {
      groups_.push_back(catalogue_.find(fitted.catalogue().group(finding.group).label));
      used_.push_back(groups_.back() < 0 ? std::vector<int>{} : catalogue_.group(groups_.back()).columns);
      wanted_.insert(wanted_.end(), used_.back().begin(), used_.back().end());
    }
    // of what the reference flights cannot tell apart a part alone would explain everything
    if (fitted_.reference()) {
      const std::vector<int> known = known_columns(catalogue_, s_.all_columns(), *fitted_.reference()).column;
      wanted_.insert(wanted_.end(), known.begin(), known.end());
    }
    std::sort(wanted_.begin(), wanted_.end());
    wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
    linearise();
    // the force of a wind is not linear in it
    if (std::find(groups_.begin(), groups_.end(), catalogue_.find(Airflow::wind)) != groups_.end())
      for (int step = 0; step < 2; ++step) follow_own_values();
  }

  HoldoutTest test() const {
    HoldoutTest test;
    test.rows = grams_.rows;
    const Eigen::MatrixXd projected = project_out(grams_.total(), s_.biases());
    const Eigen::VectorXd coefficient = coefficients();
    test.loss_selected = fit_without(-1).second.loss;
    test.loss_nominal = solve(grams_.total(), s_.biases()).loss;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      test.delta_chi2.push_back(groups_[i] < 0 ? 0.0 : fit_without(groups_[i]).second.loss - test.loss_selected);
      Eigen::VectorXd fitted_part = Eigen::VectorXd::Zero(catalogue_.size() + 1);
      for (const int c : used_[i]) fitted_part[c] = coefficient[c];
      test.expected.push_back(fitted_part.dot(projected * fitted_part));
    }
    return test;
  }

 private:
  Eigen::VectorXd coefficients() const { return (value_ - catalogue_.nominal()).cwiseQuotient(natural_); }

  void linearise() {
    s_.linearise(value_, wanted_);
    s_.take_weights(fitted_);
    grams_ = s_.grams();
    grams_.shift(coefficients());
    // what the reference flights leave open they leave open here too
    if (fitted_.reference()) grams_ = beside_reference(catalogue_, wanted_, *fitted_.reference(), std::move(grams_));
  }

  // (free columns, their fit) when one group, and what only it lets feel, is not there
  std::pair<std::vector<int>, Fit> fit_without(int out) const {
    const std::vector<int> kept = search_.without(groups_, out);
    const Eigen::VectorXd coefficient = coefficients();
    Eigen::VectorXd fixed = Eigen::VectorXd::Zero(catalogue_.size());
    std::vector<int> free = s_.biases();
    for (std::size_t i = 0; i < used_.size(); ++i) {
      if (std::find(kept.begin(), kept.end(), groups_[i]) == kept.end()) continue;
      for (const int c : used_[i]) {
        if (catalogue_.column(c).flight < 0) fixed[c] = coefficient[c];
        else free.push_back(c);
      }
    }
    Grams rest = grams_;
    rest.shift(-fixed);
    return {free, solve(rest.total(), free)};
  }

  void follow_own_values() {
    const auto [free, fit] = fit_without(-1);
    for (std::size_t i = 0; i < free.size(); ++i)
      if (const int c = free[i]; catalogue_.column(c).group >= 0)
        value_[c] = catalogue_.nominal()[c] + fit.coefficient[static_cast<Eigen::Index>(i)] * natural_[c];
    catalogue_.clamp(value_);
    linearise();
  }

  const Session& fitted_;
  Session& s_;
  const Catalogue& catalogue_;
  const SubsetSearch search_;
  Eigen::VectorXd natural_, value_;
  std::vector<int> wanted_;  // columns that any finding uses, and the biases
  std::vector<int> groups_;  // of each finding; −1: not on these flights
  std::vector<std::vector<int>> used_;
  Grams grams_;
};

}  // namespace

HoldoutTest test_holdout(const Session& fitted, const Selection& selection, std::vector<FlightData> holdout,
                         std::vector<FlightData> own_rate, int jobs) {
  if (holdout.empty()) {
    const std::vector<double> nothing(selection.findings.size(), 0.0);
    return {.delta_chi2 = nothing, .expected = nothing};
  }
  Session session(std::move(holdout), fitted.vehicle(), jobs, std::move(own_rate));
  session.noise = selection.noise_selected;
  suspect_histories_found(fitted, selection, session);
  return OnHeldOut(fitted, selection, session).test();
}

}  // namespace gustlab::diagnosis
