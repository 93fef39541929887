#include "diagnosis/selection/select_effects.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/shared_numbers.hpp"
#include "diagnosis/selection/stability.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/selection/suspect_histories.hpp"
#include "diagnosis/selection/trims.hpp"
#include "diagnosis/selection/wind_start.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int kept_of_each_size = 25;      // subsets, by the search
constexpr std::ptrdiff_t most_rivals = 4;  // of an effect, that are said
constexpr std::size_t most_changes = 8;    // of a set that was found, before it is taken as it is

// What may happen to a set that was fitted: nothing more is tried, a group more, or one for another as well.
enum class Improve { no, by_more, freely };

// A mean of block differences over its standard error, blocks of a cluster together.
double paired_z(const Grams& grams, const Eigen::VectorXd& difference) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(grams.clusters);
  for (Eigen::Index b = 0; b < difference.size(); ++b)
    sums[grams.cluster[static_cast<std::size_t>(b)]] += difference[b];
  const auto count = static_cast<double>(sums.size());
  const double sd = std::sqrt((sums.array() - sums.mean()).square().sum() / std::max(1.0, count - 1.0));
  return sums.sum() / (std::sqrt(count) * sd + 1e-9);
}

// the search's working parts, in the order of DIAGNOSIS.md §3.6
class Selector {
 public:
  explicit Selector(Session& session, std::set<int> left_out = {})
      : s_(session), catalogue_(session.catalogue()), left_out_(std::move(left_out)) {
    natural_.resize(catalogue_.size());
    for (int c = 0; c < catalogue_.size(); ++c) natural_[c] = catalogue_.column(c).natural;
  }

  Selection run() {
    Selection result;
    Eigen::VectorXd value = catalogue_.nominal();
    const NoiseModel calm = s_.noise;
    s_.linearise(value, s_.all_columns());
    s_.learn_noise(6, s_.biases());
    result.nominal_from(s_);
    suspect_histories(s_, value, {});
    s_.start_latency(value);
    value = likelier_start(value).value;
    if (value != catalogue_.nominal()) s_.linearise(value, s_.all_columns());
    // what nothing explains yet is no noise to begin with
    s_.noise = calm;

    std::vector<int> chosen;
    std::map<std::vector<int>, Eigen::VectorXd> visited;
    std::optional<WithoutWind> without_wind;
    constexpr int rounds = 6;
    int latency = -1;  // what the first round settled on
    for (int round = 0; round < rounds; ++round) {
      anew_ = round > 0;
      if (anew_) s_.linearise(value, s_.all_columns());
      if (round == 1 && !chosen.empty()) suspect_histories(s_, value, chosen);
      if (round == 0) s_.search_noise(s_.all_columns());
      if (round == 0 && s_.noise.errors_last()) {
        const NoiseModel found = s_.noise;  // before and after are told apart with the same sensors
        s_.learn_noise(6, s_.biases());
        result.nominal_from(s_);
        s_.noise = found;
      }
      s_.learn_noise(4, s_.all_columns());
      const Grams grams = absolute(value);
      if (round == 0) freeze_unidentifiable(grams);
      const std::vector<int> next = search(grams);
      value = refine(next, coefficients(grams, next, value));
      const bool settled = round > 0 && next == chosen;
      chosen = next;
      if (round == 0) value = likelier_latency(chosen, value), latency = latency_of(chosen);
      const WithoutWind still{chosen, value, s_.noise};
      value = likelier_wind(grams, chosen, value);
      if (chosen != still.chosen) without_wind = still;
      visited[chosen] = value;
      if (settled) break;
      if (round == 0) s_.forget_transitions();
      if (round == rounds - 1) value = best_visited(visited, chosen);
    }
    // linearised about the one the other seemed likelier
    if (latency >= 0 && latency_of(chosen) != latency) value = likelier_latency(chosen, value);
    Selection finished = result;
    finish(finished, chosen, value);
    // a wind that does not stand has taken the place of a drag that may
    if (without_wind && finished.find(catalogue_.find(Airflow::wind)) == nullptr) {
      s_.noise = without_wind->noise;
      finish(result, without_wind->chosen, without_wind->value);
      return result;
    }
    return finished;
  }

  // fewer groups, fitted anew
  Selection without(const Selection& before, const std::vector<int>& failed, Improve improve = Improve::no) {
    improve_ = improve;
    std::vector<int> chosen = before.groups();
    std::erase_if(chosen, [&](int g) { return std::ranges::find(failed, g) != failed.end(); });
    chosen = SubsetSearch(catalogue_, s_.vehicle(), 0.0).without(chosen, -1);
    Eigen::VectorXd value = catalogue_.nominal();
    for (const int c : s_.with_biases(chosen)) value[c] = before.value[c];
    value = refine(chosen, value);
    // a lag and a delay were one latency between them: the one that is left may be the wrong one
    const auto among = [&](int g) { return std::find(failed.begin(), failed.end(), g) != failed.end(); };
    if (std::ranges::any_of(latencies(), among)) value = likelier_latency(chosen, value);
    return finished_like(before, chosen, value);
  }

