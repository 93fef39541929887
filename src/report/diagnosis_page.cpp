#include "report/diagnosis_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "report/diagnosis_candidates.hpp"
#include "report/diagnosis_charts.hpp"
#include "report/diagnosis_words.hpp"
#include "report/page_parts.hpp"
#include "report/svg.hpp"
#include "report/trade_words.hpp"

namespace gustlab {

namespace {

using namespace report;
using svg::escape;

constexpr double two_sided_95 = 1.959963984540054;  // normal quantile of 0.975

std::string verdict_badge(const std::string& verdict) {
  const std::string style = verdict.substr(0, verdict.find('_'));
  return fmt::format("<span class=\"badge {}\">{}</span>", escape(style), escape(plain_label(verdict)));
}

// as a sentence ends; a question has its mark
std::string ended(const std::string& words) {
  return words.ends_with('?') || words.ends_with('.') ? words : words + ".";
}

// every finding in a line, with its certainty and what a pilot would notice of it
std::string headlines(const Json& diagnosis) {
  std::string items;
  for (const Json& effect : in_order_of_weight(diagnosis)) {
    const std::vector<std::string> alike = alike_in_words(effect);
    std::string same = alike.empty() ? "" : " These flights cannot tell it from " + list_in_words(alike, "or") + ".";
    if (const std::string ground = told_on_the_ground(effect); !ground.empty()) same += " " + ground;
    items += fmt::format("<li><strong>{}</strong> <span class=\"sure\">{}</span>{}</li>",
                         escape(headline_of(effect, diagnosis)), sure(number(effect, "confidence")),
                         paragraph(notice_of(effect) + same, "notice"));
  }
  return items.empty() ? "" : "<ol class=\"headlines\">" + items + "</ol>";
}

// names that were found and taken back for one reason, and what is more likely than not
std::string suspected(const Json& diagnosis) {
  std::vector<std::string> names;
  std::string why;
  for (const Json& entry : part(diagnosis, "rejected"))
    if (const std::string reason = taken_back_because(entry); !reason.empty())
      names.push_back(plain_name(entry)), why = reason;
  std::string words =
      names.empty() ? ""
                    : paragraph(fmt::format("Suspected, and not named because {}: {}.", why, list_in_words(names)));
  std::vector<std::string> likely;
  for (const Json& effect : part(diagnosis, "suspected"))
    likely.push_back(uncapital(headline_of(effect, diagnosis)) + " (" + sure(number(effect, "confidence")) + ")");
  if (likely.empty()) return words;
  std::string against;
  for (const Json& effect : part(diagnosis, "suspected"))
    for (const Json& record : part(diagnosis, "evidence"))
      if (const std::string weak = weak_points_of(record); same_candidate(record, effect) && !weak.empty())
        against += fmt::format(" What speaks against {}: {}.", plain_name(effect), weak);
  return words + paragraph("More likely than not, and not proved: " + list_in_words(likely) + "." + against);
}

std::string header(const Json& diagnosis) {
  std::size_t fit = 0, held_out = 0, reference = 0;
  double seconds = 0.0;
  for (const Json& flight : part(diagnosis, "flights")) {
    const std::string role = text(flight, "role");
    if (role == "set_aside") continue;
    ++(role == "holdout" ? held_out : role == "reference" ? reference : fit);
    if (const double duration = number(flight, "duration_s"); std::isfinite(duration)) seconds += duration;
  }
  const std::string normal = reference == 0 ? "" : fmt::format("{} for reference, ", reference);
  std::string uses = fmt::format("{} flight{} to find, {}{} to check", fit, fit == 1 ? "" : "s", normal,
                                 held_out == 0 ? "none" : std::to_string(held_out));
  if (one_flight_is_cut(diagnosis))
    uses = "1 flight, its first two thirds to find and its last third to check" +
           (reference == 0 ? "" : fmt::format(", {} for reference", reference));
  return fmt::format("<header><p class=\"kind\">Diagnosis of {} · {}, {:.0f} s in all</p><h1>{}</h1>{}{}{}{}</header>",
                     escape(text(diagnosis, "vehicle")), uses, seconds, escape(one_sentence(diagnosis)),
                     verdict_badge(text(diagnosis, "verdict")), paragraph(gain_sentence(diagnosis), "lead"),
                     headlines(diagnosis), suspected(diagnosis));
}

std::string log_findings(const Json& diagnosis) {
  std::string items;
  for (const Json& line : part(diagnosis, "log_findings_in_short"))
    items += fmt::format("<li><strong>{}</strong>: {}</li>", escape(capital(plain_label(text(line, "kind")))),
                         escape(ended(in_plain_words(text(line, "says")))));
  return items.empty() ? "" : "<div class=\"findings\"><h2>About the recordings</h2><ul>" + items + "</ul></div>";
}

std::string region(const Json& where) {
  const Variable variable = plain_variable(text(where, "variable"));
  const bool above = where.contains("above");
  const double limit = number(where, above ? "above" : "below"), share = number(where, "share");
  std::string words = variable.name;
  if (std::isfinite(limit))
    words += fmt::format(" {} {} {}", above ? "above" : "below", short_figure(limit), variable.unit);
  if (std::isfinite(share)) words += fmt::format(" ({:.0f} % of it)", 100.0 * share);
  return words;
}

// what a channel shows, in words that its own numbers bear out: nothing, too little to matter, or where
std::string shows(const Json& entry, bool acted_on) {
  const double above = number(entry, "rms") / number(entry, "noise_rms") - 1.0;
  if (entry.value("significant", false)) {
    std::vector<std::string> regions;
    for (const Json& item : part(entry, "where")) regions.push_back(region(item));
    return regions.empty() ? "everywhere" : escape(list_in_words(regions));
  }
  // the size of a lag or a delay stands beside the least that is reported
  if (text(entry, "unit") == "s" && !acted_on && above > 0.0)
    return "<span class=\"soft\">it would explain too little to be sure of it</span>";
  // many samples prove a pattern that is far below what matters
  const bool pattern = number(entry, "p_value") < 1e-3;
  const char* words =
      !pattern ? (above < 0.5 ? "no more than noise and air" : "more than noise and air, in no pattern that is sure")
      : above < 0.5 ? "a pattern, too small to matter"
      : acted_on    ? "more than noise and air: what was found acts here"
                    : "more than noise and air, and still too small to matter";
  return fmt::format("<span class=\"soft\">{}</span>", words);
}

// "1.12 ×": how many times noise and air; a dash where that is not known
std::string times_noise(double above) {
  if (!std::isfinite(above)) return "–";
  return above < 9.0 ? fmt::format("{:.2f} ×", 1.0 + above) : fmt::format("{:.0f} ×", 1.0 + above);
}

// an effect between command and rotor was named, or a delay in the recording: what such a channel shows is no trifle
bool something_acts_on(const Json& diagnosis, const Json& channel) {
  const Json &effects = part(diagnosis, "effects"), &shown = part(channel, "effects");
  return std::any_of(effects.begin(), effects.end(), [&](const Json& effect) {
    return text(effect, "place") == text(channel, "channel") ||
           std::find(shown.begin(), shown.end(), text(effect, "effect")) != shown.end();
  });
}

// why the size of a channel says nothing, empty where it does
std::string no_size(const Json& diagnosis, const Json& channel) {
  if (text(channel, "channel").starts_with("torque") && !torque_is_told(diagnosis))
    return "not judged, as these logs do not tell fast torques";
  // of what would show there, nothing can be told, or nothing that another name does not do as well
  std::vector<std::string> names, instead;
  for (const Json& effect : part(channel, "effects")) {
    if (!effect.is_string()) continue;
    const std::string key = effect.get<std::string>(), name = plain_label(key);
    if (lists(part(diagnosis, "effects"), key)) return name + " acts here, and its size stands above";
    const std::string named = named_instead_of(diagnosis, {{"effect", effect}});
    if (named.empty() && !lists(part(diagnosis, "not_identifiable"), key)) return "";
    names.push_back(name);
    if (!named.empty() && std::find(instead.begin(), instead.end(), named) == instead.end()) instead.push_back(named);
  }
  if (names.empty()) return "";
  const std::string all = "not judged, as " + list_in_words(names);
  if (!instead.empty()) return all + " cannot be told from " + list_in_words(instead) + " in these flights";
  return all + (names.size() > 1 ? " are" : " is") + " not identifiable in these flights";
}

std::string where(const Json& diagnosis) {
  const Json& mismatch = part(diagnosis, "mismatch");
  if (mismatch.empty()) return "";
  double full = 1.0;
  for (const Json& entry : mismatch)
    if (const double ratio = number(entry, "rms") / number(entry, "noise_rms");
        std::isfinite(ratio) && no_size(diagnosis, entry).empty())
      full = std::max(full, ratio);
  std::string rows;
  bool times = false;  // among them
  // channels without a size, by what is said of them
  std::vector<std::pair<std::string, std::vector<std::string>>> no_rows;
  for (const Json& entry : mismatch) {
    const std::string name = plain_channel(text(entry, "channel")), unjudged = no_size(diagnosis, entry);
    // many samples may prove a pattern that its size does not show
    const std::string says = unjudged.empty() && !above_noise(entry) ? "no larger than noise and air" : unjudged;
    if (!says.empty()) {
      const auto same =
          std::find_if(no_rows.begin(), no_rows.end(), [&](const auto& one) { return one.first == says; });
      (same == no_rows.end() ? no_rows.emplace_back(says, std::vector<std::string>{}) : *same).second.push_back(name);
      continue;
    }
    const double rms = number(entry, "rms"), noise = number(entry, "noise_rms");
    times = times || text(entry, "unit") == "s";
    const Display display = display_of("", text(entry, "unit"), rms);
    const auto size = [&](double value) { return figure(display.factor * value) + " " + display.unit; };
    rows += fmt::format(
        "<tr><td class=\"name\">{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"where\">{}</td></tr>",
        escape(name), svg::bar(rms / noise, 1.0, full), escape(size(rms)), escape(size(noise)),
        times_noise(rms / noise - 1.0), shows(entry, something_acts_on(diagnosis, entry)));
  }
  const char* from = !hover_alone(diagnosis)
                         ? "between simulation and recording, channel by channel, before anything was added"
                     : has_reference(diagnosis) ? "from the reference flights, in hover, channel by channel"
                                                : "from the flights taken as normal, in hover, channel by channel";
  const char* left = hover_alone(diagnosis)
                         ? ""
                         : " Noise and air: what is left of it when all that was found is taken out, whatever it is.";
  const char* tick = rows.empty() ? ""
                     : times      ? " The tick is noise and air alone; of times, the least that is reported."
                                  : " The tick is noise and air alone.";
  std::string html = fmt::format("<p>The difference {}.{}{}</p>", from, left, tick);
  if (!rows.empty())
    html += card_table(
        {{"channel"}, {"size"}, {"rms", true}, {"noise and air", true}, {"rms over that", true}, {"where"}}, rows);
  for (const auto& [says, names] : no_rows) html += paragraph(capital(list_in_words(names)) + ": " + says + ".");
  return html;
}

std::string parameter_row(const std::string& effect, const std::string& name, const Json& entry,
                          const std::string& flight) {
  const double value = number(entry, "value"), half = two_sided_95 * number(entry, "std");
  const Display display = display_of(name, text(entry, "unit"), std::abs(value));
  return fmt::format(
      "<tr><td class=\"name\">{}</td>{}<td class=\"n\">{}</td><td>{}</td></tr>",
      escape(parameter_in_words(effect, name)), flight.empty() ? "" : fmt::format("<td>{}</td>", escape(flight)),
      // a number that nothing was said of stands at zero
      value == 0.0 && half > 0.0 ? "not told" : with_half_width(display.factor * value, display.factor * half),
      escape(display.unit));
}

std::string parameters(const Json& effect) {
  std::string rows, flight_rows;
  const std::string of = text(effect, "effect");
  const Json& per_flight = part(effect, "per_flight");
  for (const auto& [name, entry] : part(effect, "parameters").items())
    if (name != "rotor") rows += parameter_row(of, name, entry, "");
  for (const auto& [flight, values] : per_flight.items())
    for (const auto& [name, entry] : values.items()) flight_rows += parameter_row(of, name, entry, flight);
  const char* head = per_flight.empty() ? "value ± 95 %" : "mean of the flights ± 95 %";
  const std::string table = rows.empty() ? "" : card_table({{"parameter"}, {head, true}, {"unit"}}, rows);
  if (flight_rows.empty()) return table;
  return table + "<details><summary>Each flight</summary>" +
         card_table({{"parameter"}, {"flight"}, {"value ± 95 %", true}, {"unit"}}, flight_rows) + "</details>";
}

// every name that the data cannot tell from this one, itself first
std::vector<std::string> class_of(const Json& effect) {
  std::vector<std::string> names = alike_in_words(effect);
  names.insert(names.begin(), plain_name(effect));
  return names;
}

std::string rivals(const Json& effect) {
  const std::vector<std::string> alike = alike_in_words(effect);
  std::vector<std::string> ruled_out;
  for (const Json& rival : part(effect, "confusable_with")) {
    if (rival.value("equivalent", false)) continue;
    const double z = number(rival, "z");
    const std::string name = plain_name(rival);
    // one line for the rotors of rotor_loss, with the nearest of them
    const bool said = std::any_of(ruled_out.begin(), ruled_out.end(),
                                  [&](const std::string& other) { return other.starts_with(name + " ("); });
    if (!said) ruled_out.push_back(name + (std::isfinite(z) ? fmt::format(" ({:.1f})", z) : ""));
  }
  std::string words;
  if (!alike.empty())
    words = "These flights cannot tell " + plain_name(effect) + " from " + list_in_words(alike, "or") +
            "; the numbers are those of " + plain_name(effect) + ". ";
  if (!ruled_out.empty())
    words += "Fits worse in its place, by so many standard errors: " + list_in_words(ruled_out) + ".";
  return paragraph(words, "note");
}

// what the effect is, and what its numbers count from where that is not the vehicle file
std::string meaning(const Json& effect, const Json& diagnosis) {
  const std::string says = text(effect, "says"), normal = normal_flights(effect, diagnosis);
  std::string words = says.empty() ? "" : capital(says) + ".";
  if (normal.empty()) return words;
  // its own words compare it with the model
  if (headline_of(effect, diagnosis).find(" than in ") != std::string::npos) words.clear();
  return words + (words.empty() ? "" : " ") + "The numbers are changes since " + normal + ".";
}

std::string effect_card(const Json& effect, const Json& diagnosis) {
  return fmt::format(
      "<div class=\"effect\"><div class=\"head\"><h3>{}</h3><span class=\"soft\">{} sure · {}</span></div>{}{}{}</div>",
      escape(capital(list_in_words(class_of(effect), "or"))), sure(number(effect, "confidence")),
      escape(plain_place(text(effect, "place"))), paragraph(meaning(effect, diagnosis)), parameters(effect),
      rivals(effect));
}

double three_digits(double value) {
  if (!std::isfinite(value) || value == 0.0) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 2.0);
  return unit > 1.0 ? unit * std::round(value / unit) : value;
}

std::string whole_percent(double share) {
  return fmt::format("{}{:.0f} %", share < -0.005 ? "−" : "", std::abs(100.0 * share));
}

std::string surprising_names(const Json& diagnosis) {
  std::string items;
  for (const Json& record : part(diagnosis, "evidence"))
    if (surprises(diagnosis, record))
      items += fmt::format(
          "<li><strong>{}</strong> removes {} of the error half a second ahead and has no name, "
          "because by its evidence it is {} likely: {}.</li>",
          escape(capital(plain_name(record))), whole_percent(removed_share(record)),
          sure(number(record, "probability")), escape(weak_points_of(record)));
  return items.empty() ? "" : "<ul>" + items + "</ul>";
}

// what speaks for and against every candidate, in the numbers that decided
std::string evidence_table(const Json& diagnosis) {
  std::string rows;
  for (const Json& record : part(diagnosis, "evidence")) {
    const double removed = removed_share(record);
    const auto gain = [&](const char* key) { return figure(three_digits(number(record, key))); };
    const double p = number(record, "surrogate_p");
    // its probability is that beside the effect that is named
    const std::string named = named_instead_of(diagnosis, record);
    const bool blind = lists(part(diagnosis, "not_identifiable"), text(record, "effect"));
    const std::string probability_of = !named.empty()                      ? "in place of " + named
                                       : blind                             ? "not identifiable"
                                       : was_taken_back(diagnosis, record) ? "taken back"
                                                                           : sure(number(record, "probability"));
    rows += fmt::format(
        "<tr><td class=\"name\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"n\">{} / {}</td>"
        "<td class=\"n\">{}</td></tr>",
        escape(plain_name(record)), escape(probability_of), gain("delta_chi2"), gain("robust_delta_chi2"),
        std::isfinite(p) ? probability(p) : "–", record.value("flights_for", 0), record.value("flights_against", 0),
        std::isfinite(removed) ? whole_percent(removed) : "–");
  }
  if (rows.empty()) return "";
  return "<details><summary>Evidence, one line a candidate</summary>" +
         card_table({{"effect"},
                     {"probability", true},
                     {"Δχ²", true},
                     {"robust Δχ²", true},
                     {"p, signature moved", true},
                     {"flights for / against", true},
                     {"held-out error removed, 0.5 s", true}},
                    rows) +
         paragraph(
             "Δχ²: how much the misfit of the predictions rises without it, in units of their noise. Robust: over what "
             "the same signature gains when it is moved along its flight, or what its size varies between sixths of "
             "flights, whichever is more. p: share of the moved signatures that gain as much. The last column is the "
             "better of two: position and velocity, or attitude and body rate; of a candidate that was withdrawn it is "
             "beside the names of then. From 80 % on a candidate is named (or stands under Calibration, where it is "
             "small), from 50 % on suspected.",
             "note") +
         "</details>";
}

// which names were judged beside which others, and what was withdrawn then: where a name went that an expert would have expected
std::string history(const Json& diagnosis) {
  const Json& sets = part(diagnosis, "history");
  if (sets.size() < 2) return "";
  std::string rows;
  std::size_t step = 0;
  for (const Json& set : sets) {
    ++step;
    std::vector<std::string> names, gone;
    for (const Json& name : part(set, "names"))
      names.push_back(fmt::format("{} ({})", plain_name(name), sure(number(name, "probability"))));
    for (const Json& label : part(set, "withdrawn"))
      if (label.is_string()) gone.push_back(plain_label(label.get<std::string>()));
    const std::string instead = text(set, "in_its_place");
    const std::string then =
        !gone.empty() ? list_in_words(gone) +
                            (instead.empty() ? " withdrawn" : " withdrawn for its rival " + plain_label(instead))
        : set.value("answer", false) ? "this is the answer"
        : step == sets.size()        ? "costs a name and explains no more: the answer above stays"
                                     : "all stand; what was withdrawn is looked at again";
    rows += fmt::format(
        "<tr><td class=\"n\">{}</td><td class=\"where\">{}</td><td class=\"where\">{}</td><td class=\"n\">{}</td></tr>",
        step, names.empty() ? "no name" : escape(list_in_words(names)), escape(then),
        figure(std::round(number(set, "minus_two_log_likelihood"))));
  }
  return "<details><summary>In which order names were judged</summary>" +
         card_table({{"", true}, {"judged together, with probability"}, {"then"}, {"−2 log likelihood", true}}, rows) +
         paragraph(
             "Names are fitted and judged together; the most doubtful one is withdrawn and the rest fitted anew, until "
             "all "
             "stand. Beside other names a name may be likelier or less likely. −2 log likelihood counts the noise of "
             "each "
             "set and a price for each number: smaller is likelier.",
             "note") +
         "</details>";
}

// why the rest has no name: the candidates that came nearest
std::string nearest_names(const Json& diagnosis) {
  constexpr std::size_t most = 3;
  std::vector<const Json*> near;
  for (const Json& record : part(diagnosis, "evidence"))
    if (stands_alone(diagnosis, record)) near.push_back(&record);
  if (near.empty()) return "No effect of the catalogue came near enough to be judged as its name.";
  std::stable_sort(near.begin(), near.end(),
                   [](const Json* a, const Json* b) { return number(*a, "probability") > number(*b, "probability"); });
  std::vector<std::string> names;
  std::string against;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i) {
    names.push_back(fmt::format("{} ({})", plain_name(*near[i]), sure(number(*near[i], "probability"))));
    // what surprises stands below, with its reasons
    if (const std::string weak = weak_points_of(*near[i]); !weak.empty() && !surprises(diagnosis, *near[i]))
      against += fmt::format(" What speaks against {}: {}.", plain_name(*near[i]), weak);
  }
  return "No name was sure enough for the rest, which takes 80 %. Nearest came " + list_in_words(names) + "." + against;
}

