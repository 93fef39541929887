#include "report/diagnosis_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "report/trade_words.hpp"

namespace gustlab::report {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double degrees = 180.0 / 3.14159265358979323846;

std::string superscript(int exponent) {
  static const std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string written;
  for (const char c : std::to_string(exponent)) written += c == '-' ? "⁻" : digits[static_cast<std::size_t>(c - '0')];
  return written;
}

// a minus sign that is one
std::string signed_text(std::string written) {
  if (!written.empty() && written.front() == '-') written = "−" + written.substr(1);
  return written;
}

std::string decimals(double value, int digits) {
  std::string written = fmt::format("{:.{}f}", value, digits);
  if (written.find_first_not_of("-0.") == std::string::npos && written.front() == '-') written.erase(0, 1);
  return signed_text(written);
}

std::string on_what_was_not_used(const Json& diagnosis) {
  return one_flight_is_cut(diagnosis) ? "on the last third of the flight, which was not used to find it"
                                      : "on flights that were not used to find it";
}

// what the position half a second ahead gains; empty when nothing was flown, or no gain shows
std::string gain_in_words(const Json& diagnosis) {
  const Json& fit = part(diagnosis, "fit");
  const Json& errors = part(fit, "position_m");
  const Json& model = part(diagnosis, "residual_model");
  const std::vector<double> horizons = numbers(part(fit, "horizon_s")), before = numbers(part(errors, "before")),
                            after = numbers(part(errors, "after")),
                            without = numbers(part(part(model, "fit_without"), "position_m"));
  std::size_t best = 0;
  for (std::size_t h = 0; h < horizons.size(); ++h)
    if (std::abs(horizons[h] - 0.5) < std::abs(horizons[best] - 0.5)) best = h;
  if (best >= before.size() || best >= after.size()) return "";
  const double from = before[best], to = after[best];
  if (!(to < from)) return "";
  const auto [factor, unit] = from < 0.01 ? Display{1e3, "mm"} : from < 1.0 ? Display{1e2, "cm"} : Display{1.0, "m"};
  const auto length = [&](double metres) {
    return fmt::format("{} {}", decimals(factor * metres, factor * to < 10.0 ? 1 : 0), unit);
  };
  if (length(to) == length(from)) return "";
  const bool named = !part(diagnosis, "effects").empty();
  const std::string on = on_what_was_not_used(diagnosis);
  if (named && best < without.size() && std::isfinite(without[best]))
    return fmt::format(
        "The position predicted {:g} s ahead is wrong by {} in the simulation as it was, by {} with what was named, "
        "and by "
        "{} with a model of the rest that has no name as well, {}.",
        horizons[best], length(from), length(without[best]), length(to), on);
  const char* what = model.empty() ? "what was found"
                     : !named      ? "a model that has no name"
                                   : "what was found and a model of the rest that has no name";
  return fmt::format("With {}, the position predicted {:g} s ahead is wrong by {} instead of {}, {}.", what,
                     horizons[best], length(to), length(from), on);
}

// calls back with every mean error of `after` that is known, and with what it was before and with values kept
template <typename Visit>
void for_each_error(const Json& diagnosis, const Visit& visit) {
  const Json& fit = part(diagnosis, "fit");
  const std::vector<double> horizons = numbers(part(fit, "horizon_s"));
  for (const Quantity& quantity : quantities) {
    const Json& errors = part(fit, quantity.key);
    const std::vector<double> after = numbers(part(errors, "after"));
    const auto at = [&](const char* kind, std::size_t h) {
      const std::vector<double> values = numbers(part(errors, kind));
      return h < values.size() ? values[h] : nan;
    };
    for (std::size_t h = 0; h < std::min(horizons.size(), after.size()); ++h)
      if (std::isfinite(after[h])) visit(quantity, horizons[h], after[h], at("before", h), at("hold", h));
  }
}

constexpr double least_worse = 1.01;  // less is said to be equal

// predictions that lose by what was found
std::string losses_in_words(const Json& diagnosis) {
  std::vector<std::string> worse;
  for_each_error(diagnosis, [&](const Quantity& quantity, double ahead_s, double after, double before, double) {
    if (!(after > least_worse * before)) return;
    const Display display = display_of("", quantity.unit, after);
    worse.push_back(fmt::format("{} {:g} s ahead ({} {} instead of {})", quantity.name, ahead_s,
                                figure(display.factor * after), display.unit, figure(display.factor * before)));
  });
  return worse.empty() ? "" : "Worse than before: " + list_in_words(worse) + ".";
}

// predictions that are worse than none: "velocity 0.5 and 1 s ahead"
std::string kept_in_words(const Json& diagnosis) {
  std::vector<std::pair<const char*, std::vector<std::string>>> kept;  // horizons of each quantity
  for_each_error(diagnosis, [&](const Quantity& quantity, double ahead_s, double after, double, double hold) {
    if (!(after > least_worse * hold)) return;
    if (kept.empty() || kept.back().first != quantity.name) kept.push_back({quantity.name, {}});
    kept.back().second.push_back(fmt::format("{:g}", ahead_s));
  });
  std::vector<std::string> items;
  for (const auto& [name, ahead_s] : kept) items.push_back(fmt::format("{} {} s ahead", name, list_in_words(ahead_s)));
  return items.empty() ? "" : "Still worse than no model, which keeps the last values: " + list_in_words(items) + ".";
}

// what the residual is and where: the strongest channel with its first region
std::string where_in_words(const Json& diagnosis) {
  const Json* strongest = nullptr;
  double ratio = 0.0;
  for (const Json& entry : part(diagnosis, "mismatch")) {
    const bool told = torque_is_told(diagnosis) || !text(entry, "channel").starts_with("torque");
    if (!entry.value("significant", false) || !told || !above_noise(entry)) continue;
    const double here = number(entry, "rms") / number(entry, "noise_rms");
    if (!strongest || here > ratio) strongest = &entry, ratio = here;
  }
  if (!strongest) return "";
  std::string words = "mostly in the " + plain_channel(text(*strongest, "channel"));
  const Json& where = part(*strongest, "where");
  if (!where.empty()) {
    const Variable variable = plain_variable(text(where[0], "variable"));
    const bool above = where[0].contains("above");
    const double limit = number(where[0], above ? "above" : "below");
    if (std::isfinite(limit))
      words += fmt::format(", when {} is {} {} {}", variable.name, above ? "above" : "below", short_figure(limit),
                           variable.unit);
  }
  return words;
}

// the findings as one sentence: the first three in words, the rest counted
std::string findings_in_words(const Json& diagnosis) {
  constexpr std::size_t most = 3;
  const std::vector<Json> effects = in_order_of_weight(diagnosis);
  std::vector<std::string> clauses;
  for (std::size_t i = 0; i < std::min(most, effects.size()); ++i) {
    const std::vector<std::string> alike = alike_in_words(effects[i]);
    std::string clause = headline_of(effects[i], diagnosis);
    if (!alike.empty()) clause += " (or " + (alike.size() == 1 ? alike.front() : "what looks the same") + ")";
    // a sentence goes on in small letters
    if (i > 0) clause = uncapital(clause);
    clauses.push_back(clause);
  }
  if (effects.size() > most)
    clauses.push_back(effects.size() == most + 1 ? "one thing more"
                                                 : fmt::format("{} things more", effects.size() - most));
  std::string sentence;
  for (std::size_t i = 0; i < clauses.size(); ++i)
    sentence += (i == 0 ? "" : i + 1 < clauses.size() ? "; " : "; and ") + clauses[i];
  return sentence;
}

}  // namespace

