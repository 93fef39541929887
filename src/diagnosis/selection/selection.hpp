// Which effects were chosen, at what values, and how surely.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

// Sets of up to so many effects are searched first, and larger ones where so many are chosen.
inline constexpr int most_effects = 8;

// Another name for a selected effect, and how much worse it does.
struct Rival {
  int group = -1;
  double z = 0.0;  // paired block differences
  double delta_chi2 = 0.0;
  bool below_tolerance = false;  // in its place it would be a trim
  double size_in_naturals = 0.0;
};

struct Finding {
  int group = -1;
  double delta_chi2 = 0.0;  // rise of the loss when it is removed
  // the same when the other finding goes with it that makes this least: effects that undo each other gain much one by one,
  // and little together
  double delta_chi2_with_partner = 0.0;
  double delta_chi2_alone = 0.0;  // fall of the loss when it is added to those findings alone that gain far more
  double inclusion = 0.0;         // share of half samples that select it
  bool calibration = false;       // below its reporting tolerance: a trim, not missing physics
  std::vector<Rival> rivals;      // best first
};

// Whether these flights distinguish the two.
bool is_told(const Rival& rival);
// Whether they do not, or by no more than a model may be wrong by. Few blocks may carry a whole effect: a rival that keeps less than half of its
// gain is no equal, whatever the spread.
bool equal(const Rival& rival, const Finding& finding);

struct Selection {
  std::vector<Finding> findings;  // in catalogue order
  Eigen::VectorXd value;          // SI, all columns
  Eigen::VectorXd deviation;      // standard errors, all columns
  NoiseModel noise_nominal, noise_selected;
  double degrees_of_freedom = 0.0;
  double loss_nominal = 0.0, loss_selected = 0.0;
  double how_unlikely = 0.0;            // −2 log likelihood, and what its numbers cost
  double unpredicted_delta_chi2 = 0.0;  // of the coefficients of unpredicted commands
  Grams grams;                          // at the end, coefficients counted from the nominal vehicle
  std::vector<Smoothed> smoothed_nominal, smoothed_selected;
  std::vector<std::pair<int, double>> alone;  // every group: gain when it is added to the selection
  std::set<int> at_bounds;                    // groups that are not asked: they had a value that ran into its bound
  void nominal_from(const Session& session) { noise_nominal = session.noise, smoothed_nominal = session.smoothed; }
  std::vector<int> groups() const;
  const Finding* find(int group) const;
};

// All of both, sorted, each once.
std::vector<int> joined(std::vector<int> groups, const std::vector<int>& further);

// A selection and the session as it is beside it.
struct Settled {
  Selection selection;
  Session::Learned learned;
  Eigen::VectorXd linearised_at;  // SI, all columns
  std::vector<int> frozen;        // columns
};
Settled settled(const Session& session, Selection selection);
// Makes the session what it was.
Selection go_back(Session& session, Settled before);

// Values of all columns (SI) where a fit, counted from the nominal vehicle, has these columns; of the others the nominal ones.
Eigen::VectorXd value_at(const Catalogue& catalogue, const std::vector<int>& columns, const Fit& fit);
// Whether a group's values lie within their bounds.
bool possible(const Catalogue& catalogue, const Eigen::VectorXd& value, int group);
// A group's largest value (SI, all columns), less the vehicle file's, in sizes that are typical of it.
double size_in_naturals(const Catalogue& catalogue, const Eigen::VectorXd& value, int group);
// Whether one such size is so much smaller than another, unusual one that the name with it is said (decisions::far_more_usual).
bool is_far_more_usual(double size, double than);
// Whether one of them ran into its bound: the group is fitted to something that it does not describe.
bool at_its_bound(const Catalogue& catalogue, const Eigen::VectorXd& value, int group);

}  // namespace gustlab::diagnosis
