#include "report/trade_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gustlab::report {

namespace {

constexpr double air_density_kgpm3 = 1.225;

double value_of(const Json& effect, const std::string& name) {
  return number(part(part(effect, "parameters"), name), "value");
}

double deviation_of(const Json& effect, const std::string& name) {
  return number(part(part(effect, "parameters"), name), "std");
}

// three significant digits, fewer where the interval is wider: 9.0 %, 12 mm
std::string rounded(double value, double deviation) {
  const double size = std::abs(value);
  if (size == 0.0 || !std::isfinite(size)) return "0";
  const int first = static_cast<int>(std::floor(std::log10(size) + 1e-12));
  const int last = std::isfinite(deviation) && deviation > 0.0
                       ? std::min(first, static_cast<int>(std::floor(std::log10(2.0 * deviation) + 1e-12)))
                       : first - 1;
  const int digits = std::clamp(-std::max(last, first - 2), 0, 8);
  return fmt::format("{:.{}f}", size, digits);
}

// the size of a parameter without its sign, in the unit that is read most easily
std::string size_of(const Json& effect, const std::string& name) {
  const double value = value_of(effect, name);
  const Display display = display_of(name, text(part(part(effect, "parameters"), name), "unit"), std::abs(value));
  const std::string written = rounded(display.factor * value, display.factor * deviation_of(effect, name));
  return display.unit.empty() ? written : written + (display.unit == "°" ? "" : " ") + display.unit;
}

// the length of a vector, with its larger deviation
std::string length_of(const Json& effect, const std::string& unit, const std::vector<const char*>& names) {
  double sum = 0.0, deviation = 0.0;
  for (const char* name : names)
    if (const double value = value_of(effect, name); std::isfinite(value)) {
      sum += value * value;
      if (const double sd = deviation_of(effect, name); std::isfinite(sd)) deviation = std::max(deviation, sd);
    }
  const double length = std::sqrt(sum);
  const Display display = display_of("", unit, length);
  return rounded(display.factor * length, display.factor * deviation) + (display.unit == "°" ? "" : " ") + display.unit;
}

bool surely(const Json& effect, const std::string& name) {
  const double value = value_of(effect, name), deviation = deviation_of(effect, name);
  return std::isfinite(value) && (!std::isfinite(deviation) || std::abs(value) > 2.0 * deviation);
}

// "12 mm forward and 3.0 mm to the left"; the largest alone where none is sure
std::string directions(const Json& effect, const std::array<std::array<const char*, 2>, 3>& words) {
  constexpr std::array<const char*, 3> axis = {"x", "y", "z"};
  std::vector<std::string> parts;
  std::size_t largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = value_of(effect, axis[i]);
    if (!std::isfinite(value)) continue;
    if (!(std::abs(value) < std::abs(value_of(effect, axis[largest])))) largest = i;
    if (surely(effect, axis[i]))
      parts.push_back(size_of(effect, axis[i]) + " " + words[i][static_cast<std::size_t>(value < 0.0)]);
  }
  if (parts.empty())
    parts.push_back(size_of(effect, axis[largest]) + " " +
                    words[largest][static_cast<std::size_t>(value_of(effect, axis[largest]) < 0.0)]);
  return list_in_words(parts);
}

// " (drag area 0.056 m² level and 0.12 m² in a climb)": what the table of the effect says
std::string drag_areas(const Json& effect) {
  std::vector<std::string> areas;
  if (std::isfinite(value_of(effect, "area_xy"))) areas.push_back(size_of(effect, "area_xy") + " level");
  if (surely(effect, "area_z")) areas.push_back(size_of(effect, "area_z") + " in a climb");
  return areas.empty() ? "" : " (drag area " + list_in_words(areas) + ")";
}

bool down(const Json& effect, const char* name = "delta") { return value_of(effect, name) < 0.0; }
std::string rotor(const Json& effect) { return fmt::format("{:.0f}", value_of(effect, "rotor")); }

std::string more(const Json& effect, const char* name = "delta") {
  return size_of(effect, name) + (down(effect, name) ? " less" : " more");
}