double number(const Json& object, const std::string& key) {
  return object.is_object() && object.contains(key) && object.at(key).is_number() ? object.at(key).get<double>() : nan;
}

std::string text(const Json& object, const std::string& key) {
  return object.is_object() && object.contains(key) && object.at(key).is_string() ? object.at(key).get<std::string>()
                                                                                  : "";
}

const Json& part(const Json& object, const std::string& key) {
  static const Json nothing = Json::array();
  const bool there =
      object.is_object() && object.contains(key) && (object.at(key).is_object() || object.at(key).is_array());
  return there ? object.at(key) : nothing;
}

std::vector<double> numbers(const Json& list) {
  std::vector<double> found;
  for (const Json& item : list) found.push_back(item.is_number() ? item.get<double>() : nan);
  return found;
}

bool above_noise(const Json& channel) {
  constexpr double least = 1.05;
  // nothing is within a noise that is not known
  return !(number(channel, "rms") < least * number(channel, "noise_rms"));
}

std::string plain_label(const std::string& written) {
  // "rotor_loss (rotor 3)", as a name that was rejected is written, is rotor_loss#3
  constexpr std::string_view of_rotor = " (rotor ";
  const std::size_t rotor = written.find(of_rotor);
  const std::string label =
      rotor == std::string::npos || !written.ends_with(')')
          ? written
          : written.substr(0, rotor) + "#" +
                written.substr(rotor + of_rotor.size(), written.size() - rotor - of_rotor.size() - 1);
  const std::size_t mark = label.find('#');
  std::string name = label.substr(0, mark);
  if (mark != std::string::npos && name == "rotor_loss") return "loss of rotor " + label.substr(mark + 1);
  if (name == "imu_lever") name = "place_of_the_accelerometer";
  std::replace(name.begin(), name.end(), '_', ' ');
  const std::string from = "center", to = "centre";
  if (const std::size_t at = name.find(from); at != std::string::npos) name.replace(at, from.size(), to);
  return mark == std::string::npos ? name : name + " " + label.substr(mark + 1);
}

