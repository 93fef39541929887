// What speaks for and against each candidate, one record a name. A name stands or falls by its own record; the judge reads nothing else.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

// How much a signature gains by chance: the same one moved along its flight, or mirrored in time (estimation/surrogates.hpp).
struct SurrogateTest {
  double inflation = 1.0;  // what a moved signature gains on average (Δχ²), per parameter; 1: innovations are white
  double p_value = 1.0;    // share of moved signatures that gain at least as much as the true one, itself counted
  bool movable = true;     // false: a moved signature is the same again (a constant), and the test says nothing
};

// How large an effect is in one flight, as a share of its value over all fit flights, everything else as it was fitted.
struct FlightShare {
  std::string file;
  bool held_out = false;
  double share = 1.0, deviation = 1.0;  // standard error, robust within a sixth of a flight
};

struct Evidence {
  std::string effect;  // catalogue name
  int group = -1;
  int rotor = 0;            // of a rotor's own effect: 1 to N
  bool per_flight = false;  // its values are each flight's own, fitted to the held-out ones as well
  double may_differ = decisions::other_differs;  // by what share of itself its size may surely differ along a flight
  int parameters = 1;                            // free numbers
  double delta_chi2 = 0.0;                       // Δχ² when it is left out and all else is fitted anew
  double delta_chi2_with_partner =
      std::numeric_limits<double>::infinity();  // Δχ² when another finding goes with it, the one that makes this least
  double delta_chi2_alone = std::numeric_limits<double>::infinity();  // Δχ² beside those alone that gain far more
  double held_out_delta_chi2 = 0.0;  // Δχ² on the held-out flights, shared values as they were fitted
  double held_out_expected = 0.0;    // the same if the effect were there just as it was fitted
  SurrogateTest surrogates;
  double clustered_inflation = 1.0;  // variance of its size between sixths of flights, over that of white innovations
  std::vector<FlightShare> flights;  // fit flights, then the held-out ones together
  double spread_flights = 0.0;       // standard deviation of the shares beyond their errors
  double spread_regimes = 0.0;  // the same between low, middling and high speed, height, thrust …; 1: cannot be said
  double uneven = 0.0;          // standard deviation between regimes beyond its errors, along what it surely depends on
  double slow_fast = 0.0;  // by how much its share differs between slow and fast changes (estimation/slow_and_fast.hpp)
  double size_in_tolerances = 0.0;  // largest parameter over its reporting tolerance; infinite where none is declared
  double inclusion = 0.0;           // share of half samples that select it
  double rival_delta_chi2 = 0.0,
         rival_z = 0.0;  // of the nearest rival that is distinguished from it: how much worse (Δχ²), in standard errors
  double unpredicted_commands =
      0.0;  // Δχ² of what the log does not hold of the commands, where only they can show the effect
  // its force less its moment, in its sizes, and how much the smaller one lacks of one size (parts.hpp)
  double force_excess = 0.0, force_excess_sd = 0.0, part_lacking = 0.0;
  double sensors_share =
      1.0;                // of a late pose, the share of its delay that gyro and attitudes by themselves leave possible
  bool at_bound = false;  // a value ran into its bound
  // share of what it does to the predictions that another finding of like size, or all of them, take back; 0 where they add to it
  double undone = 0.0;
  // what all other findings do against it, over what it does
  double outweighed = 0.0;
  // mean square of what the largest other name does where this one shows, over its own; 0: there is none
  double dwarfed_by = 0.0;
  // a force of a flight's own over what an attitude a little off leaves of gravity; infinite where that would show as well
  double force_over_tilt = std::numeric_limits<double>::infinity();
  bool lone_latency =
      false;  // a lag or a delay beside one reference flight: where torques swing, one flight alone may fit another one
  // of a lag or a delay where commands jitter from row to row: Δχ² by the slow changes of measured speeds (estimation/slow_speeds.hpp);
  // infinite where these are not asked
  double slow_speeds_delta_chi2 = std::numeric_limits<double>::infinity();
  // of a lag or a delay where the commands of a row may move until the next: Δχ² by the body's turning (estimation/latency_between_rows.hpp);
  // infinite where that is not asked
  double between_rows_delta_chi2 = std::numeric_limits<double>::infinity();
  int alike = 0;  // other findings of the same effect, of another rotor, or what these logs hardly distinguish from it
  // open-loop rollouts of held-out flights without it, against those with it: share of the error that it removes, and that difference
  // over its standard error; per horizon, the best of (position, velocity), (attitude, body rate) and (position, velocity) with the attitude
  // as it was recorded
  std::vector<double> horizon_s, recovered, recovered_z;
  std::vector<std::pair<std::string_view, double>>
      features;                               // what the judge looked at, each from 0 (against) to 1 (for)
  double probability = 0.0;                   // that the name is right, by the judge
  std::vector<std::string> weak_points = {};  // why it is not named, the heaviest first, in words; empty where it is

  // Δχ², alone or with its partner, in units that chance gives here: over the larger of both inflations.
  double robust_delta_chi2() const;
  int flights_for() const;      // in which it is clearly there: more than half of its size and two errors
  int flights_against() const;  // in which it is clearly not: less than a quarter, two errors below one
};

// A set of names that was judged together on the way to the answer, and what was changed then.
struct JudgedSet {
  struct Name {
    std::string effect;
    int rotor = 0;
    double probability = 0.0;
  };
  std::vector<Name> names;
  double minus_two_log_likelihood = 0.0;  // with what its numbers cost; sets of different noise may be compared
  std::vector<std::string> withdrawn;     // labels, as rotor_loss#3; empty: all of the set stood
  std::string in_its_place;               // the rival that took the place of what was withdrawn; empty: none
  bool answer = false;                    // what is named, suspected or calibration comes from this one
};

}  // namespace gustlab::diagnosis
