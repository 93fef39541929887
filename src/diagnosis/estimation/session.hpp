// One diagnosis in memory: flights of one vehicle, linearised and weighed together.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/estimation/innovation_filter.hpp"
#include "diagnosis/estimation/reference.hpp"
#include "diagnosis/estimation/sensor_windows.hpp"
#include "diagnosis/estimation/shooting.hpp"
#include "diagnosis/estimation/surrogates.hpp"

namespace gustlab::diagnosis {

// Where a search begins: at a lag or a delay of the rotors (`group`), or at none (-1).
struct LatencyStart {
  int group = -1;
  Eigen::VectorXd value;  // SI, all columns
};
// Of some lags and delays beyond `prompt` the one that leaves least, if that is less than `share` of what `prompt` leaves. Longer ones are not
// tried once one leaves `hopeless` times as much.
LatencyStart least_left_at(const Catalogue& catalogue, const Eigen::VectorXd& prompt, double share,
                           const std::function<double(const Eigen::VectorXd&)>& left,
                           double hopeless = std::numeric_limits<double>::infinity());

// How a number of the noise is tried: so much larger and smaller, in at most so many sweeps over all.
struct NoiseSteps {
  double factor;
  int sweeps;
};

class Session {
 public:
  // `shooting_flights`: other (less filtered) versions of the same flights; Grams then come from predictions half a
  // second ahead of these.
  Session(std::vector<FlightData> flights, const VehicleModel& vehicle, int jobs,
          std::vector<FlightData> shooting_flights = {});

  const Catalogue& catalogue() const { return catalogue_; }
  const VehicleModel& vehicle() const { return vehicle_; }
  const std::vector<FlightData>& flights() const { return flights_; }
  const std::vector<LinearFlight>& linear() const { return linear_; }
  const Eigen::VectorXd& value() const { return value_; }
  const std::vector<int>& all_columns() const { return all_; }
  const std::vector<int>& biases() const { return biases_; }
  // The columns of some groups and the biases, in this order.
  std::vector<int> with_biases(const std::vector<int>& groups) const;
  int jobs() const { return jobs_; }
  double sample_s() const { return flights_.front().sample_s; }
  // of the logs themselves, where they are read at a lower rate for being smoothed
  const std::vector<FlightData>& flights_as_logged() const { return shoots() ? shooting_flights_ : flights_; }
  double logged_sample_s() const { return flights_as_logged().front().sample_s; }

  // Linearises every flight at `value`, differentiating the wanted columns; smooths again when sensor effects moved.
  // Where predictions are fitted, the filter's own part can be left out.
  void linearise(const Eigen::VectorXd& value, const std::vector<int>& wanted, bool with_filter = true);
  // What the model predicts at another value, its columns as the last `linearise` (of the filter, or of what is predicted) left them.
  void predict_at(const Eigen::VectorXd& value);
  // A load that swings so is suspected: its force history becomes a column.
  void suspect_load(const Swing& swing, std::vector<std::vector<Vector3>> force_per_flight);
  // A lower speed limit is suspected: what it changes becomes a column.
  void suspect_limit(double limit_radps);
  // Catalogue::freeze, here and in what is fitted beside all effects.
  void freeze(int column);
  const std::vector<int>& frozen() const { return frozen_; }
  // These columns and no others; the session has to be linearised anew.
  void freeze_only(const std::vector<int>& columns);
  // F again from scratch at the next linearise (after a large effect was found).
  void forget_transitions();
  // EM on the noise, with the given columns at their least-squares values (ridged) all along.
  void learn_noise(int iterations, const std::vector<int>& columns);
  // A coarse search for the likeliest disturbance, from where EM would take hundreds of steps, and for errors of the sensors
  // that last, where innovations are not white.
  void search_noise(const std::vector<int>& columns);
  Grams grams() const;
  // Of these columns at least.
  Grams grams(const std::vector<int>& columns) const;
  // Innovations with the given columns taken out at these values (natural units, counted from the linearisation);
  // `extra`: further columns per flight, before y.
  std::vector<Whitened> innovations(const std::vector<int>& columns, const Eigen::VectorXd& coefficient,
                                    const std::vector<std::vector<SpatialAccelerations>>* extra = nullptr) const;
  // Whitened rows of these columns and y as they follow each other in time, per flight and channel (catalogue columns in this order,
  // natural units, counted from the linearisation).
  RowSeries row_series(const std::vector<int>& columns) const;
  // −2 log likelihood of the innovations above.
  double misfit(const std::vector<int>& columns, const Eigen::VectorXd& coefficient) const;
  // The same of a fit, and where predictions half a second ahead are judged, of these: the noise that was learned counts, so that sets beside
  // which other noise was learned can be compared.
  double minus_two_log_likelihood(const std::vector<int>& columns, const Fit& fit) const;

