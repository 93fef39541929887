// Open-loop rollouts in the simulator from recorded states with recorded actuator inputs (DIAGNOSIS.md §3.8).
//
// A window starts at a recorded sample and predicts those nearest to start + horizon, each at its own time stamp, with
// every sensor effect of the model: what is compared is what the sensors would say. Nothing is fitted but the values that
// a model declares per flight, from samples up to the window's start. The ground does not touch.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "diagnosis/rollout/rollout.hpp"
#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab::diagnosis {

enum class FitQuantity { position_m, velocity_mps, attitude_rad, body_rate_radps };
inline constexpr std::array<std::string_view, 4> fit_quantity_names{"position_m", "velocity_mps", "attitude_rad",
                                                                    "body_rate_radps"};

// Errors of one model on one flight, per window: Euclidean distances, for the attitude the geodesic angle. NaN: the log
// does not have it, or the model left the numbers.
struct FitErrors {
  std::vector<double> horizon_s;
  std::vector<std::size_t> start_row;  // one per window
  struct Quantity {
    // [window × horizons + horizon]; hold: everything stays as it was at the start; noise: what measurement noise alone
    // would give
    std::vector<double> hold, model, noise;
  };
  std::array<Quantity, 4> quantities;

  std::size_t windows() const { return start_row.size(); }
  const Quantity& operator[](FitQuantity q) const { return quantities[static_cast<std::size_t>(q)]; }
};

// Windows of both, of two models of one recording, as pairs of their indices: a late pose starts its windows later.
std::vector<std::pair<std::size_t, std::size_t>> common_windows(const FitErrors& one, const FitErrors& other);

// Throws DataError when the log has no attitude or no actuator input for this vehicle, or no window fits.
// `effects`: all that act, the vehicle's own included.
FitErrors replay(const FlightLog& log, const VehicleModel& vehicle, const std::vector<EffectSpec>& effects,
                 const ReplayOptions& options);
FitErrors replay(const Recording& recording, const std::vector<EffectSpec>& effects, const ReplayOptions& options);

// The `fit` block of FORMATS.md §4: means over all windows of all flights. `after` may be empty, and so may
// `physics`: the same model without a habit of the recorded loop.
nlohmann::ordered_json fit_block(const std::vector<FitErrors>& before, const std::vector<FitErrors>& after,
                                 const std::vector<FitErrors>& physics = {});

}  // namespace gustlab::diagnosis
