// The catalogue as columns of a regression: every parameter of every candidate effect, per vehicle or per flight.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"
#include "gustlab/effect.hpp"

namespace gustlab::diagnosis {

// Never a finding. Of one flight: biases, and where predictions half a second ahead are fitted trims, a clock, and how much
// less the commands were smoothed than the motion. Elsewhere, of all flights: coefficients of what was not predicted of the
// commands, and of what the loop did between two of them (command_innovation.hpp).
enum Nuisance : int {
  rate_bias = 0,
  force_bias = 3,
  torque_trim = 6,
  command_clock = 9,
  command_smoothing = 10,
  command_innovation_of = 11,
  loop_between_of = 19
};

// One number that may be fitted.
struct Column {
  int group = -1;     // −1: a nuisance (sensor bias, trim), always free and never a finding
  int parameter = 0;  // index among the effect's numbers; of a nuisance: Nuisance
  int flight = -1;    // −1: one value for all flights
  std::string name;
  std::string unit;
  double natural = 1.0;                              // typical size in SI, the regression's unit
  double tolerance = 0.0, estimate_tolerance = 0.0;  // the latter where errors of the sensors last
  double unfiltered_tolerance = 0.0;                 // without what a filter of the log may do to it
  double min = 0.0, max = 0.0;
  double nominal = 0.0;   // value in the vehicle file
  double known_to = 0.0;  // standard deviation of the vehicle file's value, SI; 0: nothing is known beforehand
  bool of_torque_trim() const { return group < 0 && parameter >= torque_trim && parameter < command_clock; }
  // coefficient of the commands' innovation
  bool of_command_innovation() const {
    return group < 0 && parameter >= command_innovation_of && parameter < loop_between_of;
  }
  // of what the loop did between two commands that were logged
  bool of_loop_between() const { return group < 0 && parameter >= loop_between_of; }
  // a little beyond a bound is noise
  bool admits(double value) const { return value >= min - 0.02 * natural && value <= max + 0.02 * natural; }
};

// What build tolerances and a re-seated battery leave from flight to flight: rad/s² (a third of a millimetre of a
// Crazyflie's centre of mass), a logger's clocks, s, and the variance of a filter's kernel, s² (20 ms: 8 Hz).
inline constexpr double torque_trim_sd = 5.0, command_clock_sd = 0.02, command_smoothing_sd = 4e-4;

// How a load swings: length of its cable, damping ratio of small swings, and the length's standard error.
struct Swing {
  double length_m = 0.0, damping = 0.0, length_deviation_m = 0.0;
};

// All numbers of one effect (of one rotor, where each has its own): selected or left out together.
struct Group {
  std::string label;  // name, or name#3 of the third rotor
  const EffectRow* row = nullptr;
  int rotor = 0;             // of an effect of one rotor: 1…N
  bool nominal = false;      // part of the vehicle file
  bool candidate = true;     // false: part of the nominal model, with nothing to fit
  Swing swing;               // ColumnFrom::swing: found by a scan
  double limit_radps = 0.0;  // ColumnFrom::speed_limit: found by a scan; its column is a switch near one
  std::vector<int> columns;
};

// The numbers of an effect in the order in which it declares them.
struct Number {
  std::string name;
  double* value;
  ParameterInfo info;
};
std::vector<Number> numbers_of(Parameterized& effect);

// What a parameter's natural size and tolerance are multiplied with for a vehicle.
double scale_of(Scale scale, const VehicleModel& vehicle);

class Catalogue {
 public:
  // What sags is fitted by voltage where that was seen, otherwise by time. `flights`: how many, for values per flight.
  // Without attitude nothing fixed in the world, without position or velocity nothing that depends on them is identifiable,
  // and without torque nothing that only turns the vehicle. Without velocity, a speed that falls more slowly than it
  // rises is not distinguished from thrust that is lost in a climb: a lag then has one time constant.
  struct Seen {
    Need observable = Need::nothing;
    bool voltage = false;
    bool trims = false;      // torque trims and command clocks are free in every flight
    bool smoothing = false;  // and how much less the commands were smoothed
    bool slow_commands = false;
    bool mean_torques = false;     // over a while: see mean_torques.hpp
    bool thrust_jitters = false;   // as the torques do: of the commands only means are known
    bool inertial_unused = false;  // an accelerometer was recorded, and is not used: see ReadingOptions::forces_only
    bool observes(Need need) const { return (observable & need) != Need::nothing; }
  };
  Catalogue(const VehicleModel& vehicle, int flights, const Seen& seen);