  // Where rotor speeds are measured and a delay is among the groups, it starts from where speeds and commands match.
  void start_delay(const std::vector<int>& groups, Eigen::VectorXd& value) const;
  // Where rotor speeds are measured, the lag or the delay of the rotors starts from where commands predict them best: linearised at
  // none, commands that jitter say next to nothing of it.
  void start_latency(Eigen::VectorXd& value) const;
  bool predicts_speeds() const { return !linear_.front().predicted.empty(); }
  // Whether a group was last linearised in how measured rotor speeds follow their commands.
  bool seen_in_speeds(int group) const;

  // Each flight on a thread of its own; what a body writes belongs to its flight.
  void for_each_flight(const std::function<void(std::size_t)>& body) const;
  // Changes against these numbers are looked for from now on; they are known only as surely as that.
  void compare_with(Reference reference) { reference_ = std::move(reference), catalogue_.compare_with_reference(); }
  const std::optional<Reference>& reference() const { return reference_; }
  void take_weights(const Session& other);
  bool shoots() const { return !shooting_flights_.empty(); }

  // What learn_noise() found, to be put back.
  struct Learned {
    NoiseModel noise;
    std::vector<Smoothed> smoothed;
    ShootingWeights weights;
  };
  Learned learned() const { return {noise, smoothed, weights_}; }
  void put_back(Learned before);

  NoiseModel noise;
  std::vector<Smoothed> smoothed;  // of the last EM iteration

 private:
  double window_spacing_s() const;
  // From two steps of EM further on in their direction, where that makes what is left of the flights likelier.
  void leap(const std::vector<NoiseModel>& before, const std::vector<LinearFlight>& rest);
  // the linearisation's value with some columns further by so much in their natural units
  Eigen::VectorXd value_with(const std::vector<int>& columns, const Eigen::VectorXd& coefficient) const;
  // the parts of a linearisation for one flight: its motion and speeds at a value, and y without the biases
  void read_at(const Eigen::VectorXd& value, std::size_t flight);
  // mean torques of a flight where the total thrust alone is known from sample to sample; `wanted`: as in linearise, none: as they are
  void balance_torques(std::size_t f, const std::vector<int>* wanted);
  void take_biases_out(std::size_t flight);
  Grams filtered_grams(const std::vector<int>& columns) const;
  // adds what the sensors say of these columns by themselves
  void add_sensor_windows(const std::vector<int>& columns, Grams& grams) const;
  // as grams(columns), but that nothing is known beforehand
  Grams flown_grams(const std::vector<int>& columns) const;
  // coefficients of columns (ridged) beside the likeliest torque trims, which the noise takes over
  Eigen::VectorXd beside_trims(const std::vector<int>& columns);
  // Flights as they are shot, with the answers of the loop set aside.
  void set_answers_aside();
  // New weights, and what the answers are under them.
  void weigh(ShootingWeights weights);
  std::vector<int> present(const std::vector<int>& columns) const;
  // Changes the model, a part at a time, to a likelier one; returns −2 log likelihood.
  double descend(const std::vector<LinearFlight>& flights, NoiseModel& model, const NoiseSteps& steps) const;
  int jobs_;
  VehicleModel vehicle_;
  std::vector<FlightData> flights_;
  Catalogue catalogue_;
  std::vector<LinearFlight> linear_, each_rotor_;  // of FlightData::each_rotor
  Eigen::VectorXd value_;
  std::vector<int> all_, biases_, frozen_;
  std::vector<SensorWindows> sensor_windows_;
  std::vector<FlightData> shooting_flights_;
  std::vector<ShotFlight> shot_;
  ShootingWeights weights_;
  // for the answers of the recorded loop: flights at the nominal vehicle, their slow torque, axes on which the loop answers
  std::vector<ShotFlight> shot_nominal_;
  std::vector<std::vector<Eigen::MatrixXd>> slow_torque_, torque_;
  std::optional<std::vector<int>> answered_axes_;
  Answers answers_;                     // under these weights
  std::vector<ShotFlight> shot_aside_;  // of the last linearisation, answers set aside
  std::optional<Reference> reference_;
};

// A flight with these columns alone.
LinearFlight only(const LinearFlight& flight, const std::vector<int>& columns);
// A flight with some columns at these values, and no column left.
LinearFlight taken_out(const LinearFlight& flight, const std::vector<int>& columns, const Eigen::VectorXd& coefficient);
// Typical size of the noise before anything is known.
NoiseModel initial_noise(const std::vector<FlightData>& flights, const VehicleModel& vehicle);
// What a calm room leaves unexplained, per group, sd in m/s² and rad/s² (Crazyflie prototype, scaled by size).
std::array<double, disturbance_groups> reference_floor(const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
