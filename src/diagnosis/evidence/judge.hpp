// One function turns a record of evidence into the probability that its name is right, and that into named, suspected or rejected.
#pragma once

#include <string_view>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/result/evidence.hpp"

namespace gustlab::diagnosis {

// From here on a candidate is named, is said to be suspected; below it is rejected (FORMATS.md §4).
using decisions::named_from, decisions::suspected_from;

// Fills `features` and `probability` of a record: logistic in the features, with weights that are not negative, so that nothing that speaks
// for a name can speak against it. The weights and what they were fitted on: judge.cpp.
void judge(Evidence& record);
// How likely a judged name would be if no other one took anything from it: every feature that others may lower, at 1.
double probability_without_others(const Evidence& record);
// What a feature adds to the logarithm of the odds at most; 0 for what is none.
double weight_of(std::string_view feature);

}  // namespace gustlab::diagnosis
