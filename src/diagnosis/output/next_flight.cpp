#include "diagnosis/output/next_flight.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/validation/holdout.hpp"
#include "gustlab/errors.hpp"
#include "simulation/flight.hpp"
#include "simulation/recorder.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double crazyflie_arm_m = 0.046;  // the size for which the library below is written
constexpr double flight_s = 8.0;
using decisions::distinguishes, decisions::shows;

struct Candidate {
  std::string trajectory, how;  // name in the registry, and in words
  std::vector<std::pair<std::string, std::string>> parameters;
};

std::string numbers(const std::vector<double>& values) {
  std::string text;
  for (const double v : values) text += fmt::format("{}{:.3g}", text.empty() ? "[" : ", ", v);
  return text + "]";
}

// Lengths grow with the arm and speeds with its root, so that accelerations stay what they are for a Crazyflie.
std::vector<Candidate> library(const VehicleModel& vehicle, double ground_m) {
  const double size = vehicle.arm_m() / crazyflie_arm_m, pace = std::sqrt(size), radius_m = 0.8 * size;
  const std::string center = numbers({0.0, 0.0, ground_m + 1.2 * size});
  const auto circle = [&](const char* how, double speed_mps) {
    return Candidate{"circle",
                     how,
                     {{"radius_m", fmt::format("{:.3g}", radius_m)},
                      {"period_s", fmt::format("{:.3g}", 2.0 * M_PI * radius_m / (speed_mps * pace))},
                      {"center_m", center},
                      {"ramp_s", "2.0"},
                      {"start", "\"reference\""}}};
  };
  const double top = 0.9 * size;
  std::vector<double> stairs, times;
  // from three rotor radii up to free air and down again
  for (const double height : {top, 0.25 * top, 0.12 * top, 0.08 * top, 0.15 * top, 0.4 * top, top}) {
    const double at_m = ground_m + std::max(height, 3.0 * vehicle.rotor_radius_m);
    times.push_back(static_cast<double>(times.size()) * flight_s * pace / 6.0);
    stairs.insert(stairs.end(), {0.1 * size * static_cast<double>(times.size()), 0.0, at_m});
  }
  std::vector<double> x, y, z;
  for (const double f : {0.1, 0.23, 0.41, 0.73}) x.push_back(f / pace);
  for (const double f : {0.13, 0.29, 0.47, 0.79}) y.push_back(f / pace);
  for (const double f : {0.17, 0.31, 0.53, 0.89}) z.push_back(f / pace);
  return {circle("slowly", 0.5),
          circle("fast", 1.8),
          {"lemniscate",
           "back and forth",
           {{"amplitude_m", fmt::format("{:.3g}", 0.9 * size)},
            {"period_s", fmt::format("{:.3g}", 5.5 * pace)},
            {"center_m", center},
            {"ramp_s", "2.0"}}},
          {"multisine",
           "turning in yaw",
           {{"amplitude_m", numbers({0.35 * size, 0.35 * size, 0.2 * size})},
            {"frequencies_x_hz", numbers(x)},
            {"frequencies_y_hz", numbers(y)},
            {"frequencies_z_hz", numbers(z)},
            {"center_m", center},
            {"yaw_amplitude_rad", "1.2"},
            {"yaw_frequency_hz", fmt::format("{:.3g}", 0.25 / pace)}}},
          {"spiral",
           "climbing",
           {{"radius_m", fmt::format("{:.3g}", radius_m)},
            {"turns", "3"},
            {"length_s", fmt::format("{:.3g}", flight_s * pace)},
            {"climb_m", fmt::format("{:.3g}", 3.0 * size)},
            {"center_m", center},
            {"ramp_s", "2.0"}}},
          {"waypoints",
           "a staircase of heights down to the ground",
           {{"points_m", numbers(stairs)}, {"times_s", numbers(times)}}}};
}

