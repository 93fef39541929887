// Where a force of every flight stands beside a drag: the wind that does the same.
#pragma once

#include <vector>

#include "diagnosis/model/catalogue.hpp"

namespace gustlab::diagnosis {

struct StartedSet {
  std::vector<int> groups;  // sorted
  Eigen::VectorXd value;    // SI, where a fit in the nonlinear model may begin
};

// The group of the force that stands in for a wind where a log tells no wind (EffectRow::stand_in), or −1.
int force_like_wind(const Catalogue& catalogue);

// `groups` with the wind in the place of the force, once for each drag of the catalogue alone. `value` (all columns, SI) holds a fit of
// the force beside the drag that is linear in the velocity, the catalogue's first, with coefficient c [N s/m]. A linear drag turns the
// wind w into the force c w; a quadratic one of area A into ρ/2 A |w| w, and damps motion along the wind with c = ρ A |w|.
std::vector<StartedSet> winds_instead(const Catalogue& catalogue, const std::vector<int>& groups,
                                      const Eigen::VectorXd& value);

}  // namespace gustlab::diagnosis