std::string wind(const Json& effect) {
  const Json& flights = part(effect, "per_flight");
  double low = std::numeric_limits<double>::infinity(), high = 0.0;
  for (const auto& [file, values] : flights.items()) {
    double sum = 0.0;
    for (const auto& [name, entry] : values.items())
      if (const double v = number(entry, "value"); std::isfinite(v)) sum += v * v;
    low = std::min(low, std::sqrt(sum)), high = std::max(high, std::sqrt(sum));
  }
  if (flights.size() < 2) return fmt::format("A wind of {} blew", length_of(effect, "m/s", {"x", "y", "z"}));
  return fmt::format("Wind blew, {:.1f} to {:.1f} m/s in different flights", low, high);
}

std::string turning(const Json& effect) {
  std::vector<std::string> parts;
  for (const auto& [name, axis] : {std::pair{"delta_x", "roll"}, {"delta_y", "pitch"}, {"delta_z", "yaw"}})
    if (surely(effect, name))
      parts.push_back(
          fmt::format("{} {} in {}", size_of(effect, name), value_of(effect, name) > 0.0 ? "harder" : "easier", axis));
  return parts.empty() ? "The moments of inertia are others" : "The vehicle is " + list_in_words(parts) + " to turn";
}

std::string sag(const Json& effect) {
  if (const double rate = value_of(effect, "rate"); std::isfinite(rate) && rate != 0.0)
    return fmt::format("Thrust {} by {} % a minute as the battery empties", rate > 0.0 ? "falls" : "rises",
                       rounded(6000.0 * rate, 6000.0 * deviation_of(effect, "rate")));
  return fmt::format("Thrust follows the battery's voltage to the power of {}", size_of(effect, "exponent"));
}

std::string limits(const Json& effect) {
  std::vector<std::string> parts;
  if (std::isfinite(value_of(effect, "max_speed")))
    parts.push_back("go no faster than " + size_of(effect, "max_speed"));
  if (const double zone = value_of(effect, "dead_zone"); std::isfinite(zone) && zone > 0.0)
    parts.push_back("do not answer the lowest " + rounded(100.0 * zone, 100.0 * deviation_of(effect, "dead_zone")) +
                    " % of the command");
  return parts.empty() ? "The rotors run into a limit" : "The rotors " + list_in_words(parts);
}

std::string gusts(const Json& effect) {
  if (const double line = value_of(effect, "line_amplitude"); std::isfinite(line) && line > 0.0)
    return fmt::format("Something pushes it with {} at {:.2g} Hz", size_of(effect, "line_amplitude"),
                       value_of(effect, "line_frequency") / (2.0 * std::numbers::pi));
  return fmt::format("Gusts push it with {} (rms)", length_of(effect, "N", {"sigma_xy", "sigma_z"}));
}

// what is said, and what the numbers are compared with at its end: "more" than "its model"; empty: than in other flights alone
struct Headline {
  std::string line;
  const char* against = nullptr;
};

struct Words {
  const char* effect;
  Headline (*headline)(const Json&);
  std::string (*notice)(const Json&);
};

using Text = std::string;
using E = const Json&;

