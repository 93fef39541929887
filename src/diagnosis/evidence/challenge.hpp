// Every finding must stand by its own evidence. What does not is withdrawn, the weakest first, and the rest fitted anew.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/result/findings.hpp"
#include "diagnosis/validation/remainder.hpp"
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
  std::vector<JudgedSet> history;             // in the order in which they were judged; one of them is the answer
  std::vector<std::vector<Regimes>> regimes;  // of each finding that is left, the widest spread first
  Remainder rest;                             // what is left unexplained then
};

// Of `doubtful` candidates (indices of `records`, at least one) the one that goes now. One at a time: beside a wrong partner a right name looks
// hopeless, and two names of one thing gain little each beside the other. What gains most stays, unless it is alone, ran into its bound, or would be
// hopeless without the others, too (probability_without_others). Of the others it is the hopeless one that gains least, and where none is hopeless the
// one that is least likely.
std::size_t weakest(const std::vector<Evidence>& records, std::vector<std::size_t> doubtful);

// What may be in the place of a finding that is not likely, where rollouts need it (without it held-out flights are predicted surely worse): the nearest
// rival that keeps half of its gain (decisions::most_lost_to_rival) and is in no `asked`. No values of every flight's own, which fit every flight.
std::optional<int> nearest_rival(const Catalogue& catalogue, const Selection& selection, const Finding& finding,
                                 const Evidence& record, const std::set<int>& asked);

// A name that was likely beside others which have gone is asked once more beside those that stand: the noise that was learned without it may hold it by
// now, so that no search finds it. `likeliest`: of every group its largest probability in any set; `judged`: sets that were asked. No values of every
// flight's own, and nothing that ran into its bound.
std::optional<int> comes_back(const Session& session, const Selection& selection,
                              const std::map<int, double>& likeliest, const std::set<std::vector<int>>& judged);

// Whether one set of effects explains more than another, linearised about both and under the noise beside either (Schwarz, Ann. Stat.
// 6, 1978: a number costs the logarithm of the rows).
bool explains_more(const Session& session, const Selection& one, const Selection& other);

// What was withdrawn is looked at again at the end, beside noise that was learned beside all effects, and by comes_back; where that costs a name or a
// suspicion and the new set explains no more, or asks one name and ends where it began, all is exactly as it was before.
// `most_pose_latency_s`: how late the pose is at most by gyro and attitudes themselves; nothing where they are not recorded.
// `stays_from`: the probability from which a finding stays.
// The session must be linearised at the selection, and is so again at the end.
Challenge challenge(Session& session, Selection& selection, const HeldOut& held,
                    const std::function<std::optional<double>()>& most_pose_latency_s, int jobs,
                    double stays_from = decisions::stays_from);

}  // namespace gustlab::diagnosis