  const std::vector<Group>& groups() const { return groups_; }
  const std::vector<Column>& columns() const { return columns_; }
  const Group& group(int index) const { return groups_[static_cast<std::size_t>(index)]; }
  const Column& column(int index) const { return columns_[static_cast<std::size_t>(index)]; }
  // lags and delays up to decisions::filter_lag_s may be a filter's
  bool filter_looks_like_lag() const { return seen_.smoothing; }
  // the torque per command was taken out of all columns
  bool loop_answers() const { return loop_answers_; }
  bool observes(Need need) const { return seen_.observes(need); }
  // what the loop did between two of them is a nuisance (command_innovation.hpp)
  bool commands_are_slow() const { return seen_.slow_commands && !seen_.trims && seen_.observes(Need::torque); }
  // torques over a while, and none from sample to sample (mean_torques.hpp)
  bool mean_torques_alone() const { return seen_.mean_torques; }
  // why an effect of the registry is not among the candidates; no value when it is
  std::optional<NotIdentifiable> why_left_out(const EffectRow& row) const;
  int size() const { return static_cast<int>(columns_.size()); }
  Eigen::VectorXd nominal() const;
  int find(std::string_view label) const;  // group index or −1
  // The first group with columns whose effect is of this kind, or −1.
  int find(ColumnFrom column) const;
  int find(Airflow air) const;
  int find(Place place, Latency latency) const;

  // The effects that fly in one flight at given values: those of non-zero strength, and `also` (a group) in any case.
  std::vector<NamedEffect> effects(const Eigen::VectorXd& value, int flight, int also = -1) const;
  // The swing of a load, whose force is a history of each flight and never part of effects().
  void set_swing(const Swing& swing);
  void set_speed_limit(double limit_radps);
  // The recorded loop answers what disturbs the vehicle: what only the torque per command shows is no candidate any more.
  void hide_torque_gains();
  // Changes between flights are looked for: what is built in is no candidate any more, and what a filter does to a gyroscope's scale it
  // does in all flights.
  void compare_with_reference();
  // A number that ran away from what is known of it beforehand, or that the flights do not tell, stays as the vehicle file has it, and leaves its
  // group to the others.
  void freeze(int column);
  void thaw(int column);
  // Whether the last number of a group is asked.
  bool asks_last(int group) const;
  // Sensor effects and rate biases of one flight, as smoothing takes them out.
  SensorCorrection sensor_correction(const Eigen::VectorXd& value, int flight) const;
  // Values kept inside their bounds.
  void clamp(Eigen::VectorXd& value) const;

 private:
  std::unique_ptr<Effect> make(const Group& group) const;
  int find(const std::function<bool(const EffectRow&)>& is) const;
  void add_effect(const EffectRow& row, int rotor, int flights);
  Column column_of(const EffectRow& row, const Number& number) const;
  void add_biases(int flights);
  void add_trims(int flights);
  void add_command_innovation();

  VehicleModel vehicle_;
  Seen seen_;
  bool loop_answers_ = false;
  std::vector<Group> groups_;
  std::vector<Column> columns_;
};

// An effect that shifts the mean torques of a flight that hovers.
bool shifts_torques(const EffectRow& row);

// Columns of one group beside others: of exact aliases only one is free.
std::vector<int> own_columns(const Catalogue& catalogue, const std::vector<int>& groups, int group);
// Columns of several groups.
std::vector<int> columns_of(const Catalogue& catalogue, const std::vector<int>& groups);

}  // namespace gustlab::diagnosis