const Words table[] = {
    {"mass",
     [](E e) -> Headline {
       return {"The vehicle weighs " + more(e), "its model"};
     },
     [](E e) -> Text {
       return down(e) ? "It hovers at less throttle and balloons when a manoeuvre begins."
                      : "It hovers at more throttle, climbs more slowly and sinks when a manoeuvre begins.";
     }},
    {"thrust_scale",
     [](E e) -> Headline {
       return {"All rotors push " + more(e), "the model says"};
     },
     [](E e) -> Text {
       return down(e) ? "It hovers at more throttle, and hard climbs end sooner." : "It hovers at less throttle.";
     }},
    {"rotor_loss",
     [](E e) -> Headline {
       return {"Rotor " + rotor(e) + " gives " + size_of(e, "loss") + (down(e, "loss") ? " more" : " less") + " thrust",
               ""};
     },
     [](E e) -> Text {
       return down(e, "loss") ? "It leans away from rotor " + rotor(e) + ", which the controller holds down."
                              : "It leans toward rotor " + rotor(e) +
                                    "; the controller holds it up with more command there, and that motor runs out of "
                                    "reserve first.";
     }},
    {"center_of_mass",
     [](E e) -> Headline {
       return {
           "The centre of mass sits " +
               directions(
                   e, {{{"farther forward", "farther back"}, {"farther left", "farther right"}, {"higher", "lower"}}}),
           "the model has it"};
     },
     [](E e) -> Text {
       if (!surely(e, "x") && !surely(e, "y"))
         return fmt::format("Quick rolls and pitches swing it about a point {} its middle.",
                            down(e, "z") ? "below" : "above");
       return "Hover needs a lasting trim in roll or pitch; without one it drifts to the heavy side.";
     }},
    {"inertia", [](E e) -> Headline { return {turning(e)}; },
     [](E) -> Text {
       return "It answers the sticks at another pace than its tuning expects: it overshoots, or shakes.";
     }},
    {"rotor_tilt",
     [](E e) -> Headline {
       return {"All rotors push along an axis that is tilted by " + length_of(e, "rad", {"x", "y"})};
     },
     [](E) -> Text { return "Held level it slides to one side of its own body, whichever way it points."; }},
    {"motor_lag", [](E e) -> Headline { return {"The motors answer with a lag of " + size_of(e, "time_constant")}; },
     [](E) -> Text { return "It feels soft; high gains in attitude make it shake."; }},
    {"actuation_delay", [](E e) -> Headline { return {"Commands reach the rotors " + size_of(e, "delay") + " late"}; },
     [](E) -> Text { return "High gains in attitude make it shake: the rotors do what is asked, but later."; }},
    {"thrust_curve", [](E) -> Headline { return {"Thrust does not follow the square of rotor speed exactly"}; },
     [](E) -> Text { return "Right in hover, the throttle is wrong in hard climbs and in descents."; }},
    {"saturation", [](E e) -> Headline { return {limits(e)}; },
     [](E) -> Text { return "In hard climbs and turns it gives way, and attitude with it."; }},
    {"battery_sag", [](E e) -> Headline { return {sag(e)}; },
     [](E) -> Text { return "Hover needs more and more throttle during a flight."; }},
    {"yaw_torque_ratio",
     [](E e) -> Headline {
       return {"The rotors turn it " + more(e) + " in yaw", "the model says"};
     },
     [](E e) -> Text { return down(e) ? "Yaw is sluggish." : "Yaw is lively, and may overshoot."; }},
    {"rotor_inertia", [](E) -> Headline { return {"Rotors that speed up kick it in yaw"}; },
     [](E) -> Text { return "Yaw answers with a kick before it settles."; }},
    {"rotor_drag",
     [](E e) -> Headline {
       if (down(e, "at_hover")) return {"Rotor drag is " + size_of(e, "at_hover") + " less", "the model says"};
       return {"Rotor drag of " + size_of(e, "at_hover") + " holds it back"};
     },
     [](E e) -> Text {
       return down(e, "at_hover") ? "It needs less lean to keep its speed, and glides on when level."
                                  : "It must lean more to keep its speed, and stops sooner when level.";
     }},
    {"quadratic_drag", [](E e) -> Headline { return {"The body's drag holds it back at speed" + drag_areas(e)}; },
     [](E) -> Text { return "Fast flight needs more lean and throttle; its top speed is lower."; }},
    {"axial_inflow", [](E) -> Headline { return {"Rotors lose thrust in a climb and gain it in a descent"}; },
     [](E) -> Text { return "Climbs and descents are slower; roll and pitch are damped."; }},
    {"translational_lift", [](E) -> Headline { return {"Rotors gain lift as it flies along"}; },
     [](E) -> Text { return "It balloons as it gains speed, and sinks as it stops."; }},
    {"flapping_torque",
     [](E e) -> Headline {
       return {fmt::format("Its nose is pitched {} as it gains speed", down(e, "coefficient") ? "down" : "up")};
     },
     [](E) -> Text { return "Forward flight needs a lasting push on pitch."; }},
    {"ground_effect", [](E) -> Headline { return {"The ground carries it from below"}; },
     [](E) -> Text { return "It floats when landing, and bounces low over ground."; }},
    {"ceiling_effect", [](E) -> Headline { return {"The ceiling draws it up"}; },
     [](E) -> Text { return "Close under a ceiling it is pulled against it."; }},
    {"wall_effect", [](E) -> Headline { return {"A wall draws it in"}; },
     [](E) -> Text { return "Beside a wall it drifts toward it."; }},
    {"steady_wind", [](E e) -> Headline { return {wind(e)}; },
     [](E) -> Text { return "Hovering it leans into the wind, by the same amount wherever it points."; }},
    {"fans", [](E) -> Headline { return {"Air from fans pushes it"}; },
     [](E) -> Text { return "It is shaken in some places and not in others."; }},
    {"gust", [](E e) -> Headline { return {gusts(e)}; },
     [](E) -> Text { return "It is thrown about in hover, and never in the same way twice."; }},
    {"constant_force",
     [](E e) -> Headline {
       return {"A steady force of " + length_of(e, "N", {"x", "y", "z"}) + " pulls it, always the same way"};
     },
     [](E) -> Text {
       return "Without an integrator it drifts the same way wherever it points: a cable, or a tilted frame.";
     }},
    {"slung_load",
     [](E e) -> Headline {
       return {"A load of " + size_of(e, "mass") +
               (surely(e, "length") ? " swings " + size_of(e, "length") + " below it" : " swings below it")};
     },
     [](E) -> Text { return "It is pulled to and fro for seconds after each stop."; }},
    {"attitude_offset",
     [](E e) -> Headline {
       return {"The logged attitude is tilted by " + length_of(e, "rad", {"x", "y"})};
     },
     [](E) -> Text { return "In a steady hover the log shows a lean. Calibrate the level again."; }},
    {"yaw_offset", [](E e) -> Headline { return {"The logged heading is turned by " + size_of(e, "z")}; },
     [](E) -> Text { return "Flown straight ahead, the log shows it moving to one side."; }},
    {"pose_delay",
     [](E e) -> Headline { return {"Logged positions and attitudes are " + size_of(e, "delay") + " late"}; },
     [](E) -> Text { return "Position control circles round its target when gains are high."; }},
    {"imu_lever",
     [](E e) -> Headline {
       return {
           "The accelerometer sits " +
               directions(
                   e, {{{"farther forward", "farther back"}, {"farther left", "farther right"}, {"higher", "lower"}}}),
           "the model has it"};
     },
     [](E) -> Text { return "Turning shows as acceleration."; }},
    {"gyro_scale",
     [](E e) -> Headline {
       return {"The gyroscope reads " + size_of(e, "delta") + " too " + (down(e) ? "little" : "much")};
     },
     [](E) -> Text { return "Fast turns end at another angle than the one integrated."; }},
    {"estimator_delay", [](E) -> Headline { return {"The vehicle's own estimate is late"}; },
     [](E) -> Text { return "High gains make it shake."; }},
};

