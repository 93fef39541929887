// Numbers that other flights show already, with the error that they have there.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/model/catalogue.hpp"

namespace gustlab::diagnosis {

// Information about columns that all flights share (label of the group, parameter), in their natural units, and what those flights say
// of each beyond the nominal vehicle, when all are free: a set of effects that explains them leaves some out that are there.
struct Reference {
  int flights = 0;
  std::vector<std::pair<std::string, int>> column;
  Eigen::MatrixXd information;
  Eigen::VectorXd estimate;
  // Of numbers that every flight has for itself (a wind, a constant force), where these flights have them: root mean square over the
  // flights, SI.
  std::map<std::pair<std::string, int>, double> of_each_flight;
};

// Of Gram matrices, counted from the nominal vehicle: the shared columns that these flights hold, the columns `free` of
// single flights (biases, and the winds and forces that were found there) projected out. Flights that differ more than
// their noise lets them hold as much less information.
Reference reference_of(const Catalogue& catalogue, const Grams& grams, const std::vector<int>& free);

// Columns of a catalogue that a reference knows, and where it has them: of those `present` in what is fitted. What has no column there is not
// free to be wrong either, and stays as the reference has it.
struct KnownColumns {
  std::vector<int> column;
  std::vector<Eigen::Index> at;
};
KnownColumns known_columns(const Catalogue& catalogue, const std::vector<int>& present, const Reference& reference);
// Likeliest errors of the known numbers, natural units, given what flights leave beside everything else: `information` of their rows about
// `known`, and `score`, these rows' products with what is left.
Eigen::VectorXd known_errors(const Reference& reference, const KnownColumns& known, const Eigen::MatrixXd& information,
                             const Eigen::VectorXd& score);

// What flights say of a change beside numbers that are known only as surely as the reference says: their errors are columns of their own
// that fit both, eliminated. With A of these flights and H of the reference, A − A (A + H)⁻¹ A is left of the information.
Grams beside_reference(const Catalogue& catalogue, const std::vector<int>& present, const Reference& reference,
                       Grams grams);

}  // namespace gustlab::diagnosis
