#include "report/diagnosis_charts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "report/diagnosis_words.hpp"
#include "report/page_parts.hpp"
#include "report/svg.hpp"

namespace gustlab::report {

namespace {

using svg::escape;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, std::abs(value));
  return most;
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

// the curves that were handed over, or what the fit block has
std::vector<DiagnosisFigures::Horizon> curves(const Json& diagnosis, const DiagnosisFigures& figures) {
  if (!figures.horizons.empty()) return figures.horizons;
  std::vector<DiagnosisFigures::Horizon> found;
  const Json& fit = part(diagnosis, "fit");
  for (const Quantity& quantity : quantities) {
    const Json& errors = part(fit, quantity.key);
    if (errors.empty()) continue;
    DiagnosisFigures::Horizon curve;
    curve.quantity = quantity.key;
    curve.horizon_s = numbers(part(fit, "horizon_s"));
    curve.hold = numbers(part(errors, "hold"));
    curve.before = numbers(part(errors, "before"));
    curve.after = numbers(part(errors, "after"));
    curve.noise = numbers(part(errors, "noise"));
    found.push_back(std::move(curve));
  }
  return found;
}

const Quantity& quantity_of(const std::string& key) {
  for (const Quantity& quantity : quantities)
    if (key == quantity.key) return quantity;
  return quantities[0];
}

// what the second model is: with names, or only with what is no missing physics; empty when it is the first
std::string after_label(const Json& diagnosis) {
  if (!part(diagnosis, "effects").empty() || !part(diagnosis, "residual_model").empty()) return "with what was found";
  if (!part(diagnosis, "reference_effects").empty()) return "with what the reference flights show";
  return part(diagnosis, "calibration").empty() ? "" : "with small corrections";
}

using Entries = std::vector<std::pair<std::string, std::string>>;

Entries with_after(const Json& diagnosis, Entries entries) {
  if (const std::string label = after_label(diagnosis); !label.empty())
    entries.insert(std::find_if(entries.begin(), entries.end(), [](const auto& e) { return e.first == "before"; }) + 1,
                   {"after", label});
  return entries;
}

std::string horizon_chart(const DiagnosisFigures::Horizon& curve, bool after) {
  const Quantity& quantity = quantity_of(curve.quantity);
  const double most = std::max({largest(curve.before), largest(curve.after), largest(curve.hold)});
  const Display display = display_of("", quantity.unit, most);
  svg::Chart chart;
  chart.title = fmt::format("{} error", capital(quantity.name));
  chart.y_label = display.unit;
  chart.x_label = "prediction horizon [s]";
  chart.log_y = true;
  const auto add = [&](const char* style, const std::vector<double>& y, const std::vector<double>& low,
                       const std::vector<double>& high) {
    const bool points = std::string_view(style) == "before" || std::string_view(style) == "after";
    chart.series.push_back({style, points ? svg::Mark::points_with_bars : svg::Mark::line, curve.horizon_s,
                            scaled(y, display.factor), scaled(low, display.factor), scaled(high, display.factor)});
  };
  add("hold", curve.hold, {}, {});
  add("noise", curve.noise, {}, {});
  add("before", curve.before, curve.before_low, curve.before_high);
  if (after) add("after", curve.after, curve.after_low, curve.after_high);
  return svg::draw(chart);
}

std::string horizon_table(const Json& diagnosis) {
  const Json& fit = part(diagnosis, "fit");
  const std::vector<double> horizons = numbers(part(fit, "horizon_s"));
  std::string rows;
  for (const Quantity& quantity : quantities) {
    const Json& errors = part(fit, quantity.key);
    if (errors.empty()) continue;
    for (std::size_t h = 0; h < horizons.size(); ++h) {
      std::string cells;
      bool any = false;
      for (const char* key : {"hold", "before", "after", "noise"}) {
        const std::vector<double> values = numbers(part(errors, key));
        const double value = h < values.size() ? values[h] : std::numeric_limits<double>::quiet_NaN();
        any = any || std::isfinite(value);
        // angles in degrees, as in the charts
        const Display display = display_of("", quantity.unit, 1.0);
        cells += std::isfinite(value)
                     ? fmt::format("<td class=\"n\">{} {}</td>", figure(display.factor * value), display.unit)
                     : "<td class=\"n\">–</td>";
      }
      // what was not predicted at all has no row
      if (any)
        rows += fmt::format("<tr><td class=\"name\">{}</td><td class=\"n\">{:g} s</td>{}</tr>", capital(quantity.name),
                            horizons[h], cells);
    }
  }
  return "<details><summary>The numbers</summary>" +
         card_table({{"quantity"},
                     {"horizon", true},
                     {"values kept", true},
                     {"before", true},
                     {"after", true},
                     {"noise floor", true}},
                    rows) +
         "</details>";
}

std::string files_of(const Json& diagnosis, const std::string& role) {
  std::vector<std::string> files;
  for (const Json& flight : part(diagnosis, "flights"))
    if (text(flight, "role") == role) files.push_back(text(flight, "file"));
  return list_in_words(files);
}

std::string residual_chart(const DiagnosisFigures::Residual& residual) {
  const Variable variable = plain_variable(residual.variable);
  svg::Chart chart;
  chart.title = capital(plain_channel(residual.channel));
  const Display display = display_of("", residual.unit, largest(residual.y));
  chart.y_label = display.unit;
  chart.x_label = variable.unit.empty() ? variable.name : fmt::format("{} [{}]", variable.name, variable.unit);
  chart.zero_y = true;
  chart.series.push_back({"cloud", svg::Mark::dots, residual.x, scaled(residual.y, display.factor), {}, {}});
  chart.series.push_back({"before", svg::Mark::points_with_bars, residual.bin_x,
                          scaled(residual.before_mean, display.factor), scaled(residual.before_low, display.factor),
                          scaled(residual.before_high, display.factor)});
  chart.series.push_back({"after", svg::Mark::points_with_bars, residual.bin_x,
                          scaled(residual.after_mean, display.factor), scaled(residual.after_low, display.factor),
                          scaled(residual.after_high, display.factor)});
  return svg::draw(chart);
}

}  // namespace

