#include "diagnosis/output/weak_points.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnosis/evidence/judge.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr const char* changes = "its size changes from one part of a flight to the next";

std::string of_gain(const Evidence& e) {
  constexpr double twice = 2.0;
  if (twice * e.delta_chi2_with_partner < e.delta_chi2)
    return "it and another name undo each other: without both the predictions are hardly worse";
  const double moved = e.surrogates.movable ? e.surrogates.inflation : 1.0;
  if (std::max(moved, e.clustered_inflation) < twice) return "the flights are hardly likelier with it";
  return moved > e.clustered_inflation ? "moved along the flight it gains a large part of what it gains in its place"
                                       : changes;
}

std::string of_moved_signature(const Evidence& e) {
  if (!e.surrogates.movable) return "it is the same at all times, so that no moment of the flight can test it";
  return e.surrogates.p_value > 0.5 ? "moved along the flight it fits as well"
                                    : fmt::format("moved along the flight it fits as well in {:.2g} % of the cases",
                                                  100.0 * e.surrogates.p_value);
}

constexpr const char* own_values = "each flight has its own values of it, so that no other flight can test them";

std::string of_flights(const Evidence& e) {
  if (e.per_flight) return own_values;
  return e.flights_against() > 0
             ? fmt::format("{} of {} flights speak against it", e.flights_against(), e.flights.size())
             : fmt::format("only {} of {} flights show it clearly", e.flights_for(), e.flights.size());
}

std::string of_held_out(const Evidence& e) {
  if (e.per_flight) return own_values;
  if (e.held_out_expected < 10.0) return "the held-out flights show too little to test it";
  return e.held_out_delta_chi2 > 0.0 ? "on the held-out flights it helps less than it should"
                                     : "it does not help on the held-out flights";
}

std::string of_regimes(const Evidence& e) {
  return e.spread_regimes == 1.0 ? "whether its size is the same in fast and slow flight cannot be told"
                                 : "its size differs between fast and slow, or high and low flight";
}

// held-out flights, simulated with it and without
std::string of_rollout(const Evidence& e, std::size_t horizon, const char* ahead) {
  if (e.recovered_z.size() <= horizon) return "no held-out flight could be simulated with it";
  return fmt::format("simulated {} ahead, the held-out flights are predicted {} with it", ahead,
                     e.recovered_z[horizon] < -1.0 ? "worse" : "hardly better");
}

std::string of_predictions(const Evidence& e) {
  if (e.per_flight) return own_values;
  return e.uneven > 0.0 ? changes : of_rollout(e, 1, "0.5 s");
}

struct Words {
  std::string_view feature;
  std::string (*say)(const Evidence&);
};

// of every feature of the judge
constexpr Words words[] = {
    {"gain", of_gain},
    {"alone", [](const Evidence&) -> std::string { return "it gains little by itself"; }},
    {"surrogate", of_moved_signature},
    {"material",
     [](const Evidence&) -> std::string { return "it is hardly larger than the usual scatter of a build"; }},
    {"flights", of_flights},
    {"flights_alike",
     [](const Evidence& e) -> std::string { return e.per_flight ? own_values : "its size differs between flights"; }},
    {"held_out", of_held_out},
    {"regimes_alike", of_regimes},
    {"slow_fast",
     [](const Evidence&) -> std::string { return "it is of another size in fast changes than in slow ones"; }},
    {"rollout_100ms", [](const Evidence& e) { return of_rollout(e, 0, "0.1 s"); }},
    {"rollout_500ms", [](const Evidence& e) { return of_rollout(e, 1, "0.5 s"); }},
    {"predicts", of_predictions},
    {"rival", [](const Evidence&) -> std::string { return "another name explains nearly the same"; }},
    {"commands", [](const Evidence&) -> std::string { return "it may come from commands that the log does not hold"; }},
    {"force_and_moment",
     [](const Evidence& e) {
       return fmt::format("its push is {:.0f} % {} than its turn says", 100.0 * std::abs(e.force_excess),
                          e.force_excess > 0.0 ? "larger" : "smaller");
     }},
    {"stable",
     [](const Evidence& e) {
       return fmt::format("of random halves of the data only {:.0f} % select it", 100.0 * e.inclusion);
     }},
    {"sensors",
     [](const Evidence&) -> std::string { return "gyroscope and attitude by themselves leave no room for it"; }},
    {"bounds", [](const Evidence&) -> std::string { return "a number of it ended at the limit of what is allowed"; }},
    {"single",
     [](const Evidence&) -> std::string {
       return "the same effect, or one like it, was found beside it, and two at once are rare";
     }},
    {"latency",
     [](const Evidence&) -> std::string {
       return "one reference flight alone does not tell surely how late its rotors answered";
     }},
    {"slow_speeds",
     [](const Evidence&) -> std::string {
       return "the slow changes of the rotors' speeds are not that late: it averages commands that jitter";
     }},
    {"between_rows",
     [](const Evidence&) -> std::string {
       return "the body turns between rows as rotors make it that are not that late: the command of a row falls until "
              "the next row";
     }},
    {"undone",
     [](const Evidence& e) {
       return fmt::format("the other names take back {:.0f} % of what it does", 100.0 * e.undone);
     }},
    {"outweighed",
     [](const Evidence& e) {
       return fmt::format("the other names do {:.1f} times as much against it as it does", e.outweighed);
     }},
    {"dwarfed",
     [](const Evidence& e) {
       return fmt::format(
           "another name does {:.0f} times as much where it shows, and what its model leaves may look like this",
           std::sqrt(e.dwarfed_by));
     }},
    {"even",
     [](const Evidence&) -> std::string {
       return "its size should be the same all along a flight, and surely is not";
     }},
    {"tilt",
     [](const Evidence&) -> std::string { return "an attitude that is a little off would push the vehicle just so"; }}};

// nothing for a feature that has no words
std::string say(std::string_view feature, const Evidence& record) {
  const auto* known = std::ranges::find(words, feature, &Words::feature);
  return known == std::end(words) ? std::string() : known->say(record);
}

double log_odds(double probability) { return std::log(probability / (1.0 - probability)); }

}  // namespace

std::vector<std::string> weak_points(const Evidence& record) {
  constexpr std::size_t most = 3;
  constexpr double not_worth_a_word = 0.25;  // of the logarithm of the odds: .80 becomes .76
  std::vector<std::pair<double, std::string_view>> lost;
  for (const auto& [name, value] : record.features) lost.emplace_back(weight_of(name) * (1.0 - value), name);
  std::ranges::stable_sort(lost, std::greater{}, &std::pair<double, std::string_view>::first);
  std::vector<std::string> points;
  double missing = log_odds(named_from) - log_odds(std::clamp(record.probability, 1e-12, 1.0 - 1e-12));
  for (const auto& [size, name] : lost) {
    if (missing <= 0.0 || size < not_worth_a_word || points.size() == most) break;
    missing -= size;
    const std::string point = say(name, record);
    if (!point.empty() && std::ranges::find(points, point) == points.end()) points.push_back(point);
  }
  return points;
}

std::string in_one_clause(const std::vector<std::string>& points) { return fmt::format("{}", fmt::join(points, "; ")); }

}  // namespace gustlab::diagnosis
