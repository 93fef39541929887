// What normal flights of the vehicle show: the model that other flights are compared with.
#pragma once

#include <vector>

#include "diagnosis/estimation/reference.hpp"
#include "diagnosis/result/findings.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

struct ReferenceFit {
  VehicleModel vehicle;                // the vehicle file with all that these flights show of it
  std::vector<EffectFinding> effects;  // the same as findings, totals; what belongs to single flights is left out
  Reference known;
};

// `own_rate`: the same flights as they were logged, when the fit is by shooting.
ReferenceFit fit_reference(const std::vector<FlightData>& flights, const std::vector<FlightData>& own_rate,
                           const VehicleModel& vehicle, int jobs);

}  // namespace gustlab::diagnosis
