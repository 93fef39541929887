// The candidates of a diagnosis that have no name, and why: what the page and the terminal say of their records of evidence.
#pragma once

#include <string>

#include "report/diagnosis_words.hpp"

namespace gustlab::report {

// An entry of this effect stands in the list.
bool lists(const Json& list, const std::string& effect);
// Of entries that were found and taken back: the reason, which belongs to all of them. Empty of every other entry of `rejected`.
std::string taken_back_because(const Json& rejected);
bool was_taken_back(const Json& diagnosis, const Json& record);
// Effect and rotor are the same.
bool same_candidate(const Json& one, const Json& other);
// Why a candidate has no name, as clauses that say "it"; empty where its record does not say.
std::string weak_points_of(const Json& record);
// Of the error half a second ahead on held-out flights; NaN where it was not flown.
double removed_share(const Json& record);
// Nothing else says why it has no name: it is no finding, like none, not identifiable or taken back.
bool stands_alone(const Json& diagnosis, const Json& record);
// It removes much of the error, and its evidence makes it unlikely: a reader asks why.
bool surprises(const Json& diagnosis, const Json& record);

}  // namespace gustlab::report