unsigned channels_of(const FlightData& flight) {
  unsigned seen = 0;
  for (const Sample& sample : flight.samples) seen |= sample.channels;
  return seen;
}

// one flight of the library, as these sensors would have recorded it; nothing when it does not come to its end
std::optional<FlightData> simulate(const Candidate& candidate, const FlightData& like,
                                   const std::vector<EffectSpec>& effects) {
  Experiment experiment;
  experiment.name = "next";
  experiment.vehicle = like.vehicle;
  experiment.effects = effects;
  experiment.trajectories = {
      {candidate.trajectory, {candidate.trajectory, candidate.parameters, candidate.trajectory, {}}}};
  experiment.controllers = {{"geometric", {"geometric", {}, "geometric", {}}}};
  experiment.flight.duration_s = flight_s * std::sqrt(like.vehicle.arm_m() / crazyflie_arm_m);
  FlightLog log;
  try {
    // steps of 2 ms or a little less that divide the controller's period
    const double period_s = 1.0 / find_controller("geometric")->make()->rate_hz(like.vehicle);
    experiment.flight.step_s = period_s / std::ceil(period_s / 0.002 - 1e-9);
    Flight flight(experiment, RunSpec{});
    TrackingError error(0.0, static_cast<std::size_t>(flight.ticks) + 1);
    FlightRecorder recorder(experiment, flight);
    if (fly(flight, error, &recorder).outcome != Outcome::completed) return std::nullopt;
    log = recorder.take();
  } catch (const ConfigError&) {
    return std::nullopt;  // no controller for such a vehicle
  }
  const unsigned seen = channels_of(like);
  std::erase_if(log.columns, [&](const LogColumn& c) {
    const auto is = [&](std::initializer_list<std::string_view> names) {
      return std::find(names.begin(), names.end(), c.name) != names.end();
    };
    if (is({"px", "py", "pz"})) return !(seen & has_position);
    if (is({"vx", "vy", "vz"})) return !(seen & has_velocity);
    if (is({"qw", "qx", "qy", "qz"})) return !(seen & has_attitude);
    if (is({"wx", "wy", "wz"})) return !(seen & has_rate);
    if (is({"ax", "ay", "az"})) return !(seen & has_force);
    if (c.name.starts_with("rotor")) return like.measured_speed.empty();
    return c.name.size() != 2 || c.name[0] != 'u';
  });
  log.path = candidate.trajectory;
  // a battery that empties as batteries do
  if (like.has_voltage && like.vehicle.nominal_voltage_V > 0.0) {
    log.columns.push_back({"vbat", {}});
    for (const double t : log.time_s)
      log.columns.back().values.push_back(like.vehicle.nominal_voltage_V * (1.0 - 0.05 * t / log.time_s.back()));
  }
  ReadingOptions reading;
  reading.max_rate_hz = 100.0;
  FlightData data = prepare_flight(log, like.vehicle, reading);
  data.collective_only = like.collective_only;
  return data;
}

// what is left of a change `value` of some columns after `free` ones were fitted to it, squared standard deviations
double unmatched(const Eigen::MatrixXd& gram, const std::vector<int>& columns, const Eigen::VectorXd& value,
                 const std::vector<int>& free) {
  Eigen::MatrixXd with = gram;
  const Eigen::Index last = gram.cols() - 1;
  with.col(last).setZero();
  for (std::size_t i = 0; i < columns.size(); ++i)
    with.col(last) += value[static_cast<Eigen::Index>(i)] * gram.col(columns[i]);
  double square = 0.0;
  for (std::size_t i = 0; i < columns.size(); ++i)
    square += value[static_cast<Eigen::Index>(i)] * with(columns[i], last);
  with(last, last) = square;
  with.row(last).head(last) = with.col(last).head(last).transpose();
  return std::max(0.0, solve(with, free).loss);
}

