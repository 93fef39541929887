#include "diagnosis/evidence/reference_fit.hpp"

#include <cmath>
#include <map>

#include "config/toml.hpp"
#include "diagnosis/evidence/challenge.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/selection/select_effects.hpp"

namespace gustlab::diagnosis {

namespace {

// Root mean squares over the flights of what each has for itself, by group and parameter.
std::map<std::pair<std::string, int>, double> sizes_of_each_flight(const Catalogue& catalogue,
                                                                   const Selection& selection, std::size_t flights) {
  std::map<std::pair<std::string, int>, double> sizes;
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    for (const int c : group.columns)
      if (const Column& column = catalogue.column(c); column.flight >= 0)
        sizes[{group.label, column.parameter}] += std::pow(selection.value[c], 2) / static_cast<double>(flights);
  }
  for (auto& [name, size] : sizes) size = std::sqrt(size);
  return sizes;
}

}  // namespace

ReferenceFlights::ReferenceFlights(std::vector<FlightData> flights, std::vector<FlightData> own_rate,
                                   std::vector<FlightLog> logs, const VehicleModel& vehicle, int jobs)
    : session_(std::move(flights), vehicle, jobs, std::move(own_rate)), selection_(select_effects(session_)) {
  // what is left out here comes back as a change
  challenge(
      session_, selection_, {{}, {}, std::move(logs)}, [] { return std::nullopt; }, session_.jobs(),
      decisions::reference_stays_from);
}

bool ReferenceFlights::have(const Catalogue& catalogue, const Selection& found, const std::vector<int>& changed) {
  const Catalogue& own = session_.catalogue();
  std::vector<int> groups;
  Eigen::VectorXd start = selection_.value;
  for (const int g : changed) {
    const Group& group = catalogue.group(g);
    const int same = own.find(group.label);
    if (same < 0 || group.row->per_flight || group.row->is_history()) continue;
    groups.push_back(same);
    for (const int c : own.group(same).columns)
      for (const int there : group.columns)
        if (catalogue.column(there).parameter == own.column(c).parameter) start[c] = found.value[there];
  }
  if (groups.empty()) return false;
  Session::Learned kept = session_.learned();
  Selection with_them = with_also(session_, selection_, groups, start);
  if (with_them.groups() == selection_.groups() || !explains_more(session_, with_them, selection_)) {
    session_.put_back(std::move(kept));
    return false;
  }
  selection_ = std::move(with_them);
  return true;
}

ReferenceFit ReferenceFlights::fit() const {
  const Catalogue& catalogue = session_.catalogue();
  const std::vector<EffectSpec> all = effects_found(catalogue, selection_);
  ReferenceFit fit{session_.vehicle(), {}, {}};
  std::vector<EffectSpec> shared;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Group& group = catalogue.group(selection_.findings[i].group);
    if (group.row->per_flight || group.row->is_history()) continue;
    shared.push_back(all[i]);
    EffectFinding& effect = fit.effects.emplace_back();
    effect.effect = group.row->name;
    effect.place = to_string(group.row->place);
    effect.says = group.row->says;
    effect.confidence = selection_.findings[i].inclusion;
    effect.delta_chi2 = selection_.findings[i].delta_chi2;
    effect.classmates = {effect.effect};
    effect.parameters = values_of(catalogue, selection_, group, -1);
  }
  fit.vehicle.effects = config::merge_effects(session_.vehicle().effects, shared);

  // about what was found, under the noise that was left then
  std::vector<FlightData> again = session_.flights(), again_own_rate;
  if (session_.shoots()) again_own_rate = session_.flights_as_logged();
  for (auto* some : {&again, &again_own_rate})
    for (FlightData& flight : *some) flight.vehicle.effects = fit.vehicle.effects;
  Session about(std::move(again), fit.vehicle, session_.jobs(), std::move(again_own_rate));
  about.noise = selection_.noise_selected;
  about.linearise(about.catalogue().nominal(), about.all_columns());
  about.take_weights(session_);
  std::vector<int> free = about.biases();
  for (const Finding& finding : selection_.findings) {
    const Group& group = catalogue.group(finding.group);
    const int same = about.catalogue().find(group.label);
    if (group.row->per_flight && same >= 0) {
      const auto& own = about.catalogue().group(same).columns;
      free.insert(free.end(), own.begin(), own.end());
    }
  }
  fit.known = reference_of(about.catalogue(), about.grams(), free);
  fit.known.of_each_flight = sizes_of_each_flight(catalogue, selection_, session_.flights().size());
  return fit;
}

}  // namespace gustlab::diagnosis