  // More groups, fitted anew. The noise that was learned beside too few effects holds the others: it is learned beside all.
  std::optional<Selection> with_more(const Selection& before, std::set<std::vector<int>>& tried) {
    improve_ = Improve::by_more;
    anew_ = true;
    if (std::optional<Selection> later = with_latency(before, tried)) return later;
    Session::Learned kept = s_.learned();
    s_.learn_noise(4, s_.all_columns());
    const Grams grams = absolute(s_.value());
    const double loss_nominal = solve(grams.total(), s_.biases()).loss;
    const std::vector<int> more = better_than(before.groups(), grams, loss_nominal, tried, left_out_);
    if (more.empty()) {
      s_.put_back(std::move(kept));
      return std::nullopt;
    }
    tried.insert(more);
    return finished_like(before, more, refine(more, coefficients(grams, more, s_.value())));
  }

  // these groups in place of those before, fitted anew
  Selection given(const Selection& before, const std::vector<int>& groups) {
    improve_ = Improve::no;
    anew_ = true;
    return finished_like(before, groups, refine(groups, coefficients(before.grams, groups, before.value)));
  }

  Eigen::VectorXd values_with(const std::vector<int>& groups, const Eigen::VectorXd& start) {
    return refine(groups, start);
  }

  Selection with_also(const Selection& before, const std::vector<int>& groups, const Eigen::VectorXd& start) {
    improve_ = Improve::by_more;
    anew_ = true;
    const std::vector<int> more = joined(before.groups(), groups);
    return finished_like(before, more, refine(more, start));
  }

 private:
  // The same with a lag or a delay that the search lost: linearised at none, it seems not to pay.
  std::optional<Selection> with_latency(const Selection& before, std::set<std::vector<int>>& tried) {
    const auto is_latency = [&](int g) { return std::ranges::count(latencies(), g) > 0; };
    if (std::ranges::any_of(before.groups(), is_latency)) return std::nullopt;
    const auto [late, start] = likelier_start(s_.value());
    if (late < 0 || left_out_.contains(late)) return std::nullopt;
    if (!tried.insert(joined(before.groups(), {late})).second) return std::nullopt;
    return with_also(before, {late}, start);
  }

  // the set that winds took the place of, and the noise beside it
  struct WithoutWind {
    std::vector<int> chosen;
    Eigen::VectorXd value;
    NoiseModel noise;
  };

  // Grams whose coefficients count from the nominal vehicle, in natural units
  Grams absolute(const Eigen::VectorXd& value) {
    Grams grams = s_.grams();
    grams.shift((value - catalogue_.nominal()).cwiseQuotient(natural_));
    return s_.reference() ? beside_reference(catalogue_, s_.all_columns(), *s_.reference(), std::move(grams)) : grams;
  }

  // what a further effect must gain beyond the price of its numbers; where the model was linearised anew about what was found, a large effect leaves no
  // second-order error that could be taken for another
  double material(double rows, double total_delta_chi2) const {
    const double relative = decisions::relative_materiality * total_delta_chi2;
    return std::max(asked(0.0).gained_by_chance(),
                    anew_ && !s_.shoots() ? std::min(relative, decisions::most_materiality * rows) : relative);
  }

  // Numbers that are not identifiable from these flights, were all else known, stay as the vehicle file has them, and leave their effect to its others:
  // what they are fitted to would carry them out of their bounds, and the effect with them.
  void freeze_unidentifiable(const Grams& grams) {
    const Eigen::MatrixXd projected = project_out(grams.total(), s_.biases());
    for (int c = 0; c < catalogue_.size(); ++c) {
      const Column& column = catalogue_.column(c);
      if (column.group < 0 || catalogue_.group(column.group).columns.size() < 2) continue;
      const double deviation = column.natural / std::sqrt(projected(c, c));
      if (!(deviation <= decisions::unidentifiable_share * 0.5 * (column.max - column.min))) s_.freeze(c);
    }
  }

  SubsetSearch asked(double penalty) const {
    SubsetSearch search(catalogue_, s_.vehicle(), penalty);
    std::erase_if(search.candidates, [&](int g) { return left_out_.contains(g); });
    return search;
  }

  std::vector<int> search(const Grams& grams) const {
    const Eigen::MatrixXd projected = project_out(grams.total(), s_.biases());
    const SubsetSearch search = asked(std::log(grams.rows));
    for (int most = most_effects;; most += 3) {
      const auto by_size = search.run(projected, most, kept_of_each_size);
      double least = by_size[0].front().loss;
      for (const auto& subsets : by_size)
        for (const Subset& subset : subsets) least = std::min(least, subset.loss);
      const std::vector<int> groups =
          SubsetSearch::choose(by_size, material(grams.rows, by_size[0].front().loss - least)).groups;
      // real vehicles may differ in more ways than a search begins with
      if (static_cast<int>(groups.size()) < most || most > most_effects) return groups;
    }
  }

