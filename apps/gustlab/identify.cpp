#include "identification/identify.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "options.hpp"
#include "simulation/recorded_forces.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

struct IdentifyArguments {
  std::vector<std::string> logs, holdout;
  std::string vehicle;
  std::string known = "vehicle";
  std::string acceleration = "velocity";
  std::string derivative = "finite_difference";
  Differentiation differentiation;
  std::string penalty = "l0";
  IdentifyOptions identify;
  bool normalize = false, no_normalize = false, refit = false, no_refit = false;
  std::string format = "md";
  std::string out;
};

void check_options_are_read(const CLI::App& command, const IdentifyArguments& options) {
  const auto only = [&](std::initializer_list<const char*> names, bool read, const std::string& chosen,
                        const char* readers) { check_is_read(command, names, read, chosen, readers); };
  const std::string& optimizer = options.identify.optimizer;
  only({"--nu", "--penalty", "--constraint", "--tolerance"}, optimizer == "sr3", "optimizer " + optimizer, "sr3");
  only({"--ridge"}, optimizer == "stlsq", "optimizer " + optimizer, "stlsq");
  only({"--max-terms"}, optimizer == "best_subset", "optimizer " + optimizer, "best_subset");
  only({"--max-iterations"}, optimizer != "best_subset", "optimizer " + optimizer, "stlsq and sr3");
  only({"--window", "--degree"}, options.derivative == "savitzky_golay", "derivative " + options.derivative,
       "savitzky_golay");
}

// a flight that is fitted twice counts twice, and one that is fitted proves nothing when it is held out
void check_flights_differ(const IdentifyArguments& options) {
  std::vector<std::string> all = options.logs;
  all.insert(all.end(), options.holdout.begin(), options.holdout.end());
  check_paths_differ(all, "a flight is fitted once, or held out");
}

// the one that --vehicle names may be another description of the vehicle that flew, but hardly another vehicle
VehicleModel named_vehicle(const std::string& name, const FlightLog& log) {
  const VehicleModel vehicle = read_vehicle(name);
  std::string flown = log.meta.vehicle;
  try {
    flown = read_vehicle(flown, log.path).name;
  } catch (const ConfigError&) {
    // only its name is known
  }
  if (!flown.empty() && flown != vehicle.name)
    spdlog::warn("{}: flown by \"{}\", and --vehicle {} is \"{}\"", log.path, flown, name, vehicle.name);
  return vehicle;
}

// the residual force of one flight, in unbroken parts; `flown`: the vehicle of all of them
std::vector<ResidualSamples> samples_of(const std::string& path, const IdentifyArguments& options, OneVehicle& flown) {
  const FlightLog log = read_flight_log(path);
  VehicleModel vehicle =
      options.vehicle.empty() ? flown.of({path, log.meta.vehicle}) : named_vehicle(options.vehicle, log);
  vehicle.environment = log.meta.environment;
  const RecordedForces forces(log, vehicle, options.known == "thrust" ? Known::thrust : Known::vehicle);
  const KnownModel known = [&](std::size_t row, const VehicleState& state) {
    const RecordedForces::Force force = forces.at(row, state);
    return KnownForce{force.force_B_N, force.thrust_N};
  };
  const auto source =
      options.acceleration == "velocity" ? AccelerationSource::velocity : AccelerationSource::accelerometer;
  return force_residual(log, forces.vehicle(), known, options.differentiation, source);
}

std::vector<std::vector<ResidualSamples>> samples_of(const std::vector<std::string>& paths,
                                                     const IdentifyArguments& options, OneVehicle& flown) {
  std::vector<std::vector<ResidualSamples>> flights;
  for (const std::string& path : paths) throw_if_interrupted(), flights.push_back(samples_of(path, options, flown));
  return flights;
}

// --yes, --no or neither
std::optional<bool> choice(bool yes, bool no) { return yes || no ? std::optional<bool>(yes) : std::nullopt; }