std::string horizon_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures) {
  std::string charts;
  for (const DiagnosisFigures::Horizon& curve : curves(diagnosis, figures))
    charts += horizon_chart(curve, !after_label(diagnosis).empty());
  if (charts.empty()) return "";
  const double windows = number(part(diagnosis, "fit"), "windows");
  const std::string files = files_of(diagnosis, "holdout");
  std::string caption =
      "Mean error of open-loop predictions in the simulator, from recorded states with recorded commands";
  if (std::isfinite(windows)) caption += fmt::format(", over {:.0f} windows", windows);
  if (!files.empty()) caption += fmt::format(" of {}", escape(files));
  caption += figures.windows_left_out.empty() ? ". No window was left out."
                                              : fmt::format(". Left out: {}.", escape(figures.windows_left_out));
  if (!figures.horizons.empty() && !figures.horizons.front().before_low.empty())
    caption += " Bars: 95 % intervals (block bootstrap).";
  const char* on =
      one_flight_is_cut(diagnosis) ? "the last third of the flight, which was" : "held-out flights, which were";
  return fmt::format(
             "<section><h2>How much better it predicts</h2><p>On {} not used to find the effects. The noise "
             "floor is what the sensors alone would give.</p><figure>",
             on) +
         legend(with_after(
             diagnosis,
             {{"before", "simulation as it was"}, {"noise", "noise floor"}, {"hold", "no model: values kept"}})) +
         "<div class=\"charts\">" + charts + "</div><figcaption>" + caption + "</figcaption></figure>" +
         horizon_table(diagnosis) + "</section>";
}

namespace {

// the table of channels says that it is no larger than noise and air, and its means may still follow a variable
bool is_within_noise(const Json& diagnosis, const std::string& channel) {
  const Json& channels = part(diagnosis, "mismatch");
  return std::any_of(channels.begin(), channels.end(),
                     [&](const Json& entry) { return text(entry, "channel") == channel && !above_noise(entry); });
}

}  // namespace