const Words* words_for(const std::string& effect) {
  const auto* found =
      std::find_if(std::begin(table), std::end(table), [&](const Words& words) { return effect == words.effect; });
  return found == std::end(table) ? nullptr : found;
}

// certainty as the page prints it, so that equal figures are equal
int certainty(const Json& effect) {
  const double confidence = number(effect, "confidence");
  return std::isfinite(confidence) ? static_cast<int>(std::lround(100.0 * std::min(confidence, 0.995))) : 0;
}

// Δχ² of the record of this name, or what the effect itself says
double weight_of(const Json& diagnosis, const Json& effect) {
  const double rotor_number = value_of(effect, "rotor");
  for (const Json& record : part(diagnosis, "evidence")) {
    const double of_record = number(record, "rotor");
    if (text(record, "effect") == text(effect, "effect") && (!std::isfinite(rotor_number) || of_record == rotor_number))
      return number(record, "delta_chi2");
  }
  const double own = number(effect, "delta_score");
  return std::isfinite(own) ? own : 0.0;
}

}  // namespace

std::string told_on_the_ground(const Json& effect) {
  constexpr std::pair<std::string_view, std::string_view> known[] = {
      {"mass", "a pair of scales"},
      {"thrust_scale", "a thrust stand"},
      {"center_of_mass", "hanging the vehicle from two points"},
      {"inertia", "swinging the vehicle on two strings"},
      {"rotor_loss", "exchanging two propellers"},
      {"steady_wind", "an anemometer"},
      {"attitude_offset", "a level table"}};
  std::vector<std::string> ways;
  for (const Json& other : part(effect, "class")) {
    const std::string label = other.is_string() ? other.get<std::string>() : "";
    for (const auto& [name, way] : known)
      if (label.substr(0, label.find('#')) == name)
        ways.push_back(fmt::format("{} tells the {}", way, plain_label(label)));
  }
  if (alike_in_words(effect).empty()) ways.clear();
  return ways.empty() ? "" : "Without flying, " + list_in_words(ways) + ".";
}