// errors with it beside those of physics, in the page's order of horizons
std::string habit_card(const Json& habit, const Json& fit) {
  const Json& horizon = part(fit, "horizon_s");
  std::string rows;
  for (const auto& [key, name, unit] : quantities)
    for (std::size_t h = 0; h < horizon.size(); ++h) {
      const auto cell = [&](const Json& list) {
        return h < list.size() && list[h].is_number() ? figure(list[h].get<double>()) : "–";
      };
      if (cell(part(part(habit, "fit"), key)) == "–") continue;
      rows += fmt::format(
          "<tr><td class=\"name\">{} [{}]</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
          "class=\"n\">{}</td></tr>",
          name, unit, fmt::format("{:g}", horizon[h].get<double>()), cell(part(part(fit, key), "hold")),
          cell(part(part(fit, key), "after")), cell(part(part(habit, "fit"), key)));
    }
  return "<div class=\"effect\"><div class=\"head\"><h3>A habit of the recorded loop, not physics</h3></div>" +
         paragraph(capital(text(habit, "says")) + ".") +
         paragraph(
             "It turns the vehicle in rollouts on its own recordings. Where a controller of gustlab flies the vehicle "
             "it is left out.") +
         card_table({{"mean error on held-out flights"},
                     {"after [s]", true},
                     {"values kept", true},
                     {"physics", true},
                     {"with the habit", true}},
                    rows) +
         "</div>";
}

