// Where commands were sampled from a faster loop, or on a clock of their own, their torques are not known from sample to sample, and
// their means over a while are: the change of the body's rate over a window is what the mean torque made of it. Means of sampled
// commands differ from true means by chance, which is white from window to window.
#pragma once

#include <vector>

#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Those of some columns that are asked of mean torques. What scales all rotors scales their means as well, and a mean that answers a
// shifted centre of mass would be taken for a wrong scale: of torques as slow as this only what shifts them is asked.
std::vector<int> that_shift_torques(const Catalogue& catalogue, const std::vector<int>& columns);
// What the windows of a flight show of torques, from a linearisation in those columns with the commands of each rotor: `window_s`,
// `mean_acceleration` and `mean_acceleration_by` of the flight whose total thrust alone is known. All other columns are zero there.
void balance_torques(const FlightData& each_rotor, const LinearFlight& linear, LinearFlight& flight);
// Whitened rows, roll and pitch of every window, y last. None where nothing is observed or the variance [(rad/s²)²] is not known (0). In yaw
// a rotor that is not quite upright turns the vehicle as much as a fault does.
Whitened whiten_mean_torques(const LinearFlight& flight, double variance);
// The variance of such means in flights without columns, (rad/s²)²: their mean square, or by how much neighbours differ, whatever is more.
// What no effect explains is noise, and a fit of few windows makes it no less. 0 where there are none.
double mean_torque_variance(const std::vector<LinearFlight>& rest);

}  // namespace gustlab::diagnosis
