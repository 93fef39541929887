// Why a candidate has no name: the weakest points of its record of evidence, in words.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/evidence.hpp"

namespace gustlab::diagnosis {

// The fewest features of a judged record without whose weakness it would be named, the heaviest first, three at most; each a clause
// that says "it" of the candidate. Empty where it is named.
std::vector<std::string> weak_points(const Evidence& record);

// "a; b; c", and nothing of nothing
std::string in_one_clause(const std::vector<std::string>& points);

}  // namespace gustlab::diagnosis