  // values of a fit on absolute Grams, which were linearised about these, SI
  Eigen::VectorXd coefficients(const Grams& grams, const std::vector<int>& groups, const Eigen::VectorXd& about) const {
    const std::vector<int> columns = s_.with_biases(groups);
    Eigen::VectorXd value = value_at(catalogue_, columns, solve(grams.total(), columns));
    // a wind that was tried with a drag of natural size means more with a smaller one
    const int wind = catalogue_.find(Airflow::wind), drag = catalogue_.find(Airflow::drag);
    if (std::find(groups.begin(), groups.end(), wind) != groups.end() && wind >= 0 && drag >= 0) {
      const int d = catalogue_.group(drag).columns.front();
      if (about[d] == 0.0 && value[d] > 0.1 * natural_[d])
        for (const int c : catalogue_.group(wind).columns) value[c] *= natural_[d] / value[d];
    }
    catalogue_.clamp(value);
    return value;
  }

  bool forces_alone() const { return !s_.shoots() && s_.flights().front().collective_only; }

  double loss_of_biases_at(const Eigen::VectorXd& value) {
    s_.predict_at(value);
    return solve(s_.grams(s_.biases()).total(), s_.biases()).loss;
  }

  // Where no rotor was measured the motion itself says how late the vehicle answers: torques swing at several hertz, and from half a swing away a
  // fit runs the wrong way. The search begins at the likeliest of some lags and delays.
  LatencyStart likelier_start(const Eigen::VectorXd& prompt) {
    if (s_.predicts_speeds() || forces_alone() || !catalogue_.observes(Need::torque) || catalogue_.commands_are_slow())
      return {-1, prompt};
    constexpr double hopeless = 1.5;
    LatencyStart best = least_left_at(
        catalogue_, prompt, decisions::latency_likelier,
        [&](const Eigen::VectorXd& value) { return loss_of_biases_at(value); }, hopeless);
    s_.predict_at(best.value);
    return best;
  }

  // Thrust swings at several hertz: from half a swing away a fit runs the wrong way. Torques say it by themselves; forces alone
  // are tried at some latencies, and the likeliest is where the fit begins.
  void start_latency(const std::vector<int>& groups, const std::vector<int>& columns, Eigen::VectorXd& value) {
    if (!forces_alone()) return;
    const auto [lag, delay] = latencies();
    for (const int late : {delay, lag}) {
      if (std::find(groups.begin(), groups.end(), late) == groups.end()) continue;
      Eigen::VectorXd best = value;
      double least = std::numeric_limits<double>::infinity();
      for (const double later_s : {0.0, 0.02, 0.04, 0.08}) {
        Eigen::VectorXd trial = value;
        for (const int c : catalogue_.group(late).columns)
          trial[c] = later_s == 0.0 ? trial[c] : catalogue_.nominal()[c] + later_s;
        s_.linearise(trial, columns, false);
        if (const double loss = solve(s_.grams().total(), columns).loss; loss < least) least = loss, best = trial;
      }
      value = best;
    }
  }

  // One step of Gauss and Newton; returns the largest change, in natural units.
  double step(const std::vector<int>& columns, Eigen::VectorXd& value) const {
    const Fit fit = solve(s_.grams().total(), columns);
    const Eigen::VectorXd before = value;
    for (std::size_t i = 0; i < columns.size(); ++i)
      value[columns[i]] +=
          std::clamp(fit.coefficient[static_cast<Eigen::Index>(i)], -20.0, 20.0) * natural_[columns[i]];
    catalogue_.clamp(value);
    // a value at its bound has nowhere to go
    return (value - before).cwiseQuotient(natural_).cwiseAbs().maxCoeff();
  }

  // Gauss–Newton in the nonlinear model: columns are differentiated at most a few times, and stay as they are while steps fall fast.
  Eigen::VectorXd refine(const std::vector<int>& groups, Eigen::VectorXd value) {
    value = refined(groups, std::move(value));
    bool ran_away = false;
    for (const int c : columns_of(catalogue_, groups)) {
      const Column& column = catalogue_.column(c);
      if (column.known_to == 0.0 || std::abs(value[c] - column.nominal) < decisions::ran_away * column.known_to)
        continue;
      value[c] = column.nominal;
      s_.freeze(c);
      ran_away = true;
    }
    return ran_away ? refined(groups, std::move(value)) : value;
  }

  Eigen::VectorXd refined(const std::vector<int>& groups, Eigen::VectorXd value) {
    constexpr double near = 2e-2, falls_to = 0.3;
    s_.start_delay(groups, value);
    const std::vector<int> columns = s_.with_biases(groups);
    start_latency(groups, columns, value);
    for (int anew = 0; anew < (s_.shoots() ? 6 : 3); ++anew) {
      s_.linearise(value, columns, false);
      for (double last = std::numeric_limits<double>::infinity(), moved;; last = moved) {
        moved = step(columns, value);
        if (moved < near) return value;
        if (!(moved <= falls_to * last)) break;
        s_.predict_at(value);
      }
    }
    return value;
  }

