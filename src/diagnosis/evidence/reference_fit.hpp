// What normal flights of the vehicle show: the model that other flights are compared with.
#pragma once

#include <vector>

#include "diagnosis/estimation/reference.hpp"
#include "diagnosis/estimation/session.hpp"
#include "diagnosis/result/findings.hpp"
#include "diagnosis/selection/selection.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

struct ReferenceFit {
  VehicleModel vehicle;                // the vehicle file with all that these flights show of it
  std::vector<EffectFinding> effects;  // the same as findings, totals; what belongs to single flights is left out
  Reference known;
};

// Normal flights, and what their search chose.
class ReferenceFlights {
 public:
  // `own_rate`: the same flights as they were logged, when the fit is by shooting; `logs`: the same for the simulator.
  ReferenceFlights(std::vector<FlightData> flights, std::vector<FlightData> own_rate, std::vector<FlightLog> logs,
                   const VehicleModel& vehicle, int jobs);

  // Whether they show what other flights seem to have changed, so that their search had lost it: fitted from there, they are
  // likelier. Two kinds of flights say it then, and it stands.
  bool have(const Catalogue& catalogue, const Selection& found, const std::vector<int>& changed);
  ReferenceFit fit() const;

 private:
  Session session_;
  Selection selection_;
};

}  // namespace gustlab::diagnosis
