#include "diagnosis/evidence/usual_names.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "diagnosis/selection/select_effects.hpp"

namespace gustlab::diagnosis {

namespace {

std::ptrdiff_t names(const std::vector<Evidence>& records) {
  return std::ranges::count_if(records, [](const Evidence& r) { return r.probability >= decisions::named_from; });
}

// what was judged before, up to the set in which one label gave its place to the other, belongs to the answer, too
void add_before(Challenge& judged, Challenge before, const std::string& name, const std::string& usual) {
  for (JudgedSet& set : before.history)
    if (std::exchange(set.answer, false)) set.withdrawn = {name}, set.in_its_place = usual;
  judged.history.insert(judged.history.begin(), before.history.begin(), before.history.end());
  for (Evidence& went : before.withdrawn) {
    const auto is_it = [&](const Evidence& other) { return other.group == went.group; };
    if (std::ranges::none_of(judged.records, is_it) && std::ranges::none_of(judged.withdrawn, is_it))
      judged.withdrawn.push_back(std::move(went));
  }
}

// Δχ² that is lost with the second set in place of the first, less what its numbers cost
double lost(const Session& session, const Selection& selection, const Selection& other) {
  const auto unlikely = [&](const Selection& of) {
    return of.how_unlikely - of.grams.price(session.with_biases(of.groups()).size());
  };
  return unlikely(other) - unlikely(selection);
}

}  // namespace

std::optional<Rival> far_more_usual_rival(const Catalogue& catalogue, const Selection& selection,
                                          const Finding& finding, const std::set<int>& tried) {
  const double size = size_in_naturals(catalogue, selection.value, finding.group);
  std::optional<Rival> best;
  for (const Rival& rival : finding.rivals)
    if (equal(rival, finding) && !rival.below_tolerance && !tried.contains(rival.group) &&
        is_far_more_usual(rival.size_in_naturals, size) && !(best && best->size_in_naturals <= rival.size_in_naturals))
      best = rival;
  return best;
}

void say_usual_names(Session& session, Selection& selection, Challenge& judged,
                     const std::function<Challenge(Selection&)>& judge) {
  std::set<int> tried;
  for (std::size_t i = 0; i < selection.findings.size();) {
    const Finding finding = selection.findings[i];
    const bool named = !finding.calibration && judged.records[i].probability >= decisions::named_from;
    std::optional<Rival> rival =
        named ? far_more_usual_rival(session.catalogue(), selection, finding, tried) : std::nullopt;
    if (!rival) {
      ++i;
      continue;
    }
    tried.insert({finding.group, rival->group});
    std::vector<int> groups = selection.groups();
    std::ranges::replace(groups, finding.group, rival->group);
    std::ranges::sort(groups);
    Settled before = settled(session, selection);
    Selection other = exchange(session, selection, finding.group, rival->group);
    rival->delta_chi2 = lost(session, selection, other);
    std::optional<Challenge> again;
    if (other.groups() == groups && equal(*rival, finding)) again = judge(other);
    if (again && other.groups() == groups && names(again->records) >= names(judged.records)) {
      add_before(*again, std::move(judged), session.catalogue().group(finding.group).label,
                 session.catalogue().group(rival->group).label);
      judged = std::move(*again);
      selection = std::move(other);
      i = 0;
    } else {
      selection = go_back(session, std::move(before));
    }
  }
}

}  // namespace gustlab::diagnosis
