// A diagnosis in words that a pilot understands: names, channels, variables, numbers with units, the one sentence.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"

namespace gustlab::report {

using Json = nlohmann::ordered_json;

// Lenient access: absent, null and mistyped all mean "not known".
double number(const Json& object, const std::string& key);     // NaN
std::string text(const Json& object, const std::string& key);  // empty
const Json& part(const Json& object, const std::string& key);  // an empty object or array

std::vector<double> numbers(const Json& list);  // each a number or NaN

// What held-out rollouts are asked for, in the order of the page.
struct Quantity {
  const char *key, *name, *unit;
};
inline constexpr Quantity quantities[] = {{"position_m", "position", "m"},
                                          {"velocity_mps", "velocity", "m/s"},
                                          {"attitude_rad", "attitude", "rad"},
                                          {"body_rate_radps", "body rate", "rad/s"}};

// "rotor drag", "loss of rotor 3"
std::string plain_name(const Json& effect);
// Names that the data cannot tell from this one.
std::vector<std::string> alike_in_words(const Json& effect);
std::string plain_label(const std::string& label);
// "push to the side" for force_y
std::string plain_channel(const std::string& channel);
// Names of channels and effects in a sentence, as they are said; files and keys stay.
std::string in_plain_words(const std::string& sentence);
std::string plain_alarm(const std::string& kind);  // as a heading
// "airspeed" and "m/s" for airspeed_mps
struct Variable {
  std::string name, unit;
};
Variable plain_variable(const std::string& variable);
std::string plain_place(const std::string& place);
std::string capital(std::string words);
std::string uncapital(std::string words);
// false where only forces were judged: the recorded attitude was followed; a diagnosis that does not say judged both
bool torque_is_told(const nlohmann::ordered_json& diagnosis);

std::string list_in_words(const std::vector<std::string>& items, const char* last = "and");

// How a number is shown: multiplied by factor, in unit.
struct Display {
  double factor = 1.0;
  std::string unit;
};
// m/s^2 as m/s²
std::string written_unit(std::string unit);
// Small m, s, N, N m, kg in thousandths, what is lost a second in percent a minute, rad as degrees, relative changes in percent; everything else as it is.
Display display_of(const std::string& parameter, const std::string& unit, double magnitude);
// Three significant digits, or a power of ten.
std::string figure(double value);
// value and half-width with the digits that the half-width deserves: "14.7 ± 0.8".
std::string with_half_width(double value, double half_width);
// p-values and confidences
std::string probability(double p);
std::string sure(double confidence);

// Two significant digits, or a power of ten.
std::string short_figure(double value);
// The only flight was cut: the part that found, and the part that checks.
bool one_flight_is_cut(const Json& diagnosis);
// The named effect that these flights cannot tell from this entry, empty when there is none.
std::string named_instead_of(const Json& diagnosis, const Json& entry);
// Mean commands of hover are all that such logs tell.
bool hover_alone(const Json& diagnosis);
// Flights were named with --reference, and what is found is what changed since.
bool has_reference(const Json& diagnosis);
// nothing where the document has no verdict that is known
std::optional<diagnosis::Verdict> verdict_of(const Json& diagnosis);
// The sentence at the top of the page: what was found, in the words of the trade.
std::string one_sentence(const Json& diagnosis);
// What a channel of `mismatch` shows is larger than its noise; of one that is not, many samples may still prove a pattern.
bool above_noise(const Json& channel);
// What held-out predictions gain by what was found, by the names and by the unnamed model, and which of them lose; empty where nothing was
// found or flown.
std::string gain_sentence(const Json& diagnosis);

}  // namespace gustlab::report