  // the set did not settle: every visited set under one noise model
  Eigen::VectorXd best_visited(const std::map<std::vector<int>, Eigen::VectorXd>& visited, std::vector<int>& chosen) {
    double best = std::numeric_limits<double>::infinity();
    const double by_chance = asked(0.0).gained_by_chance();
    Eigen::VectorXd value = catalogue_.nominal();
    for (const auto& [groups, start] : visited) {
      const Eigen::VectorXd refined = refine(groups, start);
      s_.linearise(refined, s_.with_biases(groups));
      const Grams grams = s_.grams();
      const double loss = solve(grams.total(), s_.with_biases(groups)).loss;
      const double score =
          loss + grams.price(columns_of(catalogue_, groups).size()) + by_chance * static_cast<double>(groups.size());
      if (score < best) {
        best = score;
        value = refined;
        chosen = groups;
      }
    }
    return value;
  }

  std::array<int, 2> latencies() const {
    return {catalogue_.find(Place::actuation, Latency::lag), catalogue_.find(Place::actuation, Latency::delay)};
  }
  // the lag or the delay of a set that has one of them alone, or −1
  int latency_of(const std::vector<int>& groups) const {
    const auto [lag, delay] = latencies();
    const bool lags = std::count(groups.begin(), groups.end(), lag) > 0,
               delays = std::count(groups.begin(), groups.end(), delay) > 0;
    return lags == delays ? -1 : lags ? lag : delay;
  }

  // Where the model was linearised a lag and a delay are the same: if one was chosen, the other is fitted in its place.
  Eigen::VectorXd likelier_latency(std::vector<int>& chosen, const Eigen::VectorXd& value) {
    const int from = latency_of(chosen);
    const auto [lag, delay] = latencies();
    const int to = from == lag ? delay : lag;
    if (from < 0 || to < 0 || below_tolerance(s_, value, from)) return value;
    std::vector<int> other = chosen;
    std::replace(other.begin(), other.end(), from, to);
    std::sort(other.begin(), other.end());
    const int was = columns_of(catalogue_, {from}).front(), is = columns_of(catalogue_, {to}).front();
    Eigen::VectorXd start = value;
    for (const int c : columns_of(catalogue_, {from})) start[c] = catalogue_.nominal()[c];
    start[is] += value[was] - catalogue_.nominal()[was];
    catalogue_.clamp(start);
    return best_visited({{chosen, value}, {other, start}}, chosen);
  }

  // Linearised in still air a wind is a force of every flight: where one was chosen, winds and a drag are fitted in its place. One flight
  // alone tells them apart only where the drag was chosen as well.
  Eigen::VectorXd likelier_wind(const Grams& grams, std::vector<int>& chosen, const Eigen::VectorXd& value) {
    const int force = force_like_wind(catalogue_), linear_drag = catalogue_.find(Airflow::drag);
    const auto is_drag = [&](int g) { return catalogue_.group(g).row->air == Airflow::drag; };
    if (linear_drag < 0 || std::find(chosen.begin(), chosen.end(), force) == chosen.end() ||
        (s_.flights().size() < 2 && std::none_of(chosen.begin(), chosen.end(), is_drag)) ||
        !winds_tried_.insert(chosen).second)
      return value;
    std::vector<int> linear = chosen;
    std::erase_if(linear, is_drag);
    linear.push_back(linear_drag);
    std::sort(linear.begin(), linear.end());
    std::map<std::vector<int>, Eigen::VectorXd> sets{{chosen, value}};
    for (StartedSet& set : winds_instead(catalogue_, linear, coefficients(grams, linear, s_.value())))
      sets.emplace(std::move(set.groups), std::move(set.value));
    return best_visited(sets, chosen);
  }

  // of the same flights, whose nominal noise and smoothed states are known
  Selection finished_like(const Selection& before, const std::vector<int>& chosen, const Eigen::VectorXd& value) {
    Selection result;
    result.noise_nominal = before.noise_nominal;
    result.smoothed_nominal = before.smoothed_nominal;
    result.at_bounds = before.at_bounds;
    finish(result, chosen, value);
    return result;
  }

  // another set that pays more, under these Gram matrices; empty: none
  std::vector<int> better_than(const std::vector<int>& chosen, const Grams& grams, double loss_nominal,
                               const std::set<std::vector<int>>& visited, const std::set<int>& left_out = {}) const {
    const Eigen::MatrixXd total = grams.total();
    const double loss = solve(total, s_.with_biases(chosen)).loss;
    SubsetSearch search = asked(std::log(grams.rows));
    std::erase_if(search.candidates, [&](int g) { return left_out.contains(g); });
    return search.improved(project_out(total, s_.biases()), chosen, visited, material(grams.rows, loss_nominal - loss),
                           improve_ == Improve::freely);
  }

  // The same, of which nothing would go at once.
  std::vector<int> lasting(const std::vector<int>& chosen, const Grams& grams, double loss_nominal,
                           std::set<std::vector<int>> visited, const std::set<int>& left_out) const {
    const Eigen::MatrixXd total = grams.total();
    while (true) {
      const std::vector<int> better = better_than(chosen, grams, loss_nominal, visited, left_out);
      std::vector<int> stays = better;
      prune(grams, stays, total, loss_nominal);
      if (stays == better) return better;
      visited.insert(better);
    }
  }