bool has_trade_words(const std::string& effect) { return words_for(effect) != nullptr; }

std::string normal_flights(const Json& effect, const Json& diagnosis) {
  const bool hover = hover_alone(diagnosis);
  if (!hover && part(effect, "total").empty()) return "";
  return hover && !has_reference(diagnosis) ? "the flights taken as normal" : "the reference flights";
}

std::string headline_of(const Json& effect, const Json& diagnosis) {
  if (const Words* words = words_for(text(effect, "effect"))) {
    const auto [line, against] = words->headline(effect);
    const std::string normal = normal_flights(effect, diagnosis);
    if (normal.empty()) return against && *against ? line + " than " + against : line;
    return against ? line + " than in " + normal : line + ", beyond what " + normal + " show";
  }
  const std::string says = text(effect, "says");
  return capital(plain_name(effect)) + (says.empty() ? "" : ": " + says);
}

std::string parameter_in_words(const std::string& effect, const std::string& parameter) {
  struct Axes {
    std::array<const char*, 5> effects;
    std::array<const char*, 3> axes, words;
  };
  static const Axes known[] = {
      {{"rotor_tilt", "center_of_mass", "imu_lever"}, {"x", "y", "z"}, {"forward", "left", "up"}},
      {{"constant_force", "steady_wind"}, {"x", "y", "z"}, {"toward world x", "toward world y", "up"}},
      {{"attitude_offset", "yaw_offset"}, {"x", "y", "z"}, {"roll", "pitch", "yaw"}},
      {{"quadratic_drag"}, {"area_xy", "area_z"}, {"drag area, level", "drag area, up and down"}},
      {{"inertia"}, {"delta_x", "delta_y", "delta_z"}, {"change in roll", "change in pitch", "change in yaw"}}};
  for (const auto& [effects, axes, words] : known)
    if (std::any_of(effects.begin(), effects.end(), [&](const char* name) { return name && effect == name; }))
      for (std::size_t i = 0; i < axes.size(); ++i)
        if (axes[i] && parameter == axes[i]) return words[i];
  // "delta" is said as what it is
  const bool change = parameter == "delta" || parameter.starts_with("delta_");
  return change ? "change" + plain_label(parameter.substr(5)) : plain_label(parameter);
}

std::string notice_of(const Json& effect) {
  const Words* words = words_for(text(effect, "effect"));
  return words ? words->notice(effect) : "";
}

std::vector<Json> in_order_of_weight(const Json& diagnosis) {
  const Json& effects = part(diagnosis, "effects");
  std::vector<Json> ordered(effects.begin(), effects.end());
  std::stable_sort(ordered.begin(), ordered.end(), [&](const Json& a, const Json& b) {
    const int sure_a = certainty(a), sure_b = certainty(b);
    return sure_a != sure_b ? sure_a > sure_b : weight_of(diagnosis, a) > weight_of(diagnosis, b);
  });
  return ordered;
}

