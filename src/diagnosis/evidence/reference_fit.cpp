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

ReferenceFit fit_reference(const std::vector<FlightData>& flights, const std::vector<FlightData>& own_rate,
                           const VehicleModel& vehicle, int jobs) {
  Session session(flights, vehicle, jobs, own_rate);
  Selection selection = select_effects(session);
  // what is left out here comes back as a change: only what is hopeless goes
  challenge(
      session, selection, {}, [] { return std::nullopt; }, jobs, decisions::hopeless);
  const Catalogue& catalogue = session.catalogue();
  const std::vector<EffectSpec> all = effects_found(catalogue, selection);
  ReferenceFit fit{vehicle, {}, {}};
  std::vector<EffectSpec> shared;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Group& group = catalogue.group(selection.findings[i].group);
    if (group.row->per_flight || group.row->is_history()) continue;
    shared.push_back(all[i]);
    EffectFinding& effect = fit.effects.emplace_back();
    effect.effect = group.row->name;
    effect.place = to_string(group.row->place);
    effect.says = group.row->says;
    effect.confidence = selection.findings[i].inclusion;
    effect.delta_chi2 = selection.findings[i].delta_chi2;
    effect.classmates = {effect.effect};
    effect.parameters = values_of(catalogue, selection, group, -1);
  }
  fit.vehicle.effects = config::merge_effects(vehicle.effects, shared);

  // about what was found, under the noise that was left then
  std::vector<FlightData> again = flights, again_own_rate = own_rate;
  for (auto* some : {&again, &again_own_rate})
    for (FlightData& flight : *some) flight.vehicle.effects = fit.vehicle.effects;
  Session about(std::move(again), fit.vehicle, jobs, std::move(again_own_rate));
  about.noise = selection.noise_selected;
  about.linearise(about.catalogue().nominal(), about.all_columns());
  about.take_weights(session);
  std::vector<int> free = about.biases();
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    const int same = about.catalogue().find(group.label);
    if (group.row->per_flight && same >= 0) {
      const auto& own = about.catalogue().group(same).columns;
      free.insert(free.end(), own.begin(), own.end());
    }
  }
  fit.known = reference_of(about.catalogue(), about.grams(), free);
  fit.known.of_each_flight = sizes_of_each_flight(catalogue, selection, flights.size());
  return fit;
}

}  // namespace gustlab::diagnosis
