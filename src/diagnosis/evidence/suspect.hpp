// Names that cannot stand beside something that was found out later are only suspected.
#pragma once

#include <functional>
#include <string>

#include "diagnosis/result/diagnosis.hpp"

namespace gustlab::diagnosis {

// Moves names from the effects of `out` to its rejected ones, but those that stand.
void suspect(
    Diagnosis& out, const std::string& why,
    const std::function<bool(const EffectFinding&)>& stands = [](const EffectFinding&) { return false; });

}  // namespace gustlab::diagnosis
