// What a diagnosis says, before it becomes JSON, TOML and a page.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gustlab::diagnosis {

// A fault of the log or of the vehicle file; it comes before any physics.
struct LogFinding {
  std::string file;
  std::string column;
  std::string
      kind;  // gap | duplicate | frozen | held | out_of_range | unit | frame | sign | inconsistent | delay | filtered
  double from_s = 0.0, to_s = 0.0;
  std::string says;
  bool sets_flight_aside = false;
  bool sets_column_aside = false;
};

struct NamedValue {
  std::string name, unit;
  double value = 0.0, deviation = 0.0;
};

struct ConfusableEffect {
  std::string effect;
  bool equivalent = false;
  double z = 0.0, delta_chi2 = 0.0;
};

// How large a finding is, as a share of its value over all flights, where one variable is low, middling and high. The three
// parts hold equally much information about it.
struct Regimes {
  std::string variable;
  std::vector<double> share, deviation;  // 1: as over all flights; standard errors, robust within clusters
  double spread = 0.0;                   // standard deviation between the parts beyond their errors
  double chi_squared = 0.0;  // of the parts against their mean, in standard errors; degrees of freedom: parts − 1
};

struct EffectFinding {
  std::string effect;  // catalogue name
  std::string place;
  std::string says;
  double confidence = 0.0;
  std::vector<NamedValue> parameters;
  std::vector<NamedValue>
      total;  // against the vehicle file, where `parameters` is a change against reference flights; empty: the same
  std::vector<std::pair<std::string, std::vector<NamedValue>>> per_flight;  // file → values
  std::vector<std::string> classmates;                                      // itself included
  std::vector<ConfusableEffect> confusable;
  double delta_chi2 = 0.0;  // Δχ²: rise of the score when it is removed
  double price = 0.0;       // Δχ² from which on its numbers pay
  Regimes least_even;       // where its size varies most
  // 0: of no single rotor
  int rotor() const {
    return parameters.empty() || parameters.front().name != "rotor" ? 0 : static_cast<int>(parameters.front().value);
  }
};

// "rotor_loss (rotor 3)"; of rotor 0 the name alone
std::string with_rotor(std::string_view effect, int rotor);

struct Rejected {
  std::string effect;  // with its rotor
  double score = 0.0;  // Δχ² of adding it to what was found, less what its numbers cost
  std::string why;
  std::vector<NamedValue> would_show = {};  // numbers from which on it would show beside what was found
};

// What would make an effect identifiable that is not: a kind for programs and for the page, beside the reason in words.
enum class Lack {
  other,
  vehicle_file,
  surroundings,
  raw_sensors,
  attitude_and_rate,
  attitude,
  body_rate,
  motion,
  torque,
  accelerometer,
  excitation,
};
std::string_view to_string(Lack lack);
Lack lack_named(std::string_view name);  // other for what is no name
// " (it shows in: fast flight)", as a reason ends whose lack is an excitation
std::string shows_in_words(std::string_view shows_in);

struct NotIdentifiable {
  std::string effect, why;
  Lack lack = Lack::other;
  std::string shows_in = {};  // the flight that would show it, where `why` ends with it
};

// Where in the state space a mismatch sits.
struct Region {
  std::string variable;
  double above = 0.0;  // |variable| above which most of it is found
  double share = 0.0;  // of its energy
};

struct Mismatch {
  std::string channel;  // force_x|y|z, torque_x|y|z, actuation, timing
  bool significant = false;
  double p_value = 1.0;
  double rms = 0.0, noise_rms = 0.0;
  std::string unit;
  std::vector<Region> where;
  std::vector<std::string> effects = {};  // actuation and timing: of the catalogue, those that would show here
};

// A reason to believe that something is left.
struct Alarm {
  std::string kind;  // omnibus | whiteness | floor | heteroscedastic
  std::string says;
  double size = 0.0;                  // Δχ² per degree of freedom, or ratio
  std::vector<std::string> channels;  // where
  std::string sensor = {};            // whiteness: whose innovations
};

struct Disturbance {
  std::string group;  // force_xy | force_z | torque_xy | torque_z
  double before = 0.0, after = 0.0;
  std::string unit;
  double correlation_time_s = 0.0;
};

// What a stage of a diagnosis says beside the value that it returns.
struct Remarks {
  std::vector<LogFinding> findings;
  std::vector<std::string> notes;
};

enum class Verdict { consistent, explained, partly_explained, unexplained, insufficient_data };
std::string_view to_string(Verdict verdict);

}  // namespace gustlab::diagnosis