  // a set that settles, and what is said of it
  void finish(Selection& result, std::vector<int> chosen, Eigen::VectorXd value) {
    const Eigen::MatrixXd total = settle(result, chosen, std::move(value));
    result.noise_selected = s_.noise;
    result.smoothed_selected = s_.smoothed;
    result.degrees_of_freedom = result.grams.rows;
    const Fit fit = say_values(result, chosen, total);
    for (const int g : chosen) result.findings.push_back(finding_of(result, chosen, total, fit, g));
    rivals(result, chosen, fit);
    std::map<int, std::vector<int>> equals;
    for (const Finding& finding : result.findings)
      for (const Rival& rival : finding.rivals)
        if (equal(rival, finding)) equals[finding.group].push_back(rival.group);
    const std::vector<double> included = inclusion(s_, result.grams, chosen, left_out_, equals);
    for (Finding& finding : result.findings) finding.inclusion = included[static_cast<std::size_t>(finding.group)];
    for (const int g : SubsetSearch(catalogue_, s_.vehicle(), 0.0).candidates) {
      if (std::find(chosen.begin(), chosen.end(), g) != chosen.end()) continue;
      std::vector<int> more = chosen;
      more.push_back(g);
      result.alone.emplace_back(g, fit.loss - solve(total, s_.with_biases(more)).loss -
                                       result.grams.price(columns_of(catalogue_, {g}).size()));
    }
  }

  // how much less likely the flights may be with another set: a number of the vehicle may do a little less than a force of every flight
  double may_cost(const Eigen::MatrixXd& total, const std::vector<int>& before, const std::vector<int>& after) const {
    const double loss = solve(total, s_.with_biases(before)).loss;
    const SubsetSearch search(catalogue_, s_.vehicle(), 0.0);
    double cost = decisions::trim_cost;
    for (const int g : before)
      if (catalogue_.group(g).row->per_flight && std::ranges::count(after, g) == 0)
        cost += decisions::nearly_all * (solve(total, s_.with_biases(search.without(before, g))).loss - loss);
    return cost;
  }

  // a set that settled, and how unlikely the flights are with it: −2 log likelihood and what its numbers cost
  struct Stand {
    std::vector<int> groups;
    Eigen::VectorXd value;
    Session::Learned learned;
    Grams grams;
    std::map<int, double> latency_delta_chi2;
    double how_unlikely;
  };
  double how_unlikely(const std::vector<int>& chosen, const Grams& grams, const Eigen::MatrixXd& total) const {
    const std::vector<int> columns = s_.with_biases(chosen);
    Fit fit = solve(total, columns);
    // from where the flights were linearised
    fit.coefficient -= (s_.value() - catalogue_.nominal()).cwiseQuotient(natural_)(columns);
    return s_.minus_two_log_likelihood(columns, fit) + grams.price(columns.size());
  }

  // Linearised anew about a set, with noise learned anew, until it stays as it is; returns the sum of its Gram matrices.
  Eigen::MatrixXd settle(Selection& result, std::vector<int>& chosen, Eigen::VectorXd value) {
    Eigen::MatrixXd total;
    std::set<std::vector<int>> visited;
    std::set<int> went = left_out_;  // pruned once: not tried again in this set
    std::optional<Stand> stand;
    double may_lose = decisions::trim_cost;
    bool simplified = false;
    int noise_steps = 6;  // then 2: one effect more or less changes it little
    anew_ = true;
    latency_delta_chi2_.clear();
    const auto compare = [&](Grams grams) {
      result.grams = std::move(grams);
      total = result.grams.total();
      result.loss_nominal = solve(total, s_.biases()).loss;
    };
    for (bool settled = false; !settled;) {
      linearise_about(chosen, value);
      bool elsewhere = false;  // the flights are linearised about a set that did not pay
      // predictions half a second ahead count what nobody named as noise: it is learned beside all
      s_.learn_noise(std::exchange(noise_steps, 2), s_.shoots() ? s_.all_columns() : s_.with_biases(chosen));
      result.grams = {};  // a large set of flights has room for the best so far and these
      compare(absolute(value));
      const std::vector<int> before = chosen;
      prune(result.grams, chosen, total, result.loss_nominal);
      settled = chosen == before || chosen.empty();  // what stays takes over what went
      std::ranges::set_difference(before, chosen, std::inserter(went, went.end()));
      if (settled) {
        const double unlikely = how_unlikely(chosen, result.grams, total);
        if (stand && unlikely > stand->how_unlikely + std::exchange(may_lose, decisions::trim_cost)) {
          // fitted anew, and noise learned beside it, the change does not pay
          chosen = stand->groups, value = stand->value, latency_delta_chi2_ = stand->latency_delta_chi2;
          s_.put_back(stand->learned);
          compare(stand->grams);
          elsewhere = true;
        } else {
          stand = Stand{chosen, value, s_.learned(), result.grams, latency_delta_chi2_, unlikely};
        }
      }
      // what seemed not to pay may do so once the others, and the noise, are right; no set is tried twice
      if (settled && improve_ != Improve::no && visited.size() < 2 * most_changes) {
        visited.insert(chosen);
        const std::vector<int> better = lasting(chosen, result.grams, result.loss_nominal, visited, went);
        settled = better.empty();
        if (!settled) visited.insert(chosen = better);
      }
      if (settled && !simplified) {
        simplified = true;
        const std::vector<int> simpler = shared_instead(s_, result.grams, least_said(total, chosen), left_out_);
        settled = simpler == chosen;
        std::ranges::set_difference(chosen, simpler, std::inserter(went, went.end()));
        may_lose = may_cost(total, chosen, simpler);
        chosen = simpler;
      }
      // what settled is read there by others; what is tried next is linearised anew, but a delay begins at the speeds of before
      if (elsewhere && (settled || s_.predicts_speeds())) s_.linearise(value, s_.all_columns());
      if (!settled) value = refine(chosen, coefficients(result.grams, chosen, value));
    }
    result.how_unlikely = stand->how_unlikely;
    return total;
  }

