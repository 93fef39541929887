// What a pilot or an engineer would say of each effect: a headline with its number, and what is noticed in flight.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"
#include "report/diagnosis_words.hpp"

namespace gustlab::report {

// The flights that the numbers of an effect are changes against; empty: they count from the vehicle file.
std::string normal_flights(const Json& effect, const Json& diagnosis);
// "Rotor 3 gives 9.0 % less thrust"; an effect without words of its own is its name and what it says.
// Without a diagnosis around it only the effect itself says whether its numbers are changes against reference flights.
std::string headline_of(const Json& effect, const Json& diagnosis = Json::object());
// "The controller holds it with more command on rotor 3", empty when nobody would notice.
std::string notice_of(const Json& effect);
// What tells the names of its class apart without flying, a sentence; empty where it has no other, or nothing is known to.
std::string told_on_the_ground(const Json& effect);
bool has_trade_words(const std::string& effect);

// "forward" for x of a vector in the body, "toward world x", "change in roll": what a number of this effect is.
std::string parameter_in_words(const std::string& effect, const std::string& parameter);

// Named effects of diagnosis.json: the most certain first, of those that are equally certain the one that explains most.
std::vector<Json> in_order_of_weight(const Json& diagnosis);

// What would tell an effect that these flights cannot: a setting of the logger, an entry, or the flight that shows it.
std::string remedy_for(diagnosis::Lack lack, const std::string& shows_in = "");

// "like rotor drag of 0.30 N s/m": what a term of an unnamed model is like; weight 0: not known.
std::string likeness(const Json& term, double weight_N);

}  // namespace gustlab::report
