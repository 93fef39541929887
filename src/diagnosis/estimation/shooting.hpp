// Predictions half a second ahead as a regression: for logs whose noise was smoothed away, where one-sample innovations
// say more about the smoothing than about the vehicle.
#pragma once

#include <array>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Rows of a window: velocity (else position) and body rate (else attitude) at each horizon, 3 and 3.
inline constexpr std::array<double, 5> shooting_horizon_s = {0.06, 0.12, 0.2, 0.32, 0.5};

struct ShotFlight {
  std::vector<int> columns;  // of the catalogue
  // per window: rows × (columns + 1), the last measured ⊟ predicted, the others its rate of change, natural units
  std::vector<Eigen::MatrixXd> window;
  std::vector<double> time_s;
  std::vector<std::array<std::size_t, shooting_horizon_s.size() + 1>>
      sample;  // first of the window, then at each horizon
};

// Windows start from the recorded motion, one every `spacing_s`, and do not cross gaps. `wanted`: columns of the catalogue, on so many threads.
ShotFlight shoot(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 const std::vector<int>& wanted, double spacing_s, int jobs = 1);
// The residuals of `shot` at another value; its columns and windows (of the same flight and spacing) stay.
void shoot_again(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 double spacing_s, ShotFlight& shot, int jobs = 1);

// What whitens the rows of a window (horizon × error component), from what all windows leave with the columns at
// `coefficient`.
using ShootingWeights = Eigen::MatrixXd;
ShootingWeights shooting_weights(const std::vector<ShotFlight>& flights, const std::vector<int>& columns,
                                 const Eigen::VectorXd& coefficient);
// The answers of the recorded loop. Within half a second a controller cancels what the air does: the commanded torque is the
// disturbance with its sign turned, and a regression on it says that rotors do nothing.
struct Answers {
  std::vector<int> axes;
  // Per flight and window, rows × axes: what the commanded torque of an axis does, less what all columns say of it that are no answer
  // to commands.
  std::vector<std::vector<Eigen::MatrixXd>> window;
  std::vector<std::vector<Eigen::MatrixXd>>
      torque;             // all that it does, and what a constant torque of 1 rad/s² does (rows × 6)
  Eigen::VectorXd share;  // of `window` in what the nominal vehicle leaves; −1: the loop cancels all
};

// Per window of `shot`: what the angular acceleration does that the commands ask for, smoothed by a Gaussian of this standard deviation
// (rows × 3 axes), and what 1 rad/s² about each axis does (3 more).
std::vector<Eigen::MatrixXd> commanded_torque(const FlightData& flight, const ShotFlight& shot, double smoothed_s);
// `nominal`: flights shot at the nominal vehicle with all columns, `torque`: what their commanded torque does.
Answers answers_of(const std::vector<ShotFlight>& nominal, const std::vector<std::vector<Eigen::MatrixXd>>& torque,
                   const ShootingWeights& weights, const Catalogue& catalogue, const std::vector<int>& axes);
// Takes the torque per command out of every column that scales with the commands, and the answers out of what is left to be explained.
void set_aside(const Answers& answers, const ShootingWeights& weights, const Catalogue& catalogue,
               std::vector<ShotFlight>& flights);

// Gram matrices, one block per window. One more block holds what is
// believed beforehand: nuisances are about their natural size, effects not absurdly large.
Grams shooting_grams(const std::vector<ShotFlight>& flights, const ShootingWeights& weights, const Catalogue& catalogue,
                     const Eigen::VectorXd& value);

}  // namespace gustlab::diagnosis
