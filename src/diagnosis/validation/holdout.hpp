// Do the findings pay on flights that were not used?
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

struct HoldoutTest {
  std::vector<double> delta_chi2;  // per finding of the selection: χ² that it saves on the held-out flights
  std::vector<double> expected;    // χ² that it would save there if it were just as it was fitted
  double loss_nominal = 0.0, loss_selected = 0.0, rows = 0.0;
};

// Shared values stay as they were fitted; only values per flight and sensor biases are fitted to the held-out flights.
// `own_rate`: the same flights as they were logged, when the fit was by shooting.
HoldoutTest test_holdout(const Session& fitted, const Selection& selection, std::vector<FlightData> holdout,
                         std::vector<FlightData> own_rate, int jobs);

// Values for another set of flights: shared ones as they are, those per flight at their mean.
Eigen::VectorXd carry_over(const Catalogue& from, const Eigen::VectorXd& value, const Catalogue& to);

}  // namespace gustlab::diagnosis
