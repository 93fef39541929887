#include "diagnosis/evidence/challenge.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/selection/select_effects.hpp"
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

// Δχ² of leaving some findings out together, all others fitted anew.
double delta_chi2_of_all(const Session& session, const Selection& selection, const std::vector<std::size_t>& some) {
  std::vector<int> rest = selection.groups();
  for (const std::size_t i : some) std::erase(rest, selection.findings[i].group);
  return solve(selection.grams.total(), session.with_biases(rest)).loss - selection.loss_selected;
}

std::vector<std::size_t> failing(const Session& session, const Selection& selection,
                                 const std::vector<Evidence>& records, const std::vector<int>& means,
                                 double stands_from) {
  std::vector<std::size_t> at_once, doubtful;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (selection.findings[i].calibration) continue;
    if (std::ranges::count(means, records[i].group) > 0) at_once.push_back(i);
    else if (records[i].probability < stands_from) doubtful.push_back(i);
  }
  return weakest(records, std::move(at_once), std::move(doubtful),
                 [&](const std::vector<std::size_t>& some) { return delta_chi2_of_all(session, selection, some); });
}

// groups that are named or suspected, sorted
std::vector<int> likely(const std::vector<Evidence>& records) {
  std::vector<int> groups;
  for (const Evidence& record : records)
    if (record.probability >= decisions::suspected_from) groups.push_back(record.group);
  std::ranges::sort(groups);
  return groups;
}

// Looks at what was withdrawn, once all that is left stands: what went beside a wrong partner may come back when that has gone too.
class Looks {
 public:
  // The set to be judged next; nothing: what stands is the answer.
  std::optional<Selection> next(Session& session, const Selection& standing, std::vector<int> names,
                                const std::set<int>& left_out) {
    if (over_) return std::nullopt;
    if (before_ && !std::ranges::includes(names, names_) && !explains_more(session, standing, *before_)) {
      over_ = true;  // what came back has cost a name: as it was
      return withdraw(session, *before_, {}, left_out);
    }
    // a look that brings no name back is the last, but for what it leaves room for
    if ((before_ && names == names_ && left_out == left_out_) || tried_.size() >= most_looks) return std::nullopt;
    before_ = standing, names_ = std::move(names), left_out_ = left_out;
    return look_again(session, standing, tried_, left_out_);
  }

 private:
  std::set<std::vector<int>> tried_;
  std::optional<Selection> before_;  // the last look, and which of its names
  std::vector<int> names_;
  std::set<int> left_out_;  // not asked any more
  bool over_ = false;
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

std::vector<std::size_t> weakest(const std::vector<Evidence>& records, std::vector<std::size_t> at_once,
                                 std::vector<std::size_t> doubtful,
                                 const std::function<double(const std::vector<std::size_t>&)>& delta_chi2_of_all) {
  std::vector<std::size_t> going = std::move(at_once);
  const auto first = std::ssize(going);
  std::ranges::stable_sort(doubtful, {}, [&](std::size_t i) { return records[i].probability; });
  double sum = 0.0;
  for (const std::size_t i : going) sum += records[i].delta_chi2;
  for (const std::size_t i : doubtful) {
    if (!going.empty() && records[i].probability >= decisions::hopeless) break;
    if (records[i].alike > 0 &&
        std::ranges::any_of(going, [&](std::size_t other) { return records[other].effect == records[i].effect; }))
      continue;
    going.push_back(i);
    sum += records[i].delta_chi2;
    if (going.size() > 1 && delta_chi2_of_all(going) > decisions::most_joint_delta_chi2 * sum) {
      sum -= records[i].delta_chi2;
      going.pop_back();
    }
  }
  // what gains most may only stand beside a wrong partner
  if (std::ssize(going) - first > 1) {
    const auto most = std::ranges::max_element(going.begin() + first, going.end(), {}, [&](std::size_t i) {
      return records[i].at_bound ? 0.0 : records[i].robust_delta_chi2();
    });
    going.erase(most);
  }
  return going;
}

Challenge challenge(Session& session, Selection& selection, const HeldOut& held,
                    const std::function<std::optional<double>()>& most_pose_latency_s, int jobs, double stands_from) {
  Challenge result;
  const std::vector<Recording> to_fly = recordings_to_fly(held.logs, session.vehicle());
  Looks looks;
  std::set<int> went, left_out;  // withdrawn once; again, or at its bound
  bool without_forces_per_flight = false;
  while (true) {
    const HoldoutTest tested = test_holdout(session, selection, held.read, held.own_rate, jobs);
    result.regimes = regimes(session, selection);
    result.rest = remainder(session, selection, without_forces_per_flight);
    result.records = gather_evidence(session, selection, tested, result.regimes, result.rest);
    fly_without_each(to_fly, session.vehicle().effects, effects_found(session.catalogue(), selection), jobs,
                     result.records);
    for (Evidence& record : result.records) {
      ask_sensors(session, selection, most_pose_latency_s, record);
      judge(record);
    }
    const std::vector<std::size_t> failed = failing(
        session, selection, result.records,
        result.rest.gust_like ? means_of_gust(session, selection, result.rest.gust) : std::vector<int>{}, stands_from);
    if (failed.empty()) {
      if (result.withdrawn.empty()) break;
      std::optional<Selection> next = looks.next(session, selection, likely(result.records), left_out);
      if (!next) break;
      selection = std::move(*next);
      continue;
    }
    std::vector<int> groups;
    for (const std::size_t i : failed) {
      groups.push_back(result.records[i].group);
      if (!went.insert(groups.back()).second || result.records[i].at_bound) left_out.insert(groups.back());
      without_forces_per_flight |= session.catalogue().group(groups.back()).row->per_flight;
      std::erase_if(result.withdrawn, [&](const Evidence& before) { return before.group == groups.back(); });
      result.withdrawn.push_back(result.records[i]);
    }
    selection = withdraw(session, selection, groups, left_out);
  }
  std::erase_if(result.withdrawn, [&](const Evidence& before) {
    return std::ranges::any_of(result.records, [&](const Evidence& r) { return r.group == before.group; });
  });
  return result;
}

}  // namespace gustlab::diagnosis