std::string what(const Json& diagnosis, double weight_N) {
  std::string cards;
  for (const Json& effect : in_order_of_weight(diagnosis)) cards += effect_card(effect, diagnosis);
  const Json& model = part(diagnosis, "residual_model");
  if (!model.empty()) {
    std::string rows;
    for (const Json& term : part(model, "terms")) {
      // a term that is 1 has the unit of its channel
      std::string unit = text(term, "unit");
      if (text(term, "term") == "1") unit = unit.substr(0, unit.find(" per unit"));
      rows += fmt::format(
          "<tr><td class=\"name\">{}</td><td><code>{}</code></td><td class=\"n\">{}</td><td class=\"unit\">{}</td><td "
          "class=\"where\">{}</td></tr>",
          escape(plain_channel(text(term, "channel"))), escape(text(term, "term")), figure(number(term, "coefficient")),
          escape(unit), escape(likeness(term, weight_N)));
    }
    cards += "<div class=\"effect\"><div class=\"head\"><h3>An unnamed effect</h3></div>" +
             paragraph(
                 nearest_names(diagnosis) +
                 " This sum of a few terms describes the rest and can be flown, but it is a description and no name.") +
             paragraph(text(model, "says").empty() ? "" : capital(text(model, "says")) + ".") +
             (rows.empty()
                  ? ""
                  : card_table({{"channel"}, {"term"}, {"coefficient", true}, {"unit"}, {"what it is like"}}, rows)) +
             "</div>";
  }
  if (const Json& habit = part(diagnosis, "habit"); !habit.empty()) cards += habit_card(habit, part(diagnosis, "fit"));
  return cards + surprising_names(diagnosis) + evidence_table(diagnosis) + history(diagnosis);
}