  // the set's values and their errors, and what commands that nothing predicted say beside it
  Fit say_values(Selection& result, const std::vector<int>& chosen, const Eigen::MatrixXd& total) const {
    const std::vector<int> columns = s_.with_biases(chosen);
    Fit fit = solve(total, columns);
    const Eigen::MatrixXd covariance = clustered_covariance(result.grams, columns, fit.coefficient);
    result.loss_selected = fit.loss;
    std::vector<int> predicted = columns;
    std::erase_if(predicted, [&](int c) { return catalogue_.column(c).of_command_innovation(); });
    result.unpredicted_delta_chi2 = solve(total, predicted).loss - fit.loss;
    result.value = value_at(catalogue_, columns, fit);
    result.deviation = Eigen::VectorXd::Zero(catalogue_.size());
    for (std::size_t i = 0; i < columns.size(); ++i)
      result.deviation[columns[i]] =
          std::sqrt(std::max(0.0, covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)))) *
          natural_[columns[i]];
    catalogue_.clamp(result.value);
    return fit;
  }

  Finding finding_of(const Selection& result, const std::vector<int>& chosen, const Eigen::MatrixXd& total,
                     const Fit& fit, int g) const {
    const SubsetSearch search(catalogue_, s_.vehicle(), 0.0);
    Finding finding;
    finding.group = g;
    const std::vector<int> rest = search.without(chosen, g);
    finding.delta_chi2 = delta_chi2_of(g, solve(total, s_.with_biases(rest)).loss - fit.loss);
    finding.delta_chi2_alone = delta_chi2_alone(total, chosen, finding);
    finding.delta_chi2_with_partner = finding.delta_chi2;
    for (const int partner : rest) {
      const double delta_chi2 = solve(total, s_.with_biases(search.without(rest, partner))).loss - fit.loss;
      finding.delta_chi2_with_partner = std::min(finding.delta_chi2_with_partner, delta_chi2_of(g, delta_chi2));
    }
    finding.calibration = below_tolerance(s_, result.value, g) || imitated_by_scatter(s_, total, chosen, g);
    return finding;
  }

  // What it gains beside those alone that gain far more, and do so without it: what it stands on does not stand on it. Of two that undo
  // each other neither gains without the other.
  double delta_chi2_alone(const Eigen::MatrixXd& total, const std::vector<int>& chosen, const Finding& finding) const {
    const auto loss = [&](const std::vector<int>& groups) { return solve(total, s_.with_biases(groups)).loss; };
    std::vector<int> rest = chosen, stronger;
    std::erase(rest, finding.group);
    const double without = loss(rest);
    for (const int other : rest) {
      std::vector<int> fewer = rest;
      std::erase(fewer, other);
      if (loss(fewer) - without >= decisions::far_more * finding.delta_chi2) stronger.push_back(other);
    }
    return loss(stronger) - loss(joined(stronger, {finding.group}));
  }

  // One effect exchanged for another, and the set to compare that with: a trim is at work beside the effect as well, and only
  // what it gains in the effect's place makes it an equal.
  struct Exchange {
    std::vector<int> groups, kept;
    Fit fit = {}, kept_fit = {};
    bool trim = false;  // the other is below its tolerance
    double delta_chi2() const { return fit.loss - kept_fit.loss; }
  };
  std::optional<Exchange> exchange(const Eigen::MatrixXd& total, const SubsetSearch& search,
                                   const std::vector<int>& chosen, const Fit& fit, int group, int other) const {
    Exchange e{.groups = chosen, .kept = chosen};
    std::replace(e.groups.begin(), e.groups.end(), group, other);
    if (std::find(chosen.begin(), chosen.end(), other) != chosen.end() || !search.allowed(e.groups))
      return std::nullopt;
    e.fit = solve(total, s_.with_biases(e.groups));
    const Eigen::VectorXd value = value_at(catalogue_, s_.with_biases(e.groups), e.fit);
    if (!possible(catalogue_, value, other)) return std::nullopt;
    e.trim = below_tolerance(s_, value, other);
    if (e.trim) e.kept.push_back(other);
    e.kept_fit = e.trim ? solve(total, s_.with_biases(e.kept)) : fit;
    return e;
  }

  // Of sets that fit alike, one effect exchanged, the one with the least to say: mass with a trimmed inertia is thrust with a
  // wrong one.
  std::vector<int> least_said(const Eigen::MatrixXd& total, const std::vector<int>& chosen) const {
    const SubsetSearch search = asked(0.0);
    const auto said = [&](const std::vector<int>& groups, const Fit& fit) {
      const Eigen::VectorXd value = value_at(catalogue_, s_.with_biases(groups), fit);
      double sum = 0.0;
      for (const int g : groups) sum += std::min(1.0, std::pow(size_in_tolerances(s_, value, g), 2));
      return sum;
    };
    const Fit fit = solve(total, s_.with_biases(chosen));
    std::vector<int> best = chosen;
    double least = said(chosen, fit) - decisions::least_said_less;
    for (std::size_t i = 0; i < chosen.size(); ++i)
      for (const int other : search.candidates) {
        const std::optional<Exchange> e = exchange(total, search, chosen, fit, chosen[i], other);
        if (!e || e->delta_chi2() > decisions::trim_cost) continue;
        if (const double sum = said(e->groups, e->fit); sum < least) best = e->groups, least = sum;
      }
    std::sort(best.begin(), best.end());
    return best;
  }

  // All columns about the values of a set. Before, Δχ² without its lag or its delay, all else fitted anew where there is none: linearised
  // about a lag that is as long as the commands' swings, its own column says next to nothing of that. Measured anew when one of the
  // two comes or goes.
  void linearise_about(const std::vector<int>& chosen, const Eigen::VectorXd& value) {
    const auto is_chosen = [&](int late) { return std::find(chosen.begin(), chosen.end(), late) != chosen.end(); };
    const auto is_measured = [&](int late) { return is_chosen(late) == latency_delta_chi2_.contains(late); };
    const bool anew = !s_.shoots() && !std::ranges::all_of(latencies(), is_measured);
    if (anew) latency_delta_chi2_.clear();
    const auto loss_of = [&](const std::vector<int>& groups) {
      const std::vector<int> columns = s_.with_biases(groups);
      return solve(s_.grams(columns).total(), columns).loss;
    };
    for (const int late : latencies()) {
      if (!anew || !is_chosen(late)) continue;
      std::vector<int> rest = chosen;
      std::erase(rest, late);
      Eigen::VectorXd prompt = value;
      for (const int c : columns_of(catalogue_, {late})) prompt[c] = catalogue_.nominal()[c];
      s_.linearise(prompt, s_.with_biases(rest), false);
      latency_delta_chi2_[late] = loss_of(rest);
    }
    s_.linearise(value, s_.all_columns());
    if (!anew || latency_delta_chi2_.empty()) return;
    const double loss = loss_of(chosen);
    for (auto& [late, delta_chi2] : latency_delta_chi2_) delta_chi2 -= loss;
  }
  // Δχ² without an effect, whose linear model says `linear`
  double delta_chi2_of(int group, double linear) const {
    const auto flown = latency_delta_chi2_.find(group);
    return flown == latency_delta_chi2_.end() ? linear : std::max(linear, flown->second);
  }

  // Backward: what is not material, not significant or not possible goes, the weakest first. What would leave together is significant
  // together (a drag beside a wind that it alone feels), and what leaves its bounds is possible if it pays at them, too.
  void prune(const Grams& grams, std::vector<int>& chosen, const Eigen::MatrixXd& total, double loss_none) const {
    const SubsetSearch search(catalogue_, s_.vehicle(), 0.0);
    while (!chosen.empty()) {
      const std::vector<int> columns = s_.with_biases(chosen);
      const Fit fit = solve(total, columns);
      const Eigen::VectorXd value = value_at(catalogue_, columns, fit);
      const Eigen::MatrixXd covariance = clustered_covariance(grams, columns, fit.coefficient);
      const double needed = material(grams.rows, std::max(0.0, loss_none - fit.loss));
      int worst = -1;
      double worst_delta_chi2 = 0.0;
      for (const int g : chosen) {
        const double without = solve(total, s_.with_biases(search.without(chosen, g))).loss;
        const double delta_chi2 = delta_chi2_of(g, without - fit.loss);
        const bool is_possible = s_.shoots() || possible(catalogue_, value, g) ||
                                 without - search.loss_within_bounds(total, columns, fit, g) >= needed;
        const std::vector<Eigen::Index> own = search.leaving(chosen, g);
        const Eigen::VectorXd b = fit.coefficient(own);
        Eigen::MatrixXd block = covariance(own, own);
        block.diagonal().array() += 1e-18;
        const double wald = b.dot(block.ldlt().solve(b));
        const double p = boost::math::cdf(
            boost::math::complement(boost::math::chi_squared(static_cast<double>(own.size())), std::max(0.0, wald)));
        const bool bad = delta_chi2 < needed || !is_possible ||
                         !(p < decisions::wald_p / static_cast<double>(catalogue_.groups().size()));
        if (bad && (worst < 0 || delta_chi2 < worst_delta_chi2)) worst = g, worst_delta_chi2 = delta_chi2;
      }
      if (worst < 0) return;
      chosen = search.without(chosen, worst);
    }
  }

  // replace each selected effect by every other, one at a time; the nearest stay
  void rivals(Selection& result, const std::vector<int>& chosen, const Fit& fit) const {
    const Eigen::MatrixXd total = result.grams.total();
    const Eigen::VectorXd own = block_losses(result.grams, s_.with_biases(chosen), fit.coefficient);
    const SubsetSearch search(catalogue_, s_.vehicle(), 0.0);
    parallel_for(std::ssize(result.findings), s_.jobs(), [&](std::int64_t at) {
      Finding& finding = result.findings[static_cast<std::size_t>(at)];
      // of a latency of which the linear model knows next to nothing it knows no rivals either
      const double linear = solve(total, s_.with_biases(search.without(chosen, finding.group))).loss - fit.loss;
      if (delta_chi2_of(finding.group, linear) > 2.0 * linear) return;
      std::vector<std::pair<int, Exchange>> exchanges;
      for (const int other : search.candidates)
        if (std::optional<Exchange> e = exchange(total, search, chosen, fit, finding.group, other))
          exchanges.emplace_back(other, std::move(*e));
      std::ranges::stable_sort(exchanges, {}, [](const auto& e) { return e.second.delta_chi2(); });
      if (std::ssize(exchanges) > most_rivals) exchanges.erase(exchanges.begin() + most_rivals, exchanges.end());
      for (const auto& [other, e] : exchanges) {
        const Eigen::VectorXd difference =
            block_losses(result.grams, s_.with_biases(e.groups), e.fit.coefficient) -
            (e.trim ? block_losses(result.grams, s_.with_biases(e.kept), e.kept_fit.coefficient) : own);
        const Eigen::VectorXd value = value_at(catalogue_, s_.with_biases(e.groups), e.fit);
        finding.rivals.push_back({other, paired_z(result.grams, difference), e.delta_chi2(), e.trim,
                                  size_in_naturals(catalogue_, value, other)});
      }
    });
  }

  Session& s_;
  const Catalogue& catalogue_;
  std::set<int> left_out_;  // groups that are not asked
  Eigen::VectorXd natural_;
  std::set<std::vector<int>> winds_tried_;
  std::map<int, double> latency_delta_chi2_;
  bool anew_ = false;  // linearised about what was found
  Improve improve_ = Improve::freely;
};

