#include "diagnosis/evidence/challenge.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/validation/gust_parts.hpp"
#include "diagnosis/validation/regimes.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr std::size_t most_looks = 3;  // at what was withdrawn, each beside other names

// a delay of the pose that gyro and attitudes show by themselves, whatever the forces are
void ask_sensors(const Session& session, const Selection& selection,
                 const std::function<std::optional<double>()>& most_pose_latency_s, Evidence& record) {
  const Group& group = session.catalogue().group(record.group);
  if (group.row->place != Place::measurement) return;
  for (const int c : group.columns) {
    const Column& column = session.catalogue().column(c);
    if (column.unit != "s") continue;
    if (const std::optional<double> shown_s = most_pose_latency_s())
      record.sensors_share = *shown_s / (selection.value[c] - column.nominal);
  }
}

std::vector<std::size_t> failing(const Selection& selection, const std::vector<Evidence>& records,
                                 const std::vector<int>& means, double stays_from) {
  std::vector<std::size_t> at_once, doubtful;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (selection.findings[i].calibration) continue;
    if (std::ranges::count(means, records[i].group) > 0) at_once.push_back(i);
    else if (records[i].probability < stays_from) doubtful.push_back(i);
  }
  if (at_once.empty() && !doubtful.empty()) at_once.push_back(weakest(records, std::move(doubtful)));
  return at_once;
}

// groups that stay, sorted
std::vector<int> likely(const std::vector<Evidence>& records) {
  std::vector<int> groups;
  for (const Evidence& record : records)
    if (record.probability >= decisions::stays_from) groups.push_back(record.group);
  std::ranges::sort(groups);
  return groups;
}

JudgedSet judged_set(const Selection& selection, const std::vector<Evidence>& records) {
  JudgedSet set;
  set.minus_two_log_likelihood = selection.how_unlikely;
  for (const Evidence& record : records) set.names.push_back({record.effect, record.rotor, record.probability});
  return set;
}

// All of a set stands: what a look at what was withdrawn is measured by.
struct Stood {
  Settled settled;
  Challenge judged;
  std::vector<int> names;
  std::set<int> left_out;  // not asked any more
  bool one_back = false;   // the look is at one name, not by a search
};

// the set that was the answer when a history was this long
std::size_t answer_of(const std::vector<JudgedSet>& history) {
  const auto answer = std::ranges::find(history, true, &JudgedSet::answer);
  return static_cast<std::size_t>((answer == history.end() ? std::prev(answer) : answer) - history.begin());
}

// Looks at what was withdrawn, once all that is left stands: what went beside a wrong partner may come back when that has gone too.
class Looks {
 public:
  void saw(const Selection& selection, const std::vector<Evidence>& records) {
    judged_.insert(joined(selection.groups(), {}));
    for (std::size_t i = 0; i < records.size(); ++i)
      if (double& most = likeliest_[records[i].group]; !selection.findings[i].calibration)
        most = std::max(most, records[i].probability);
  }

  // The set to be judged next; nothing: `selection`, as `judged`, is the answer. A look that has cost a name and explains no more was in
  // vain, and one at a single name that ended where it began: then that is the set before it, with what was learned beside it.
  std::optional<Selection> next(Session& session, Selection& selection, Challenge& judged,
                                const std::set<int>& left_out) {
    std::vector<int> names = likely(judged.records);
    const bool same = before_ && names == before_->names;
    const bool in_vain = before_ && (same ? before_->one_back
                                          : !std::ranges::includes(names, before_->names) &&
                                                !explains_more(session, selection, before_->settled.selection));
    // a look that brings no name back is the last, but for what it leaves room for
    const bool last = same && left_out == before_->left_out;
    if (in_vain) back(session, selection, judged);
    if (in_vain || last || tried_.size() >= most_looks) return with_one_back(session, selection, judged, left_out);
    before_ = Stood{settled(session, selection), judged, std::move(names), left_out};
    std::optional<Selection> more = look_again(session, selection, tried_, left_out);
    return more ? std::move(more) : with_one_back(session, selection, judged, left_out);
  }

 private:
  void back(Session& session, Selection& selection, Challenge& judged) {
    Stood stood = std::move(*before_);
    before_.reset();
    selection = go_back(session, std::move(stood.settled));
    const std::size_t answer = answer_of(stood.judged.history);
    stood.judged.withdrawn = std::move(judged.withdrawn);
    stood.judged.history = std::move(judged.history);
    stood.judged.history[answer].answer = true;
    judged = std::move(stood.judged);
  }

  std::optional<Selection> with_one_back(Session& session, const Selection& selection, Challenge& judged,
                                         const std::set<int>& left_out) {
    const std::optional<int> group = comes_back(session, selection, likeliest_, judged_);
    if (!group) return std::nullopt;
    judged_.insert(joined(selection.groups(), {*group}));
    before_ = Stood{settled(session, selection), judged, likely(judged.records), left_out, true};
    for (JudgedSet& set : judged.history) set.answer = false;
    return with_also(session, selection, {*group}, selection.value);
  }

  std::set<std::vector<int>> tried_, judged_;
  std::map<int, double> likeliest_;  // of every group, its largest probability in any set
  std::optional<Stood> before_;      // the last look
};

}  // namespace

bool explains_more(const Session& session, const Selection& one, const Selection& other) {
  double better = 0.0;
  for (const Selection* about : {&one, &other}) {
    const Eigen::MatrixXd total = about->grams.total();
    const auto score = [&](const Selection& of) {
      const std::vector<int> columns = session.with_biases(of.groups());
      return solve(total, columns).loss + about->grams.price(columns.size());
    };
    better += score(other) - score(one);
  }
  return better > 0.0;
}