void run(IdentifyArguments options, const CLI::App& command) {
  interrupted();
  find_optimizer(options.identify.optimizer);
  options.differentiation.kind = derivative_kind(options.derivative);
  options.identify.penalty = regularizer(options.penalty);
  options.identify.normalize_columns = choice(options.normalize, options.no_normalize);
  options.identify.refit = choice(options.refit, options.no_refit);
  check_options_are_read(command, options);
  check_flights_differ(options);
  OneVehicle flown;
  const auto fit = samples_of(options.logs, options, flown), holdout = samples_of(options.holdout, options, flown);
  if (!options.out.empty()) check_file_can_be_written(options.out);
  const Identification found = identify(fit, holdout, options.identify);
  const bool found_none = found.model().terms().empty();
  if (!options.out.empty() && !found_none) {
    std::vector<std::string> names;
    for (const std::string& path : options.logs) names.push_back(std::filesystem::path(path).filename().string());
    if (names.size() > 6) names = {names.front(), "and " + std::to_string(names.size() - 1) + " more"};
    write_file(options.out, to_toml(found, names));
  }
  const std::string text = options.format == "json"  ? to_json(found)
                           : options.format == "csv" ? to_csv(found)
                                                     : to_markdown(found);
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (options.out.empty() || !found_none) return;
  spdlog::error("{}: not written (no term was found, and a model without terms is none)", options.out);
  throw ExitCode{1};
}

}  // namespace

void add_identify(CLI::App& app) {
  const auto options = std::make_shared<IdentifyArguments>();
  IdentifyOptions& identify = options->identify;
  CLI::App* command =
      app.add_subcommand("identify", "finds a sparse model of the force that the known model leaves over (SINDy)");
  command->add_option("LOG", options->logs, "flights to fit, NAME.csv or NAME.csv.gz")->required();
  command->add_option("--holdout", options->holdout,
                      "flights for error_holdout alone; without any it is cross-validated");
  command->add_option("--vehicle", options->vehicle, "instead of the one that each log names");
  command
      ->add_option("--library", identify.library,
                   "paper | polynomial:DEGREE:VARIABLES | trigonometric:MULTIPLES:VARIABLES | term,term,...; "
                   "joined with + (gustlab list terms)")
      ->capture_default_str();
  command->add_option("--optimizer", identify.optimizer, "stlsq | sr3 | best_subset")->capture_default_str();
  command
      ->add_option("--lambda", identify.lambda,
                   "sparsity: threshold (stlsq), weight (sr3), price of a term (best_subset); without it, chosen by "
                   "cross-validation")
      ->check(not_negative());
  command->add_option("--nu", identify.nu, "relaxation of sr3")->check(positive())->capture_default_str();
  command->add_option("--penalty", options->penalty, "l0 | l1 | l2, for sr3")->capture_default_str();
  command
      ->add_option("--constraint", identify.constraints, "for sr3, repeatable: \"fx[T sin theta] + fy[T sin phi] = 0\"")
      ->allow_extra_args(false);
  command->add_option("--ridge", identify.ridge, "for stlsq; default 0.05 with --lambda, otherwise 0")
      ->check(not_negative());
  command->add_option("--max-terms", identify.max_terms, "for best_subset, per axis; 0: any")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--tolerance", identify.tolerance, "of sr3")->check(positive());
  command->add_option("--max-iterations", identify.max_iterations, "of stlsq and sr3")->check(positive());
  command->add_flag("--normalize", options->normalize, "columns of equal length (default without --lambda)");
  command->add_flag("--no-normalize", options->no_normalize, "columns as they are (default with --lambda)")
      ->excludes("--normalize");
  command->add_flag("--refit", options->refit, "least squares on the terms that were found (default without --lambda)");
  command->add_flag("--no-refit", options->no_refit, "coefficients as the optimizer leaves them")->excludes("--refit");
  command->add_option("--acceleration", options->acceleration, "velocity (its derivative) | accelerometer")
      ->check(CLI::IsMember({"velocity", "accelerometer"}))
      ->capture_default_str();
  command
      ->add_option("--known", options->known, "what is not to be found: vehicle (with its own effects) | thrust alone")
      ->check(CLI::IsMember({"vehicle", "thrust"}))
      ->capture_default_str();
  command
      ->add_option("--derivative", options->derivative,
                   "finite_difference | savitzky_golay, which smooths state and force, too")
      ->capture_default_str();
  command->add_option("--smooth", options->differentiation.smoothing_window, "samples of a running mean, odd")
      ->capture_default_str();
  command->add_option("--window", options->differentiation.window, "samples, for savitzky_golay")
      ->capture_default_str();
  command->add_option("--degree", options->differentiation.degree, "for savitzky_golay")->capture_default_str();
  command->add_option("--trim", options->differentiation.edge_s, "seconds cut off at both ends")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "csv", "json"}))->capture_default_str();
  command->add_option("--out", options->out, "MODEL.toml: the model as an [[effect]] that any experiment can include");
  command->callback([options, command] { run(*options, *command); });
}

}  // namespace gustlab