std::set<int> with_bounds(std::set<int> left_out, const Selection& before) {
  left_out.insert(before.at_bounds.begin(), before.at_bounds.end());
  return left_out;
}

std::vector<int> groups_at_bounds(const Session& session, const Selection& selection) {
  std::vector<int> groups;
  for (const Finding& finding : selection.findings)
    if (!finding.calibration && at_its_bound(session.catalogue(), selection.value, finding.group))
      groups.push_back(finding.group);
  return groups;
}

// What `select` finds, begun anew without the groups that have a value at its bound, until there are none; or what is left of the selection
// before without them, if the flights are likelier with it.
template <typename Select>
Selection within_bounds(Session& session, std::set<int> at_bounds, Select select) {
  const Session::Learned fresh = session.learned();
  std::optional<Settled> left;
  while (true) {
    Selection selection = select(Selector(session, at_bounds));
    selection.at_bounds = at_bounds;
    const std::vector<int> ran_away = groups_at_bounds(session, selection);
    at_bounds.insert(ran_away.begin(), ran_away.end());
    // what was asked for stays, wherever it ran to
    if (at_bounds == selection.at_bounds) {
      if (!left || selection.how_unlikely <= left->selection.how_unlikely) return selection;
      left->selection.at_bounds = at_bounds;
      return go_back(session, std::move(*left));
    }
    if (left && std::ranges::any_of(left->selection.groups(), [&](int g) { return at_bounds.contains(g); }))
      left.reset();
    Selection rest = Selector(session, at_bounds).without(selection, ran_away, Improve::freely);
    if (groups_at_bounds(session, rest).empty() && (!left || rest.how_unlikely < left->selection.how_unlikely))
      left = settled(session, std::move(rest));
    session.put_back(fresh);
  }
}

}  // namespace