std::string residual_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures) {
  std::string charts;
  std::vector<std::string> notes;
  const bool torque_told = torque_is_told(diagnosis);
  for (const DiagnosisFigures::Residual& residual : figures.residuals) {
    if (!torque_told && residual.channel.starts_with("torque")) continue;
    const std::string chart = residual_chart(residual);
    if (chart.empty()) continue;
    charts += chart;
    const auto blocks = std::count_if(residual.y.begin(), residual.y.end(), [](double y) { return std::isfinite(y); });
    notes.push_back(fmt::format("{} against {}: N = {} blocks{}{}", capital(plain_channel(residual.channel)),
                                plain_variable(residual.variable).name, blocks,
                                residual.left_out.empty() ? ", none left out" : ", left out: " + residual.left_out,
                                is_within_noise(diagnosis, residual.channel)
                                    ? "; from one moment to the next, noise and air make as much"
                                    : ""));
  }
  if (charts.empty()) return "";
  return "<section><h2>What is left over, and what it depends on</h2><p>What acts on the vehicle beyond the "
         "simulation, estimated "
         "along the flights, against the variable that matters most. A flat blue line at zero means that nothing is "
         "left." +
         std::string(part(diagnosis, "residual_model").empty()
                         ? ""
                         : " After is with the names, and without the unnamed effect.") +
         "</p><figure>" + legend({{"before", "mean before"}, {"after", "mean after"}}) + "<div class=\"charts\">" +
         charts +
         "</div><figcaption>Each faint dot is the mean of one block, a short stretch of a flight, before. Bars: 95 % "
         "intervals of the bin "
         "means. " +
         escape(fmt::format("{}", fmt::join(notes, " · "))) + ".</figcaption></figure></section>";
}

