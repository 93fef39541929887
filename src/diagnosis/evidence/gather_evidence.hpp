// Where the records of evidence come from: the search's own matrices, moved signatures, and rollouts of flights that were not used.
#pragma once

#include <vector>

#include "diagnosis/result/evidence.hpp"
#include "diagnosis/rollout/rollout.hpp"
#include "diagnosis/validation/holdout.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// Of what an effect (weights of all columns, zero for z) does to the whitened predictions beside the columns `known`: the share that
// `further` columns do as well.
double share_done_by(const Eigen::MatrixXd& gram, const Eigen::VectorXd& effect, const std::vector<int>& known,
                     const std::vector<int>& further);

// What each finding does to the predictions (weights of all columns, zero for z), linearised at what was found, so that all together are what was
// found. There a drag does what the wind does through it; left to the wind is its share of the drag that the vehicle file holds.
std::vector<Eigen::VectorXd> weights_added_up(const Catalogue& catalogue, const Selection& selection);

// What others do against an effect, in what both do to the predictions; 0 where they add to it or have nothing in common.
struct Undoing {
  // of the larger of the two, what another effect or all others together take back: 1 where they undo each other
  double share;
  // by all others together, over what the effect does: many times where they are far larger
  double outweighed;
};
// `gram`: of the columns; one vector of coefficients an effect.
std::vector<Undoing> undoings(const Eigen::MatrixXd& gram, const std::vector<Eigen::VectorXd>& effects);

// Of effects (weights of the columns, one column an effect) at (i, j): the mean square of what effect j does to the whitened rows, over that of effect
// i, where each row counts by what i does there, squared. Large where i shows only in rows that j changes far more.
Eigen::MatrixXd shown_beside(const RowSeries& rows, const Eigen::MatrixXd& effects);
// The largest of these for finding i; 0: there is none. A trim is no name, and a wind and the drag that feels it do not count for each other.
double dwarfed_by(const Catalogue& catalogue, const Selection& selection, const Eigen::MatrixXd& beside, std::size_t i);

// Root mean square, over all samples of the fit flights, of the linear acceleration by a finding's own values, m/s². The session is
// linearised there.
double own_acceleration_mps2(const Session& session, const Selection& selection, const Finding& finding);

// Whether no flight turns: what stays in the world stays in the body then.
bool headings_are_kept(const Session& session);

// Evidence::may_differ of an effect: least of what nothing in flight changes (a mass, a lag, a force of every flight's own).
double may_differ(const EffectRow& row);

// Of every finding of a selection, the session linearised there; rollouts are not flown yet.
std::vector<Evidence> gather_evidence(const Session& session, const Selection& selection, const HoldoutTest& tested,
                                      const std::vector<std::vector<Regimes>>& regimes);

// Flies held-out flights in the simulator with all findings and without each in turn; fills `recovered` of the records, which are in the
// order of `found`. `own`: effects of the vehicle file. Flights that cannot be flown are passed over.
void fly_without_each(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                      const std::vector<EffectSpec>& found, int jobs, std::vector<Evidence>& records);
// Logs as they are flown there; those that cannot be are left out.
std::vector<Recording> recordings_to_fly(const std::vector<FlightLog>& logs, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
