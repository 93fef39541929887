// Predictions half a second ahead as a regression: for logs whose noise was smoothed away, where one-sample innovations
// say more about the smoothing than about the vehicle.
#pragma once

#include <array>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Rows of a window: the error state (12) at each horizon.
inline constexpr std::array<double, 5> shooting_horizon_s = {0.06, 0.12, 0.2, 0.32, 0.5};

struct ShotFlight {
  std::vector<int> columns;  // of the catalogue
  // per window: rows × (columns + 1), the last measured ⊟ predicted, the others its rate of change, natural units
  std::vector<Eigen::MatrixXd> window;
  std::vector<double> time_s;
};

// Windows start from the recorded motion, one every `spacing_s`, and do not cross gaps.
ShotFlight shoot(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 const std::vector<int>& wanted, double spacing_s);

// What whitens the rows of a window (horizon × error component), from what all windows leave with the columns at
// `coefficient`.
using ShootingWeights = Eigen::MatrixXd;
ShootingWeights shooting_weights(const std::vector<ShotFlight>& flights, const std::vector<int>& columns,
                                 const Eigen::VectorXd& coefficient);
// Gram matrices, one block per window; One more block holds what is
// believed beforehand: nuisances are about their natural size, effects not absurdly large.
Grams shooting_grams(const std::vector<ShotFlight>& flights, const ShootingWeights& weights, const Catalogue& catalogue,
                     const Eigen::VectorXd& value);

}  // namespace gustlab::diagnosis
