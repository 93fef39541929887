// Every finding must stand by its own evidence. What does not is withdrawn, the weakest first, and the rest fitted anew.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "diagnosis/result/findings.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// Flights that were not used: as they are read for the filter, as they were logged when the fit was by shooting, and for the simulator.
struct HeldOut {
  std::vector<FlightData> read, own_rate;
  std::vector<FlightLog> logs;
};

struct Challenge {
  std::vector<Evidence> records;              // of the findings that are left, in their order
  std::vector<Evidence> withdrawn;            // as they were when they went
  std::vector<std::vector<Regimes>> regimes;  // of each finding that is left, the widest spread first
  Remainder rest;                             // what is left unexplained then
};

// `most_pose_latency_s`: how late the pose is at most by gyro and attitudes themselves; nothing where they are not recorded.
// The session must be linearised at the selection, and is so again at the end.
Challenge challenge(Session& session, Selection& selection, const HeldOut& held,
                    const std::function<std::optional<double>()>& most_pose_latency_s, int jobs);

}  // namespace gustlab::diagnosis