Selection select_effects(Session& session) { return Selector(session).run(); }

Selection select_within_bounds(Session& session) {
  return within_bounds(session, {}, [&](Selector selector) { return selector.run(); });
}

Selection withdraw(Session& session, const Selection& before, const std::vector<int>& groups,
                   const std::set<int>& left_out) {
  return Selector(session, with_bounds(left_out, before)).without(before, groups);
}

Selection exchange(Session& session, const Selection& before, int group, int other, const std::set<int>& left_out) {
  std::vector<int> groups = before.groups();
  std::ranges::replace(groups, group, other);
  std::ranges::sort(groups);
  return Selector(session, with_bounds(left_out, before)).given(before, groups);
}

Selection with_also(Session& session, const Selection& before, const std::vector<int>& groups,
                    const Eigen::VectorXd& start) {
  return within_bounds(session, before.at_bounds,
                       [&](Selector selector) { return selector.with_also(before, groups, start); });
}

Eigen::VectorXd values_with(Session& session, const std::vector<int>& groups, const Eigen::VectorXd& start) {
  return Selector(session).values_with(groups, start);
}

std::optional<Selection> look_again(Session& session, const Selection& before, std::set<std::vector<int>>& tried,
                                    const std::set<int>& left_out) {
  return Selector(session, with_bounds(left_out, before)).with_more(before, tried);
}

}  // namespace gustlab::diagnosis
