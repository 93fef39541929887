// Logs without attitude and body rate: what the mean commands of hover show against another flight of the same vehicle.
//
// In hover the rotors' thrusts and reaction torques balance weight and moments, so a lost rotor, a moved centre of mass
// or more weight each shift the mean commands in their own direction. The vehicle file alone is no reference: normal
// vehicles hold a trim of their own (CrazyPAD, Data 2024, 9(6), 79: opposite rotors differ by 10–30 %).
#pragma once

#include "diagnosis/hover/hover_balance.hpp"
#include "diagnosis/result/diagnosis.hpp"

namespace gustlab::diagnosis {

// Fills verdict, effects, mismatch and what is not identifiable of `out`. Flights that agree with the reference join it; the
// effect is fitted to the others of `fit` and must also hold on the others of `holdout`. With no reference the flight
// nearest to the vehicle file's balance is taken, and that is said.
void compare_hover(const std::vector<FlightData>& reference, const std::vector<FlightData>& fit,
                   const std::vector<FlightData>& holdout, const VehicleModel& vehicle, Diagnosis& out);

}  // namespace gustlab::diagnosis