bool anything_named(const Json& diagnosis) {
  return !part(diagnosis, "effects").empty() || !part(diagnosis, "residual_model").empty();
}

const char* what_title(const Json& diagnosis) {
  if (!anything_named(diagnosis)) return "What was looked at";
  return has_reference(diagnosis) ? "What changed since the reference flights" : "What was left out";
}

// rows of a table: what each number of an effect or a sensor is, with its interval
std::string rows_of_parameters(const std::string& effect, const std::string& of, const Json& parameters) {
  std::string rows;
  for (const auto& [name, entry] : parameters.items()) {
    if (name == "rotor") continue;
    const double value = number(entry, "value"), half = two_sided_95 * number(entry, "std");
    const Display display = display_of(name, text(entry, "unit"), std::abs(value));
    rows += fmt::format("<tr><td class=\"name\">{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>", escape(of),
                        escape(parameter_in_words(effect, name)),
                        with_half_width(display.factor * value, display.factor * half), escape(display.unit));
  }
  return rows;
}

// effects found in the reference flights: what only they show, and no change
std::string reference_effects(const Json& diagnosis) {
  std::string rows;
  for (const Json& effect : part(diagnosis, "reference_effects"))
    rows += rows_of_parameters(text(effect, "effect"), plain_name(effect), part(effect, "parameters"));
  if (rows.empty()) return "";
  return "<p>Against the vehicle file. It is taken as normal, and only what changed since is named above.</p>" +
         card_table({{"effect"}, {"parameter"}, {"value ± 95 %", true}, {"unit"}}, rows);
}

