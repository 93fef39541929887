// The verdict of a diagnosis (FORMATS.md §4).
#pragma once

#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/validation/remainder.hpp"

namespace gustlab::diagnosis {

// Of what `out` names, and what is left beside it. `at_bound`: something was withdrawn whose likeliest value its bound is.
Verdict conclude(const Diagnosis& out, const Remainder& rest, bool at_bound, bool commands_jitter);

}  // namespace gustlab::diagnosis
