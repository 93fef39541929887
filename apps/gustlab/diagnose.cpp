#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "diagnose.hpp"
#include "diagnosis/recording/recordings.hpp"
#include "diagnosis/recording/stretches.hpp"
#include "diagnosis/result/finding_lines.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "report/diagnosis_lines.hpp"
#include "report/diagnosis_page.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"
#include "util/quantiles.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

struct DiagnoseArguments {
  std::vector<std::string> flights, holdout, reference;
  std::string vehicle, out, batch;
  int jobs = default_jobs();
};

constexpr const char* key_file = "key.txt";  // of a batch
constexpr const char* outputs[] = {"diagnosis.json", "augmented.toml", "report.html", key_file};

// an existing folder is replaced only when it holds a former diagnosis and nothing else
void check_out(const std::filesystem::path& out) {
  if (!std::filesystem::exists(out)) return;
  for (const auto& entry : std::filesystem::directory_iterator(out))
    if (std::find(std::begin(outputs), std::end(outputs), entry.path().filename().string()) == std::end(outputs))
      throw ConfigError(fmt::format("{}: holds {} (only a former diagnosis is replaced); name another folder",
                                    out.string(), entry.path().filename().string()));
}

// means of a residual and their 95 % intervals in ten bins of equal count
void bin(const std::vector<double>& x, const std::vector<double>& y, std::vector<double>* middle,
         std::vector<double>& mean, std::vector<double>& low, std::vector<double>& high) {
  const std::vector<std::size_t> order = ascending(x);
  const std::size_t bins = std::min<std::size_t>(10, order.size() / 5);
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t first = b * order.size() / bins, last = (b + 1) * order.size() / bins;
    double sx = 0.0, sy = 0.0, syy = 0.0;
    const double n = static_cast<double>(last - first);
    for (std::size_t i = first; i < last; ++i) {
      sx += x[order[i]] / n;
      sy += y[order[i]] / n;
      syy += y[order[i]] * y[order[i]] / n;
    }
    const double half = 1.96 * std::sqrt(std::max(0.0, syy - sy * sy) / n);
    if (middle) middle->push_back(sx);
    mean.push_back(sy);
    low.push_back(sy - half);
    high.push_back(sy + half);
  }
}

// what the motors were told over the window, from the log itself
void add_motors(const FlightLog& log, DiagnosisFigures::Window& window) {
  constexpr double bin_s = 0.1;  // a command jitters from tick to tick; what lasts is what is seen in flight
  if (window.traces.empty() || window.traces.front().time_s.empty()) return;
  const std::vector<double>& shown = window.traces.front().time_s;
  const auto row_at = [&](double time_s) {
    return static_cast<std::size_t>(std::lower_bound(log.time_s.begin(), log.time_s.end(), time_s) -
                                    log.time_s.begin());
  };
  const std::size_t first = row_at(shown.front()), last = std::min(row_at(shown.back()) + 1, log.rows());
  const auto bin_of = [&](std::size_t row) { return std::floor((log.time_s[row] - shown.front()) / bin_s); };
  const bool speeds = log.count("u") == 0;
  const bool total = !speeds && log.meta.actuator == ActuatorKind::collective_thrust;
  const char* prefix = speeds ? "rotor" : "u";
  for (int i = 1; i <= log.count(prefix); ++i) {
    const std::vector<double>& values = *log.find(fmt::format("{}{}", prefix, i));
    DiagnosisFigures::Trace motor;
    motor.name = total ? "total thrust" : fmt::format("rotor {}", i);
    double sum_time_s = 0.0, sum = 0.0, n = 0.0;
    for (std::size_t row = first; row < last; ++row) {
      if (std::isfinite(values[row])) sum_time_s += log.time_s[row], sum += values[row], ++n;
      const bool bin_ends = row + 1 == last || bin_of(row + 1) > bin_of(row);
      if (!bin_ends || n == 0.0) continue;
      motor.time_s.push_back(sum_time_s / n);
      motor.measured.push_back(sum / n);
      sum_time_s = sum = n = 0.0;
    }
    window.motors.push_back(std::move(motor));
  }
  const ActuatorKind kind = log.meta.actuator;
  const bool newtons = kind == ActuatorKind::thrust || kind == ActuatorKind::collective_thrust;
  window.motor_unit = speeds || kind == ActuatorKind::rotor_speed ? "rad/s"
                      : newtons                                   ? "N"
                                                                  : std::string(to_string(kind));
}

// what only the recordings know: motors over the window, and the vehicle's weight
void add_recorded(const diagnosis::DiagnoseOptions& wanted, DiagnosisFigures& figures) {
  std::string path = wanted.fit.back();
  for (const auto* paths : {&wanted.fit, &wanted.holdout})
    for (const std::string& one : *paths)
      if (diagnosis::is_flight_of(figures.window.file, diagnosis::label_of(one))) path = one;
  try {
    const std::vector<FlightLog> flights = diagnosis::read_flights(path);
    const auto shown = std::find_if(flights.begin(), flights.end(), [&](const FlightLog& flight) {
      return diagnosis::label_of(flight.path) == figures.window.file;
    });
    const FlightLog& log = shown == flights.end() ? flights.front() : *shown;
    figures.weight_N =
        (wanted.vehicle ? read_vehicle(*wanted.vehicle) : read_vehicle(log.meta.vehicle, sidecar_path(path)))
            .weight_N();
    if (!figures.window.file.empty()) add_motors(log, figures.window);
  } catch (const UserError&) {
    // the diagnosis has said what is wrong with this flight; the page goes without
  }
}