std::string calibration(const Json& diagnosis) {
  std::string rows;
  for (const Json& effect : part(diagnosis, "calibration"))
    if (!lists(part(diagnosis, "not_identifiable"), text(effect, "effect")))
      rows += rows_of_parameters(text(effect, "effect"), plain_name(effect), part(effect, "parameters"));
  for (const Json& bias : part(diagnosis, "sensor_biases"))
    rows += rows_of_parameters("", text(bias, "sensor"), part(bias, "parameters"));
  if (rows.empty()) return "";
  return "<p>Small corrections: below the reporting tolerances, or no more than what several numbers within theirs do "
         "together. "
         "The usual scatter of a build, not missing physics.</p>" +
         card_table({{"of"}, {"parameter"}, {"value ± 95 %", true}, {"unit"}}, rows);
}

std::string disturbance(const Json& diagnosis) {
  std::string rows;
  for (const Json& entry : part(diagnosis, "disturbance")) {
    // as in the table of channels
    if (!torque_is_told(diagnosis) && text(entry, "group").starts_with("torque")) continue;
    const Display time = display_of("", "s", number(entry, "correlation_time_s"));
    rows += fmt::format(
        "<tr><td class=\"name\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{} "
        "{}</td></tr>",
        escape(plain_channel(text(entry, "group"))), figure(number(entry, "before")), figure(number(entry, "after")),
        escape(display_of("", text(entry, "unit"), 1.0).unit),
        figure(time.factor * number(entry, "correlation_time_s")), time.unit);
  }
  if (rows.empty()) return "";
  return "<p>What still pushes the vehicle at random: turbulence, and whatever has no name. It comes and goes over the "
         "correlation time.</p>" +
         card_table({{"group"}, {"before", true}, {"after", true}, {"unit"}, {"correlation time", true}}, rows);
}