namespace {

const DiagnosisFigures::Trace* trace_of(const DiagnosisFigures& figures, std::string_view name) {
  for (const DiagnosisFigures::Trace& trace : figures.window.traces)
    if (trace.name == name) return &trace;
  return nullptr;
}

// noise floor of a quantity as far ahead as the window's predictions go, NaN when nothing tells
double noise_at(const Json& diagnosis, const char* quantity, double horizon_s) {
  const Json& fit = part(diagnosis, "fit");
  const std::vector<double> horizons = numbers(part(fit, "horizon_s")),
                            noise = numbers(part(part(fit, quantity), "noise"));
  for (std::size_t h = 0; h < std::min(horizons.size(), noise.size()); ++h)
    if (std::abs(horizons[h] - horizon_s) < 1e-6) return noise[h];
  return std::numeric_limits<double>::quiet_NaN();
}

double value_at(const std::vector<double>& values, std::size_t k) { return k < values.size() ? values[k] : unknown; }

// Samples from the recorded state that a prediction starts from to the last that it predicts.
struct Flown {
  std::size_t begin = 0, end = 0;
};

// The prediction in which the lines are farthest apart: where the nearest two of them are farthest from each other, in the plane; the
// first of equals. What was found may change nothing here: two lines are then one.
Flown farthest_apart(const DiagnosisFigures::Trace& x, const DiagnosisFigures::Trace& y) {
  using Values = std::vector<double> DiagnosisFigures::Trace::*;
  constexpr Values measured = &DiagnosisFigures::Trace::measured, before = &DiagnosisFigures::Trace::before,
                   after = &DiagnosisFigures::Trace::after;
  const auto between = [&](std::size_t k, Values one, Values other) {
    return std::hypot(value_at(x.*one, k) - value_at(x.*other, k), value_at(y.*one, k) - value_at(y.*other, k));
  };
  bool two_models = false;
  for (std::size_t k = 0; k < x.after.size(); ++k) two_models = two_models || between(k, before, after) > 0.0;
  const auto apart = [&](std::size_t k) {
    const double first = between(k, measured, before);
    return two_models ? std::min({first, between(k, measured, after), between(k, before, after)}) : first;
  };
  const auto predicted = [&](std::size_t k) { return std::isfinite(value_at(x.before, k)); };
  Flown best{0, x.time_s.size()};
  double most = 0.0;
  for (std::size_t begin = 0, k = 0; k < x.time_s.size(); ++k) {
    if (!predicted(k)) begin = k;
    if (!(apart(k) > most)) continue;
    most = apart(k);
    best = {begin, k + 1};
    while (best.end < x.time_s.size() && predicted(best.end)) ++best.end;
  }
  return best;
}

// from above, both axes to the same scale: one prediction, which begins where the vehicle was
std::string path_chart(const DiagnosisFigures& figures) {
  const auto *x = trace_of(figures, "position x"), *y = trace_of(figures, "position y");
  if (!x || !y || x->time_s.empty()) return "";
  const Flown flown = farthest_apart(*x, *y);
  const auto line = [&](const char* style, std::vector<double> DiagnosisFigures::Trace::*values) {
    svg::Series series{style, svg::Mark::line, {}, {}, {}, {}};
    for (std::size_t k = flown.begin; k < flown.end; ++k)
      for (const auto& [trace, to] : {std::pair{x, &series.x}, {y, &series.y}}) {
        const double value = value_at(trace->*values, k);
        const bool starts = k == flown.begin && !(trace->*values).empty() && !std::isfinite(value);
        to->push_back(starts ? trace->measured[k] : value);
      }
    return series;
  };
  svg::Chart chart;
  chart.title = fmt::format("Path from above, {:.1f} to {:.1f} s", x->time_s[flown.begin], x->time_s[flown.end - 1]);
  chart.x_label = "x [m]";
  chart.y_label = "y [m]";
  chart.equal_scales = true;
  chart.series = {line("measured", &DiagnosisFigures::Trace::measured),
                  line("before", &DiagnosisFigures::Trace::before), line("after", &DiagnosisFigures::Trace::after)};
  return svg::draw(chart);
}

// length of what the predictions are wrong by
std::vector<double> distance(const std::vector<const DiagnosisFigures::Trace*>& parts,
                             std::vector<double> DiagnosisFigures::Trace::*predicted) {
  if ((parts.front()->*predicted).empty()) return {};
  std::vector<double> sum(parts.front()->time_s.size(), 0.0);
  for (const DiagnosisFigures::Trace* trace : parts)
    for (std::size_t k = 0; k < std::min(sum.size(), (trace->*predicted).size()); ++k) {
      double error = (trace->*predicted)[k] - trace->measured[k];
      if (trace->unit == "rad") error = std::remainder(error, 2.0 * std::numbers::pi);
      sum[k] += error * error;
    }
  for (double& value : sum) value = std::sqrt(value);
  return sum;
}

// a vehicle that turns over goes from half a turn to minus half a turn: no line is drawn between the two
std::vector<double> broken_at_half_turns(std::vector<double> angles_rad) {
  double last = std::numeric_limits<double>::quiet_NaN();
  for (double& angle : angles_rad) {
    const double here = angle;
    if (std::abs(here - last) > std::numbers::pi) angle = std::numeric_limits<double>::quiet_NaN();
    last = here;
  }
  return angles_rad;
}

std::string error_chart(const DiagnosisFigures& figures, const char* title, const std::vector<std::string_view>& names,
                        double noise) {
  std::vector<const DiagnosisFigures::Trace*> parts;
  for (const std::string_view name : names)
    if (const auto* trace = trace_of(figures, name)) parts.push_back(trace);
  if (parts.size() != names.size()) return "";
  const std::vector<double> before = distance(parts, &DiagnosisFigures::Trace::before),
                            after = distance(parts, &DiagnosisFigures::Trace::after);
  const Display display = display_of("", parts.front()->unit, std::max(largest(before), largest(after)));
  const std::vector<double>& time_s = parts.front()->time_s;
  svg::Chart chart;
  chart.title = title;
  chart.x_label = "time [s]";
  chart.y_label = display.unit;
  chart.zero_y = true;
  if (std::isfinite(noise) && !time_s.empty())
    chart.series.push_back({"noise",
                            svg::Mark::line,
                            {time_s.front(), time_s.back()},
                            {display.factor * noise, display.factor * noise},
                            {},
                            {}});
  chart.series.push_back({"before", svg::Mark::line, time_s, scaled(before, display.factor), {}, {}});
  chart.series.push_back({"after", svg::Mark::line, time_s, scaled(after, display.factor), {}, {}});
  return svg::draw(chart);
}

std::string motor_chart(const DiagnosisFigures& figures) {
  svg::Chart chart;
  const auto& motors = figures.window.motors;
  chart.title = (motors.size() == 1 ? capital(motors.front().name) : "Motors") + ", as recorded (means of 0.1 s)";
  chart.x_label = "time [s]";
  chart.y_label = figures.window.motor_unit;
  for (std::size_t i = 0; i < motors.size(); ++i)
    chart.series.push_back({series_style(i), svg::Mark::line, motors[i].time_s, motors[i].measured, {}, {}});
  const std::string drawn = svg::draw(chart);
  if (drawn.empty()) return "";
  std::vector<std::pair<std::string, std::string>> entries;
  for (std::size_t i = 0; i < motors.size(); ++i) entries.emplace_back(series_style(i), motors[i].name);
  return "<div>" + drawn + legend(entries) + "</div>";
}

}  // namespace