DiagnosisFigures figures_of(const diagnosis::Diagnosis& result, const diagnosis::DiagnoseOptions& wanted) {
  DiagnosisFigures figures;
  figures.window.file = result.window_file;
  figures.window.restart_s = 0.5;
  for (const diagnosis::WindowTrace& t : result.window)
    figures.window.traces.push_back({t.name, t.unit, t.time_s, t.measured, t.before, t.after});
  for (const diagnosis::ResidualPlot& plot : result.residuals) {
    DiagnosisFigures::Residual r;
    r.channel = plot.channel;
    r.unit = plot.unit;
    r.variable = plot.variable;
    r.x = plot.x;
    r.y = plot.before;
    bin(plot.x, plot.before, &r.bin_x, r.before_mean, r.before_low, r.before_high);
    bin(plot.x, plot.after, nullptr, r.after_mean, r.after_low, r.after_high);
    figures.residuals.push_back(std::move(r));
  }
  add_recorded(wanted, figures);
  return figures;
}

void run(const DiagnoseArguments& options) {
  interrupted();
  if (!options.batch.empty()) {
    if (!options.flights.empty() || !options.holdout.empty() || !options.reference.empty() || !options.vehicle.empty())
      throw ConfigError("--batch: flights and vehicles are said in its file, not here (leave them out)");
    return diagnose_batch(options.batch, options.out, options.jobs);
  }
  if (options.flights.empty())
    throw ConfigError("diagnose: no flight is named (give flight logs, or --batch SETS.toml)");
  diagnosis::DiagnoseOptions wanted;
  wanted.fit = options.flights;
  wanted.holdout = options.holdout;
  wanted.reference = options.reference;
  if (!options.vehicle.empty()) wanted.vehicle = options.vehicle;
  wanted.jobs = options.jobs;
  Progress progress;
  wanted.progress = progress.report();
  const diagnosis::Diagnosis result = diagnose_into(options.out, wanted);
  progress.end();
  for (const auto& [kind, says] : diagnosis::finding_lines(result.log_findings, result.flights.size()))
    spdlog::warn("{}: {}", kind, says);
  fmt::print("{}", diagnosis_lines(result));
}

}  // namespace

// an unusable flight is set aside, but one that is not there is a slip of the hand
void check_flight(const std::string& path, std::set<std::filesystem::path>& seen) {
  sidecar_path(path);  // refuses what is no flight log
  if (const std::string why = why_unreadable(path); !why.empty())
    throw DataError(fmt::format("{}: cannot read ({})", path, why));
  check_is_new(path, seen, "a flight is fitted, held out or a reference");
}

void check_flights(const diagnosis::DiagnoseOptions& wanted) {
  std::set<std::filesystem::path> seen;
  for (const auto* paths : {&wanted.fit, &wanted.holdout, &wanted.reference})
    for (const std::string& path : *paths) check_flight(path, seen);
}

std::string diagnosed_key(const std::string& out) {
  std::string key;
  return read_into((std::filesystem::path(out) / key_file).string(), key).empty() ? key : "";
}

// augmented.toml; without effects it says so, and is no file that somebody forgot to fill
std::string model_file(const diagnosis::Diagnosis& result) {
  const bool empty = result.augmented_toml.find("[[effect]]") == std::string::npos;
  return result.augmented_toml + (empty ? "\neffect = []  # nothing was found\n" : "");
}

void warn_of_set_aside(const diagnosis::Diagnosis& result) {
  for (const diagnosis::LogFinding& finding : result.log_findings)
    if (finding.sets_flight_aside)
      spdlog::warn("{}: {}{}", finding.file,
                   finding.says.find("set aside") < finding.says.size() ? "" : "set aside: ", finding.says);
}

diagnosis::Diagnosis diagnose_into(const std::string& out, const diagnosis::DiagnoseOptions& wanted,
                                   const std::string& key) {
  check_folder_can_be_made(out);
  // where it is there, it is replaced by one that is made beside it
  check_folder_can_be_made(std::filesystem::weakly_canonical(std::filesystem::absolute(out)).parent_path().string());
  check_out(out);
  check_flights(wanted);
#ifdef __GLIBC__
  // a diagnosis takes and gives back the same memory hundreds of times: a tenth of its time went to the system
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_TOP_PAD, 64 << 20);
#endif
  diagnosis::Diagnosis result = diagnosis::diagnose(wanted);
  const nlohmann::ordered_json document = diagnosis::to_json(result);

  replace_folder(out, [&](const std::filesystem::path& fresh) {
    write_file((fresh / "diagnosis.json").string(), config::json_text(document, 1) + "\n");
    write_file((fresh / "augmented.toml").string(), model_file(result));
    write_file((fresh / "report.html").string(), diagnosis_page(document, figures_of(result, wanted)));
    if (!key.empty()) write_file((fresh / key_file).string(), key);
  });
  return result;
}

void add_diagnose(CLI::App& app) {
  const auto options = std::make_shared<DiagnoseArguments>();
  CLI::App* command =
      app.add_subcommand("diagnose", "names the physics that the simulation of these flights leaves out");
  command->add_option("FLIGHT", options->flights,
                      "flight logs of one vehicle, NAME.csv or NAME.csv.gz; of one that lasts longer than five "
                      "minutes, the ten stretches of 30 s that tell most");
  command->add_option("--holdout", options->holdout, "flights to verify on (default: the last one)");
  command->add_option(
      "--reference", options->reference,
      "normal flights of the same vehicle: without attitude and body rate, mean commands are compared with theirs");
  command->add_option("--vehicle", options->vehicle,
                      "name under models/ or path to a vehicle.toml or its folder (default: what the logs say)");
  command->add_option("--batch", options->batch,
                      "TOML with [[set]] tables, each with name, fit, holdout, reference, vehicle: each into OUT/NAME");
  command->add_option("--out", options->out, "folder for diagnosis.json, augmented.toml and report.html")->required();
  add_jobs(*command, options->jobs);
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