bool of_torques_alone(const Json& alarm) {
  const Json& channels = part(alarm, "channels");
  return !channels.empty() && std::all_of(channels.begin(), channels.end(), [](const Json& channel) {
    return channel.is_string() && channel.get<std::string>().starts_with("torque");
  });
}

// "what is left depends on position, velocity and time", in one line
void say_once(std::vector<std::pair<std::string, std::string>>& lines) {
  constexpr std::string_view begin = "what is left depends on ";
  std::vector<std::string> variables;
  std::size_t first = lines.size();
  for (std::size_t i = 0; i < lines.size();) {
    if (!lines[i].second.starts_with(begin)) {
      ++i;
      continue;
    }
    variables.push_back(lines[i].second.substr(begin.size()));
    first = std::min(first, i);
    if (variables.size() > 1) lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
    else ++i;
  }
  if (!variables.empty()) lines[first].second = std::string(begin) + list_in_words(variables);
}

// every channel of an alarm that these logs tell is no larger than noise and air
bool within_noise(const Json& diagnosis, const Json& alarm) {
  const Json& channels = part(alarm, "channels");
  const bool told = torque_is_told(diagnosis);
  bool any = false;
  for (const Json& entry : part(diagnosis, "mismatch")) {
    const std::string channel = text(entry, "channel");
    if (std::find(channels.begin(), channels.end(), channel) == channels.end()) continue;
    if (!told && channel.starts_with("torque")) continue;
    if (above_noise(entry)) return false;
    any = true;
  }
  return any;
}

// what an alarm says, as far as the sizes of its channels bear it out
std::string said_of(const Json& diagnosis, const Json& alarm) {
  const std::string says = in_plain_words(text(alarm, "says"));
  return text(alarm, "kind") == "floor" && within_noise(diagnosis, alarm)
             ? says + ": no name explains it, and it is counted as noise and air above"
             : says;
}