std::size_t weakest(const std::vector<Evidence>& records, std::vector<std::size_t> doubtful) {
  const auto gains = [&](std::size_t i) { return records[i].at_bound ? 0.0 : records[i].robust_delta_chi2(); };
  const auto most = std::ranges::max_element(doubtful, {}, gains);
  if (doubtful.size() > 1 && probability_without_others(records[*most]) >= decisions::hopeless) doubtful.erase(most);
  std::vector<std::size_t> hopeless = doubtful;
  std::erase_if(hopeless, [&](std::size_t i) { return records[i].probability >= decisions::hopeless; });
  if (!hopeless.empty()) return *std::ranges::min_element(hopeless, {}, gains);
  return *std::ranges::min_element(doubtful, {}, [&](std::size_t i) { return records[i].probability; });
}

std::optional<int> nearest_rival(const Catalogue& catalogue, const Selection& selection, const Finding& finding,
                                 const Evidence& record, const std::set<int>& asked) {
  constexpr std::size_t half_a_second = 1;
  if (record.at_bound || record.recovered_z.size() <= half_a_second ||
      record.recovered_z[half_a_second] < decisions::surely_needed)
    return std::nullopt;
  for (const Rival& rival : finding.rivals)
    if (rival.delta_chi2 < decisions::most_lost_to_rival * finding.delta_chi2 && !rival.below_tolerance &&
        !catalogue.group(rival.group).row->per_flight && !asked.contains(rival.group) &&
        !selection.at_bounds.contains(rival.group))
      return rival.group;
  return std::nullopt;
}

std::optional<int> comes_back(const Session& session, const Selection& selection,
                              const std::map<int, double>& likeliest, const std::set<std::vector<int>>& judged) {
  const SubsetSearch search(session.catalogue(), session.vehicle(), 0.0);
  for (const auto& [group, probability] : likeliest) {
    if (probability < decisions::named_from || session.catalogue().group(group).row->per_flight ||
        selection.find(group) || selection.at_bounds.contains(group))
      continue;
    const std::vector<int> groups = joined(selection.groups(), {group});
    if (search.allowed(groups) && !judged.contains(groups)) return group;
  }
  return std::nullopt;
}

Challenge challenge(Session& session, Selection& selection, const HeldOut& held,
                    const std::function<std::optional<double>()>& most_pose_latency_s, int jobs, double stays_from) {
  Challenge result;
  const std::vector<Recording> to_fly = recordings_to_fly(held.logs, session.vehicle());
  Looks looks;
  std::set<int> went, left_out;  // withdrawn once; again, or at its bound
  bool without_forces_per_flight = false;
  while (true) {
    const HoldoutTest tested = test_holdout(session, selection, held.read, held.own_rate, jobs);
    result.regimes = regimes(session, selection);
    result.records = gather_evidence(session, selection, tested, result.regimes);
    fly_without_each(to_fly, session.vehicle().effects, effects_found(session.catalogue(), selection), jobs,
                     result.records);
    for (Evidence& record : result.records) {
      ask_sensors(session, selection, most_pose_latency_s, record);
      judge(record);
    }
    looks.saw(selection, result.records);
    result.history.push_back(judged_set(selection, result.records));
    // whether anything else is left, of a set that stands alone: asked of every set it took an eighth of a diagnosis
    result.rest = lasting_push(session, selection, without_forces_per_flight);
    const bool may_be_gust = result.rest.gust_like;
    if (may_be_gust) ask_rest(session, selection, result.rest);
    const std::vector<int> means =
        result.rest.gust_like ? means_of_gust(session, selection, result.rest.gust) : std::vector<int>{};
    const std::vector<std::size_t> failed = failing(selection, result.records, means, stays_from);
    if (failed.empty()) {
      if (!may_be_gust) ask_rest(session, selection, result.rest);
      if (result.withdrawn.empty()) break;
      std::optional<Selection> next = looks.next(session, selection, result, left_out);
      if (!next) break;
      selection = std::move(*next);
      continue;
    }
    std::optional<int> rival;
    if (means.empty())
      rival = nearest_rival(session.catalogue(), selection, selection.findings[failed.front()],
                            result.records[failed.front()], went);
    std::vector<int> groups;
    for (const std::size_t i : failed) {
      groups.push_back(result.records[i].group);
      if (!went.insert(groups.back()).second || result.records[i].at_bound) left_out.insert(groups.back());
      without_forces_per_flight |= session.catalogue().group(groups.back()).row->per_flight;
      std::erase_if(result.withdrawn, [&](const Evidence& before) { return before.group == groups.back(); });
      result.withdrawn.push_back(result.records[i]);
      result.history.back().withdrawn.push_back(session.catalogue().group(groups.back()).label);
    }
    if (rival) result.history.back().in_its_place = session.catalogue().group(*rival).label;
    selection = rival ? exchange(session, selection, groups.front(), *rival, left_out)
                      : withdraw(session, selection, groups, left_out);
  }
  if (std::ranges::none_of(result.history, &JudgedSet::answer)) result.history.back().answer = true;
  std::erase_if(result.withdrawn, [&](const Evidence& before) {
    return std::ranges::any_of(result.records, [&](const Evidence& r) { return r.group == before.group; });
  });
  return result;
}

}  // namespace gustlab::diagnosis