std::string window_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& all) {
  DiagnosisFigures figures = all;
  // the same line twice would hide the first
  if (after_label(diagnosis).empty())
    for (DiagnosisFigures::Trace& trace : figures.window.traces) trace.after.clear();
  const double restart_s = figures.window.restart_s;
  std::string charts = path_chart(figures);
  charts += error_chart(figures, "Position: how far off", {"position x", "position y", "position z"},
                        noise_at(diagnosis, "position_m", restart_s));
  for (const DiagnosisFigures::Trace& trace : figures.window.traces) {
    if (trace.name != "roll" && trace.name != "pitch") continue;
    const Display display = display_of("", trace.unit, std::max(largest(trace.measured), 0.1));
    svg::Chart chart;
    chart.title = capital(trace.name);
    chart.y_label = display.unit;
    chart.x_label = "time [s]";
    chart.series.push_back({"measured",
                            svg::Mark::line,
                            trace.time_s,
                            scaled(broken_at_half_turns(trace.measured), display.factor),
                            {},
                            {}});
    chart.series.push_back(
        {"before", svg::Mark::line, trace.time_s, scaled(broken_at_half_turns(trace.before), display.factor), {}, {}});
    chart.series.push_back(
        {"after", svg::Mark::line, trace.time_s, scaled(broken_at_half_turns(trace.after), display.factor), {}, {}});
    charts += svg::draw(chart);
  }
  if (torque_is_told(diagnosis))
    charts += error_chart(figures, "Roll and pitch: how far off", {"roll", "pitch"},
                          noise_at(diagnosis, "attitude_rad", restart_s));
  charts += motor_chart(figures);
  if (charts.empty()) return "";
  std::size_t samples = 0;
  for (const DiagnosisFigures::Trace& trace : figures.window.traces) samples = std::max(samples, trace.time_s.size());
  std::string caption =
      fmt::format("N = {1} samples of {0}, held out; none left out.", escape(figures.window.file), samples);
  if (restart_s > 0.0)
    caption += fmt::format(
        " Predictions start anew from the recorded state every {:g} s; the noise floor is that of predictions so far "
        "ahead.",
        restart_s);
  if (trace_of(figures, "position x"))
    caption += " The path from above is one prediction, that in which the lines are farthest apart.";
  if (!torque_is_told(diagnosis))
    caption += " These logs do not tell fast torques, so predictions follow the recorded attitude.";
  return "<section><h2>Before and after, over a stretch of flight</h2><figure>" +
         legend(with_after(diagnosis,
                           {{"measured", "flown"}, {"before", "simulation as it was"}, {"noise", "noise floor"}})) +
         "<div class=\"charts\">" + charts + "</div><figcaption>" + caption + "</figcaption></figure></section>";
}

}  // namespace gustlab::report