// histories that a scan would have to find do not fly here, and some effects need surroundings or sensors that are not there
bool can_show(const EffectRow& row, const Catalogue& catalogue) {
  return row.column == ColumnFrom::model && !catalogue.why_left_out(row);
}

struct Pair {
  std::string named, other;
  int group, rival;
};

std::vector<int> join(std::vector<int> a, const std::vector<int>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::string in_words(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return names.size() > most ? text + fmt::format(" and {} more", names.size() - most) : text;
}

// the library, flown with what was found: those of its flights that a controller can fly
struct FlownLibrary {
  std::vector<FlightData> flights;
  std::vector<Candidate> of;
};

FlownLibrary fly_library(const Session& session, const Diagnosis& out, int jobs) {
  const FlightData& like = session.flights().front();
  config::Table found = config::Table::parse(augmented_toml(out), "augmented.toml");
  std::vector<EffectSpec> effects = config::merge_effects(like.vehicle.effects, config::read_effects(found));
  std::erase_if(effects, [](const EffectSpec& e) { return find_effect(e.type)->external; });
  const std::vector<Candidate> candidates =
      library(session.vehicle(), like.vehicle.environment.ground_z_m.value_or(0.0));
  std::vector<std::optional<FlightData>> flown(candidates.size());
  parallel_for(static_cast<std::int64_t>(candidates.size()), jobs, [&](std::int64_t i) {
    flown[static_cast<std::size_t>(i)] = simulate(candidates[static_cast<std::size_t>(i)], like, effects);
  });
  FlownLibrary result;
  for (std::size_t i = 0; i < flown.size(); ++i)
    if (flown[i]) {
      result.flights.push_back(std::move(*flown[i]));
      result.of.push_back(candidates[i]);
    }
  return result;
}

// what a flight should show, as groups of the library's catalogue: pairs of names, and effects that have not shown
struct Questions {
  std::vector<int> chosen;  // what was found
  std::vector<Pair> pairs;
  std::vector<std::pair<std::string, int>> hidden;
};

Questions questions_of(const Catalogue& here, const Catalogue& there, const Selection& selection, const Diagnosis& out,
                       const std::vector<std::string>& unseen) {
  const auto groups_there = [&](std::string_view name) {
    std::vector<int> groups;
    for (std::size_t g = 0; g < there.groups().size(); ++g)
      if (there.groups()[g].row->name == name && there.groups()[g].candidate) groups.push_back(static_cast<int>(g));
    return groups;
  };
  Questions asked;
  for (const Finding& finding : selection.findings) {
    const Group& group = here.group(finding.group);
    const int g = there.find(group.label);
    if (g < 0) continue;
    asked.chosen.push_back(g);
    const auto named = std::find_if(out.effects.begin(), out.effects.end(), [&](const EffectFinding& e) {
      return std::find(e.classmates.begin(), e.classmates.end(), group.row->name) != e.classmates.end();
    });
    if (named == out.effects.end()) continue;
    for (const std::string& other : named->classmates)
      if (other != group.row->name)
        for (const int rival : groups_there(other))
          asked.pairs.push_back({std::string(group.row->name), other, g, rival});
  }
  for (const std::string& name : unseen)
    for (const int g : groups_there(name)) asked.hidden.emplace_back(name, g);
  std::erase_if(asked.pairs, [&](const Pair& p) {
    return !can_show(*find_effect(p.named), here) || !can_show(*find_effect(p.other), here);
  });
  return asked;
}

std::vector<int> columns_asked(const Questions& asked, const Session& next) {
  const Catalogue& there = next.catalogue();
  std::vector<int> wanted = join(columns_of(there, asked.chosen), next.biases());
  for (const Pair& p : asked.pairs) wanted = join(wanted, columns_of(there, {p.rival}));
  for (const auto& [name, g] : asked.hidden) wanted = join(wanted, columns_of(there, {g}));
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  return wanted;
}

// what one flight would show: more names distinguished first, then distinguished more clearly, then more that shows at all
struct Worth {
  double score = 0.0;
  std::vector<std::string> apart, seen;
};

Worth worth_of(const Eigen::MatrixXd& gram, const Questions& asked, const Session& next, const Eigen::VectorXd& value) {
  const Catalogue& there = next.catalogue();
  Worth worth;
  for (const Pair& p : asked.pairs) {
    std::vector<int> others = asked.chosen;
    std::erase(others, p.group);
    if (std::find(others.begin(), others.end(), p.rival) == others.end()) others.push_back(p.rival);
    const std::vector<int> own = columns_of(there, {p.group});
    Eigen::VectorXd size(static_cast<Eigen::Index>(own.size()));
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Column& column = there.column(own[i]);
      size[static_cast<Eigen::Index>(i)] = (value[own[i]] - column.nominal) / column.natural;
    }
    const double worse = unmatched(gram, own, size, join(columns_of(there, others), next.biases()));
    if (worse < distinguishes) continue;
    worth.score += 1e3 + 1e2 * std::log(worse);
    const std::string words = p.named + " from " + p.other;
    if (std::find(worth.apart.begin(), worth.apart.end(), words) == worth.apart.end()) worth.apart.push_back(words);
  }
  for (const auto& [name, g] : asked.hidden) {
    double most = 0.0;
    for (const int c : columns_of(there, {g})) {
      std::vector<int> free = join(columns_of(there, asked.chosen), next.biases());
      std::erase(free, c);
      most = std::max(most, unmatched(gram, {c}, Eigen::VectorXd::Ones(1), free));
    }
    if (most < shows) continue;
    worth.score += 1.0 + 0.01 * std::log(most);
    if (std::find(worth.seen.begin(), worth.seen.end(), name) == worth.seen.end()) worth.seen.push_back(name);
  }
  return worth;
}