std::vector<std::string> alike_in_words(const Json& effect) {
  std::vector<std::string> names;
  for (const Json& other : part(effect, "class"))
    if (other.is_string() && other != text(effect, "effect") &&
        plain_label(other.get<std::string>()) != plain_name(effect))
      names.push_back(plain_label(other.get<std::string>()));
  return names;
}

std::string plain_name(const Json& effect) {
  const std::string name = text(effect, "effect");
  const double fitted = number(part(part(effect, "parameters"), "rotor"), "value");
  const double rotor = std::isfinite(fitted) ? fitted : number(effect, "rotor");
  return plain_label(std::isfinite(rotor) ? fmt::format("{}#{:.0f}", name, rotor) : name);
}

std::string plain_channel(const std::string& channel) {
  static const std::array<std::pair<const char*, const char*>, 13> words{{{"force_x", "push forward or back"},
                                                                          {"force_y", "push to the side"},
                                                                          {"force_z", "lift"},
                                                                          {"force_xy", "horizontal push"},
                                                                          {"torque_x", "roll torque"},
                                                                          {"torque_y", "pitch torque"},
                                                                          {"torque_z", "yaw torque"},
                                                                          {"torque_xy", "roll and pitch torque"},
                                                                          {"actuation", "rotors' answer to commands"},
                                                                          {"timing", "timing of the log"},
                                                                          {"time_s", "time"},
                                                                          {"force", "push"},
                                                                          {"torque", "torque"}}};
  for (const auto& [name, said] : words)
    if (channel == name) return said;
  return plain_label(channel);
}

std::string in_plain_words(const std::string& sentence) {
  std::string said;
  for (std::size_t at = 0; at < sentence.size();) {
    const std::size_t end = std::min(sentence.find(' ', at), sentence.size());
    std::string word = sentence.substr(at, end - at);
    // what stands before a colon or a comma, but no path, file or key
    const std::size_t tail = std::min(word.find_last_not_of(",;:()") + 1, word.size());
    const std::size_t head = std::min(word.find_first_not_of('('), tail);
    const std::string name = word.substr(head, tail - head);
    const bool plain = name.find('_') != std::string::npos && std::all_of(name.begin(), name.end(), [](char c) {
                         return c == '_' || std::islower(static_cast<unsigned char>(c));
                       });
    if (plain) word = word.substr(0, head) + plain_channel(name) + word.substr(tail);
    said += word + (end < sentence.size() ? " " : "");
    at = end + 1;
  }
  return said;
}

std::string plain_alarm(const std::string& kind) {
  if (kind == "omnibus") return "A pattern is left";
  if (kind == "whiteness") return "Not just noise";
  if (kind == "floor") return "Rough air, or more";
  if (kind == "heteroscedastic") return "Uneven disturbance";
  return capital(plain_label(kind));
}

Variable plain_variable(const std::string& variable) {
  static const std::array<std::pair<const char*, const char*>, 9> units{{{"_radps2", "rad/s²"},
                                                                         {"_radps", "rad/s"},
                                                                         {"_mps2", "m/s²"},
                                                                         {"_mps", "m/s"},
                                                                         {"_rad", "rad"},
                                                                         {"_m", "m"},
                                                                         {"_s", "s"},
                                                                         {"_N", "N"},
                                                                         {"_V", "V"}}};
  for (const auto& [suffix, unit] : units)
    if (variable.ends_with(suffix))
      return {plain_label(variable.substr(0, variable.size() - std::string(suffix).size())), unit};
  return {plain_label(variable), ""};
}

std::string list_in_words(const std::vector<std::string>& items, const char* last) {
  std::string words;
  for (std::size_t i = 0; i < items.size(); ++i)
    words += (i == 0 ? "" : i + 1 < items.size() ? ", " : fmt::format(" {} ", last)) + items[i];
  return words;
}