// alarms in words, one line for all sensors whose innovations are correlated; none of torques that the logs do not tell
std::vector<std::pair<std::string, std::string>> alarm_lines(const Json& diagnosis) {
  std::vector<std::pair<std::string, std::string>> lines;
  std::vector<std::string> sensors;
  std::size_t at = 0;
  bool faint = true;  // patterns that are no larger than noise and air
  for (const Json& alarm : part(diagnosis, "alarms")) {
    if (!torque_is_told(diagnosis) && of_torques_alone(alarm)) continue;
    const std::string sensor = text(alarm, "sensor");
    if (sensors.empty()) at = lines.size();
    if (sensor.empty() || sensors.empty()) lines.emplace_back(text(alarm, "kind"), said_of(diagnosis, alarm));
    faint = faint && (text(alarm, "kind") != "omnibus" || within_noise(diagnosis, alarm));
    if (!sensor.empty()) sensors.push_back(in_plain_words(sensor));
  }
  if (!sensors.empty())
    lines[at].second = "what the model does not predict comes in runs of several samples in " + list_in_words(sensors);
  say_once(lines);
  for (auto& [kind, says] : lines) {
    if (kind == "omnibus" && faint) says += ", and is no larger than noise and air";
    kind = plain_alarm(kind);
  }
  return lines;
}

// what says that something is left, and other remarks
std::string remarks(const Json& diagnosis) {
  std::string items;
  for (const auto& [kind, says] : alarm_lines(diagnosis))
    items += fmt::format("<li><strong>{}</strong>: {}</li>", escape(kind), escape(ended(says)));
  for (const Json& note : part(diagnosis, "notes"))
    if (note.is_string()) items += "<li>" + escape(ended(capital(in_plain_words(note.get<std::string>())))) + "</li>";
  return items.empty() ? "" : "<ul>" + items + "</ul>";
}

// what is not identifiable for one reason, in the order in which the reasons come
struct NotIdentifiableForOneReason {
  std::string why, remedy;
  std::vector<std::string> names;
};

std::vector<NotIdentifiableForOneReason> by_reason(const Json& list) {
  std::vector<NotIdentifiableForOneReason> groups;
  for (const Json& entry : list) {
    std::string why = text(entry, "why");
    const std::string shows_in = text(entry, "shows_in"), shown = diagnosis::shows_in_words(shows_in);
    // the flight that shows it has a column of its own
    if (!shows_in.empty() && why.ends_with(shown)) why.resize(why.size() - shown.size());
    why = in_plain_words(why);
    const std::string remedy = remedy_for(diagnosis::lack_named(text(entry, "lack")), in_plain_words(shows_in));
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const NotIdentifiableForOneReason& group) {
      return group.why == why && group.remedy == remedy;
    });
    (same == groups.end() ? groups.emplace_back(NotIdentifiableForOneReason{why, remedy, {}}) : *same)
        .names.push_back(plain_name(entry));
  }
  return groups;
}

// "1.3 %"; "forward 27 mm, left 27 mm" where there are several numbers, "exponent 0.17" where there is no unit
std::string would_show(const Json& rejected) {
  const std::string effect = text(rejected, "effect");
  std::vector<std::string> sizes;
  const Json& numbers = part(rejected, "would_show");
  for (const auto& [name, entry] : numbers.items()) {
    const double size = number(entry, "value");
    const Display display = display_of(name, text(entry, "unit"), size);
    const bool said = numbers.size() > 1 || display.unit.empty();
    sizes.push_back((said ? parameter_in_words(effect, name) + " " : "") + short_figure(display.factor * size) +
                    (display.unit.empty() || display.unit == "°" ? "" : " ") + display.unit);
  }
  return sizes.empty() ? "–" : fmt::format("{}", fmt::join(sizes, ", "));
}

std::string cannot_tell(const Json& diagnosis) {
  std::string html, rows;
  for (const NotIdentifiableForOneReason& group : by_reason(part(diagnosis, "not_identifiable")))
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td><td class=\"where\">{}</td></tr>", escape(list_in_words(group.names)),
                    escape(group.why), group.remedy.empty() ? "–" : escape(group.remedy));
  if (!rows.empty())
    html +=
        "<p>Not identifiable: these flights do not show enough to say anything, either way, about:</p><div "
        "class=\"scroll\"><table class=\"wrap\"><tr><th>effect</th><th>why</th><th>what would tell it</th></tr>" +
        rows + "</table></div>";
  rows.clear();
  std::vector<std::string> said;
  for (const Json& entry : part(diagnosis, "rejected")) {
    // of one that was asked several times, the most that it gained comes first
    const std::string name = plain_name(entry);
    if (std::find(said.begin(), said.end(), name) != said.end()) continue;
    said.push_back(name);
    if (!taken_back_because(entry).empty()) continue;  // stands in the header
    const std::string named = named_instead_of(diagnosis, entry);
    const Json& records = part(diagnosis, "evidence");
    const bool above = std::any_of(records.begin(), records.end(), [&](const Json& record) {
      return same_candidate(record, entry) && surprises(diagnosis, record);
    });
    const std::string why = !named.empty()
                                ? "in place of " + named + " it would fit as well; beside it little is left for it"
                            : above ? "its own evidence makes it unlikely, for the reasons above"
                                    : text(entry, "why");
    rows +=
        fmt::format("<tr><td class=\"name\">{}</td><td class=\"where\">{}</td><td>{}</td><td class=\"n\">{}</td></tr>",
                    escape(name), escape(why), named.empty() ? escape(would_show(entry)) : "–",
                    figure(number(entry, "delta_score")));
  }
  if (!rows.empty())
    html += "<details><summary>Looked at and not named</summary>" +
            card_table({{"effect"}, {"why not"}, {"would show from"}, {"score", true}}, rows) +
            paragraph(
                "Would show from: five standard errors beside what was found, and what pays for its numbers. "
                "Score: how much better the model predicts with it, less a price for each of its numbers.",
                "note") +
            "</details>";
  return html;
}