std::string reason(const Worth& worth, const std::string& how) {
  std::string why = worth.apart.empty() ? "" : "would separate " + in_words(worth.apart, 3);
  if (!worth.seen.empty()) why += (worth.apart.empty() ? "would show " : ", and show ") + in_words(worth.seen, 4);
  return why + fmt::format(" (flown {})", how);
}

}  // namespace

void suggest_flight(const Session& session, const Selection& selection, int jobs, Diagnosis& out) {
  const bool ambiguous = std::any_of(out.effects.begin(), out.effects.end(),
                                     [](const EffectFinding& e) { return e.classmates.size() > 1; });
  std::vector<std::string> unseen;
  for (const NotIdentifiable& n : out.not_identifiable)
    if (can_show(*find_effect(n.effect), session.catalogue())) unseen.push_back(n.effect);
  if (!ambiguous && unseen.empty()) return;
  FlownLibrary flown = fly_library(session, out, jobs);
  if (flown.flights.empty()) return;

  Session next(std::move(flown.flights), session.vehicle(), jobs);
  next.noise = selection.noise_selected;
  const Questions asked = questions_of(session.catalogue(), next.catalogue(), selection, out, unseen);
  if (asked.pairs.empty() && asked.hidden.empty()) return;
  const Eigen::VectorXd value = carry_over(session.catalogue(), selection.value, next.catalogue());
  next.linearise(value, columns_asked(asked, next));
  const Grams grams = next.grams();

  double best = 0.0;
  for (std::size_t f = 0; f < flown.of.size(); ++f) {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(grams.columns + 1, grams.columns + 1);
    for (std::size_t b = 0; b < grams.block.size(); ++b)
      if (grams.flight[b] == static_cast<int>(f)) gram += grams.block[b];
    const Worth worth = worth_of(gram, asked, next, value);
    if (worth.score <= best) continue;
    best = worth.score;
    out.next_trajectory = flown.of[f].trajectory;
    out.next_parameters = flown.of[f].parameters;
    out.next_why = reason(worth, flown.of[f].how);
  }
}

}  // namespace gustlab::diagnosis