std::string written_unit(std::string unit) {
  for (const auto& [plain, nice] : {std::pair{"^2", "²"}, std::pair{"^3", "³"}, std::pair{"kg m2", "kg m²"}})
    if (const std::size_t at = unit.find(plain); at != std::string::npos)
      unit.replace(at, std::string(plain).size(), nice);
  return unit;
}

Display display_of(const std::string& parameter, const std::string& unit, double magnitude) {
  if (unit == "m" && magnitude < 0.1) return {1e3, "mm"};
  if (unit == "s" && magnitude < 1.0) return {1e3, "ms"};
  if (unit == "N" && magnitude < 0.1) return {1e3, "mN"};
  if (unit == "N m" && magnitude < 0.1) return magnitude < 1e-3 ? Display{1e6, "µN m"} : Display{1e3, "mN m"};
  if (unit == "kg" && magnitude < 0.1) return {1e3, "g"};
  if (unit == "1/s" && parameter == "rate") return {6000.0, "%/min"};
  if (unit == "rad") return {degrees, "°"};
  if (unit == "-" || unit == "–" || unit.empty()) {
    const bool share = parameter.starts_with("delta") || parameter == "loss";
    return share ? Display{100.0, "%"} : Display{1.0, ""};
  }
  return {1.0, written_unit(unit)};
}

std::string capital(std::string words) {
  if (!words.empty()) words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  return words;
}

std::string uncapital(std::string words) {
  if (!words.empty()) words.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(words.front())));
  return words;
}

std::string plain_place(const std::string& place) {
  if (place == "body") return "in the body";
  if (place == "actuation") return "between command and rotor";
  if (place == "rotor") return "in the rotors";
  if (place == "wrench") return "from the air or outside";
  if (place == "measurement") return "in the recording";
  return place;
}

std::string figure(double value) {
  if (!std::isfinite(value)) return "–";
  if (value == 0.0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-12));
  if (exponent < -3 || exponent > 5)
    return fmt::format("{} × 10{}", decimals(value / std::pow(10.0, exponent), 2), superscript(exponent));
  return decimals(value, std::max(0, 2 - exponent));
}

std::string short_figure(double value) {
  if (!std::isfinite(value)) return "–";
  if (value == 0.0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-12));
  const double unit = std::pow(10.0, exponent - 1), rounded = unit * std::round(value / unit);
  if (exponent < -4 || exponent > 5)
    return signed_text(fmt::format("{:.2g} × 10{}", rounded / std::pow(10.0, exponent), superscript(exponent)));
  return signed_text(exponent > 0 ? fmt::format("{:.0f}", rounded) : fmt::format("{:.2g}", rounded));
}

bool one_flight_is_cut(const Json& diagnosis) {
  const Json& flights = part(diagnosis, "flights");
  const auto is = [](const char* role) { return [role](const Json& flight) { return text(flight, "role") == role; }; };
  const auto found = std::find_if(flights.begin(), flights.end(), is("fit"));
  const auto checks = std::find_if(flights.begin(), flights.end(), is("holdout"));
  return found != flights.end() && checks != flights.end() && !text(*found, "file").empty() &&
         text(*found, "file") == text(*checks, "file");
}

std::string named_instead_of(const Json& diagnosis, const Json& entry) {
  const std::string name = text(entry, "effect");
  const Json& effects = part(diagnosis, "effects");
  const auto same = [&](const Json& other) { return other.is_string() && other.get<std::string>() == name; };
  for (const Json& effect : effects)
    if (text(effect, "effect") == name) return "";
  for (const Json& effect : effects) {
    const Json& alike = part(effect, "class");
    if (std::any_of(alike.begin(), alike.end(), same)) return plain_name(effect);
  }
  return "";
}

std::string with_half_width(double value, double half_width) {
  if (!std::isfinite(half_width) || half_width <= 0.0) return figure(value);
  const int exponent = static_cast<int>(std::floor(std::log10(std::max(std::abs(value), half_width)) + 1e-12));
  const double power = exponent < -3 || exponent > 5 ? std::pow(10.0, exponent) : 1.0;
  // the half-width gets two digits, the value as many decimals
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(half_width / power) + 1e-12)), 0, 8);
  const std::string both =
      fmt::format("{} ± {}", decimals(value / power, digits), decimals(half_width / power, digits));
  return power == 1.0 ? both : fmt::format("({}) × 10{}", both, superscript(exponent));
}