std::string remedy_for(diagnosis::Lack lack, const std::string& shows_in) {
  using diagnosis::Lack;
  switch (lack) {  // loggers by their own names
    case Lack::other:
      return "";
    case Lack::vehicle_file:
      return "give it in vehicle.toml (gustlab defaults vehicle)";
    case Lack::surroundings:
      return "give it in the log's sidecar (gustlab defaults sidecar)";
    case Lack::raw_sensors:
      return "log raw sensors: PX4 SDLOG_PROFILE, bit 4 (high rate); ArduPilot LOG_BITMASK, IMU_RAW";
    case Lack::attitude_and_rate:
      return "log attitude and body rate at 50 Hz or more: PX4 SDLOG_PROFILE, bit 4 (high rate); ArduPilot "
             "LOG_BITMASK, ATTITUDE_FAST; a "
             "Crazyflie's log blocks stateEstimate and gyro";
    case Lack::attitude:
      return "log attitude: PX4 vehicle_attitude; ArduPilot LOG_BITMASK, ATTITUDE_FAST";
    case Lack::body_rate:
      return "log body rate at 50 Hz or more: PX4 SDLOG_PROFILE, bit 4 (high rate); ArduPilot LOG_BITMASK, IMU_FAST; a "
             "Crazyflie's log block gyro";
    case Lack::motion:
      return "log position or velocity: motion capture, GNSS or the estimator's own";
    case Lack::torque:
      return "log body rate and every motor at 100 Hz or more: PX4 SDLOG_PROFILE, bits 3 (system identification) and 4 "
             "(high rate); ArduPilot "
             "LOG_BITMASK, "
             "RCOUT and IMU_FAST; Betaflight blackbox_sample_rate";
    case Lack::accelerometer:
      return "log the accelerometer: PX4 sensor_combined; ArduPilot LOG_BITMASK, IMU";
    case Lack::excitation:
      return shows_in.empty() ? "" : "fly: " + shows_in;
  }
  return "";
}

std::string likeness(const Json& term, double weight_N) {
  constexpr std::array<const char*, 3> places{"px", "py", "pz"};
  const std::string channel = text(term, "channel"), name = text(term, "term");
  const double c = number(term, "coefficient"), size = std::abs(c);
  if (!std::isfinite(c) || channel.size() < 2) return "";
  const bool force = channel.starts_with("force");
  const char axis = channel.back();
  const std::string own = fmt::format("v{}_B", axis);
  const bool weight_known = weight_N > 0.0;
  if (force && name == "1") {
    if (axis == 'z' && weight_known)
      return fmt::format("like {} % {} weight", figure(100.0 * size / weight_N), c < 0.0 ? "more" : "less");
    return weight_known ? fmt::format("like an attitude that is off by {}°",
                                      figure(std::atan(size / weight_N) * 180.0 / std::numbers::pi))
                        : "like a steady push";
  }
  if (force && name == own) {
    if (c > 0.0) return "a push along its own motion, which no drag gives";
    return axis == 'z' ? fmt::format("like rotors that lose {} N for each m/s of climb", figure(size))
                       : fmt::format("like rotor drag of {} N s/m", figure(size));
  }
  if (force && (name == own + " abs " + own || name == own + " speed"))
    return c > 0.0 ? "a push along its own motion, which no drag gives"
                   : fmt::format("like a drag area of {} m²", figure(2.0 * size / air_density_kgpm3));
  if (force && axis == 'z' && (name == "vx_B^2" || name == "vy_B^2" || name == "speed"))
    return c > 0.0 ? "like lift that grows with speed" : "like lift that is lost with speed";
  if (force && name == "speed") return "a push that grows with speed, whichever way it flies";
  const bool of_place = std::any_of(places.begin(), places.end(),
                                    [&](const char* place) { return name.find(place) != std::string::npos; });
  if (force && of_place) return "a push that depends on the place: a wall, a draught, or a position frame that is bent";
  if (!force && name == "1" && axis != 'z' && weight_known)
    return fmt::format("like a centre of mass {} mm aside", figure(1e3 * size / weight_N));
  if (!force && name == "1" && axis == 'z') return "like a lasting trim in yaw";
  if (!force && (name == "vx_B" || name == "vy_B") && axis != 'z')
    return fmt::format("like flapping rotors: {} mN m for each m/s", figure(1e3 * size));
  return "";
}

}  // namespace gustlab::report
