// What to fly next (DIAGNOSIS.md §3.10): the Gram matrices of simulated flights show which of them would separate the
// names that these flights cannot, or show what these do not excite.
#pragma once

#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Flies the library (slow and fast circle, figure of eight, many sines with yaw, climbing spiral, staircase of heights;
// sized by the vehicle) with what was found, under the noise that was learnt. For every effect whose class has several
// names: how much worse the best replacement would score. If there is none: how many of the effects that are not
// identifiable would show at their natural size. Fills next_trajectory and next_why of `out`, or leaves them empty when no
// flight of the library would help.
void suggest_flight(const Session& session, const Selection& selection, int jobs, Diagnosis& out);

}  // namespace gustlab::diagnosis