std::string probability(double p) {
  if (!std::isfinite(p)) return "–";
  if (p < 1e-12) return "< 10⁻¹²";
  if (p >= 1e-3) return fmt::format("{:.2g}", p);
  const int exponent = static_cast<int>(std::floor(std::log10(p) + 1e-12));
  return fmt::format("{:.0f} × 10{}", p / std::pow(10.0, exponent), superscript(exponent));
}

std::string sure(double confidence) {
  if (!std::isfinite(confidence)) return "–";
  if (confidence < 0.005) return "less than 1 %";
  return confidence > 0.995 ? "more than 99 %" : fmt::format("{:.0f} %", 100.0 * confidence);
}

std::optional<diagnosis::Verdict> verdict_of(const Json& diagnosis) {
  using enum diagnosis::Verdict;
  const std::string said = text(diagnosis, "verdict");
  for (const diagnosis::Verdict verdict : {consistent, explained, partly_explained, unexplained, insufficient_data})
    if (said == to_string(verdict)) return verdict;
  return std::nullopt;
}

std::string one_sentence(const Json& diagnosis) {
  using diagnosis::Verdict;
  const std::optional<Verdict> verdict = verdict_of(diagnosis);
  const std::string vehicle = text(diagnosis, "vehicle");
  const std::string model = vehicle.empty() ? "The simulation" : "The simulation of " + vehicle;
  const std::string where = where_in_words(diagnosis);
  const bool compared = has_reference(diagnosis);
  if (verdict == Verdict::consistent && hover_alone(diagnosis))
    return "In hover the flights" + (vehicle.empty() ? "" : " of " + vehicle) +
           " agree with each other; nothing else can be told from them.";
  if (verdict == Verdict::consistent && compared)
    return std::string(part(diagnosis, "suspected").empty() ? "Nothing changed" : "Nothing is proved to have changed") +
           " since the reference flights" + (vehicle.empty() ? "" : " of " + vehicle) + " beyond noise and calm air.";
  if (verdict == Verdict::consistent)
    return model + " agrees with these flights: nothing is " +
           (part(diagnosis, "suspected").empty() ? "left" : "proved") + " beyond noise and calm air.";
  if (verdict == Verdict::insufficient_data) {
    // the reason, when there is one for all
    const Json& blind = part(diagnosis, "not_identifiable");
    const bool one_reason = !blind.empty() && std::all_of(blind.begin(), blind.end(), [&](const Json& entry) {
      return text(entry, "why") == text(blind[0], "why");
    });
    const std::string why = one_reason               ? ": " + text(blind[0], "why")
                            : hover_alone(diagnosis) ? ""
                                                     : ": the logged commands are samples of a faster loop, and what "
                                                       "the rotors did between is not known. Log at the loop's rate";
    return "These flights cannot tell whether the simulation" + (vehicle.empty() ? "" : " of " + vehicle) +
           " is right or wrong" + why + ".";
  }
  if (verdict == Verdict::unexplained) {
    return fmt::format("Something acts on {} that {}{}, and no effect known here is sure enough to be named.",
                       vehicle.empty() ? "the vehicle" : vehicle,
                       compared ? "neither the simulation nor the reference flights show" : "the simulation leaves out",
                       where.empty() ? "" : " (" + where + ")");
  }

  return findings_in_words(diagnosis) + (verdict == Verdict::partly_explained ? ". Something else remains." : ".");
}

bool hover_alone(const Json& diagnosis) {
  const Json& blind = part(diagnosis, "not_identifiable");
  return std::any_of(blind.begin(), blind.end(), [](const Json& entry) {
    return diagnosis::lack_named(text(entry, "lack")) == diagnosis::Lack::attitude_and_rate;
  });
}

bool has_reference(const Json& diagnosis) {
  const Json& flights = part(diagnosis, "flights");
  return std::any_of(flights.begin(), flights.end(),
                     [](const Json& flight) { return text(flight, "role") == "reference"; });
}

bool torque_is_told(const Json& diagnosis) {
  const auto told = diagnosis.find("torque_told");
  return told == diagnosis.end() || !told->is_boolean() || told->get<bool>();
}

std::string gain_sentence(const Json& diagnosis) {
  if (part(diagnosis, "effects").empty() && part(diagnosis, "residual_model").empty()) return "";
  std::string words;
  for (const std::string& sentence : {gain_in_words(diagnosis), losses_in_words(diagnosis), kept_in_words(diagnosis)})
    if (!sentence.empty()) words += (words.empty() ? "" : " ") + sentence;
  return words;
}

}  // namespace gustlab::report