std::string next_flight(const Json& diagnosis) {
  const Json& next = part(diagnosis, "next_flight");
  const std::string trajectory = text(next, "trajectory");
  if (trajectory.empty()) return "";
  std::string how;
  for (const auto& [name, value] : part(next, "parameters").items())
    how += fmt::format("{} = {}\n", name, value.dump());
  if (!how.empty())
    how =
        "<details><summary>How</summary><pre>" + escape("[trajectory." + trajectory + "]\n" + how) + "</pre></details>";
  return fmt::format("<p><strong>{}</strong>: {}.</p>{}", escape(capital(plain_label(trajectory))),
                     escape(in_plain_words(text(next, "why"))), how);
}

std::string flights(const Json& diagnosis) {
  std::string rows;
  bool any_condition = false;
  for (const Json& flight : part(diagnosis, "flights")) {
    std::vector<std::string> conditions;
    for (const auto& [key, value] : part(flight, "condition").items()) {
      const Variable variable = plain_variable(key);
      conditions.push_back(variable.name + " " + (value.is_string() ? value.get<std::string>() : value.dump()) + " " +
                           variable.unit);
    }
    const std::string role = text(flight, "role");
    any_condition = any_condition || !conditions.empty();
    rows += fmt::format(
        "<tr><td class=\"name\">{}</td><td>{}</td><td class=\"n\">{} s</td><td class=\"n\">{} "
        "ms</td><td>{}</td></tr>",
        escape(text(flight, "file")),
        escape(role == "holdout" ? "held out"
               : role == "fit"   ? "fitted"
                                 : plain_label(role)),
        figure(number(flight, "duration_s")), figure(1e3 * number(flight, "time_offset_s")),
        escape(list_in_words(conditions)));
  }
  if (rows.empty()) return "";
  return card_table({{"file"}, {"role"}, {"duration", true}, {"time offset", true}, {any_condition ? "condition" : ""}},
                    rows);
}

std::string footer(const Json& diagnosis) {
  const std::string model = text(diagnosis, "augmented_model");
  const Json& all = part(diagnosis, "flights");
  const bool checked =
      std::any_of(all.begin(), all.end(), [](const Json& flight) { return text(flight, "role") == "holdout"; });
  std::string words = "Intervals are 95 %.";
  if (checked)
    words += fmt::format(" {} never used to choose or to fit an effect, save for what belongs to each flight alone.",
                         one_flight_is_cut(diagnosis) ? "The last third was" : "Held-out flights were");
  if (!model.empty() && !hover_alone(diagnosis) &&
      (!part(diagnosis, "effects").empty() || !part(diagnosis, "residual_model").empty()))
    return fmt::format(
        "<footer><p>{} Fly the improved model: <code>gustlab replay FLIGHT.csv --with {}</code></p></footer>", words,
        escape(model));
  return "<footer><p>" + words + "</p></footer>";
}

}  // namespace

std::string diagnosis_page(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures) {
  std::string body;
  for (const std::string& piece :
       {header(diagnosis), log_findings(diagnosis), window_section(diagnosis, figures),
        section(what_title(diagnosis), what(diagnosis, figures.weight_N)),
        section("What the reference flights show already", reference_effects(diagnosis)),
        section("Where it differs", where(diagnosis)), residual_section(diagnosis, figures),
        horizon_section(diagnosis, figures),
        section(alarm_lines(diagnosis).empty() ? "Remarks" : "Still not explained, and remarks", remarks(diagnosis)),
        section("What cannot be told", cannot_tell(diagnosis)), section("What to fly next", next_flight(diagnosis)),
        section("Unexplained disturbance", disturbance(diagnosis)), section("Calibration", calibration(diagnosis)),
        section("Flights", flights(diagnosis)), footer(diagnosis)})
    if (!piece.empty()) body += piece + "\n";
  return page("Diagnosis of " + text(diagnosis, "vehicle"), body);
}

}  // namespace gustlab
