#include "identification/identify.hpp"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "simulation/recorded_forces.hpp"
#include "util/files.hpp"
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

// the residual force of one flight, in unbroken parts
std::vector<ResidualSamples> samples_of(const std::string& path, const IdentifyArguments& options) {
  const FlightLog log = read_flight_log(path);
  VehicleModel vehicle = options.vehicle.empty() ? read_vehicle(log.meta.vehicle, path) : read_vehicle(options.vehicle);
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

std::vector<std::vector<ResidualSamples>> samples_of(const std::vector<std::string>& paths, const IdentifyArguments& options) {
  std::vector<std::vector<ResidualSamples>> flights;
  for (const std::string& path : paths) flights.push_back(samples_of(path, options));
  return flights;
}

// --yes, --no or neither
std::optional<bool> choice(bool yes, bool no) { return yes || no ? std::optional<bool>(yes) : std::nullopt; }

void run(IdentifyArguments options) {
  options.differentiation.kind = derivative_kind(options.derivative);
  options.identify.penalty = regularizer(options.penalty);
  options.identify.normalize_columns = choice(options.normalize, options.no_normalize);
  options.identify.refit = choice(options.refit, options.no_refit);
  const Identification found =
      identify(samples_of(options.logs, options), samples_of(options.holdout, options), options.identify);
  if (!options.out.empty()) {
    std::vector<std::string> names;
    for (const std::string& path : options.logs) names.push_back(std::filesystem::path(path).filename().string());
    if (names.size() > 6) names = {names.front(), "and " + std::to_string(names.size() - 1) + " more"};
    write_file(options.out, to_toml(found, names));
  }
  const std::string text = options.format == "json"  ? to_json(found)
                           : options.format == "csv" ? to_csv(found)
                                                     : to_markdown(found);
  std::fwrite(text.data(), 1, text.size(), stdout);
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
  command->add_option("--lambda", identify.lambda,
                      "sparsity: threshold (stlsq), weight (sr3), price of a term (best_subset); without it, chosen by "
                      "cross-validation");
  command->add_option("--nu", identify.nu, "relaxation of sr3")->capture_default_str();
  command->add_option("--penalty", options->penalty, "l0 | l1 | l2, for sr3")->capture_default_str();
  command
      ->add_option("--constraint", identify.constraints, "for sr3, repeatable: \"fx[T sin theta] + fy[T sin phi] = 0\"")
      ->allow_extra_args(false);
  command->add_option("--ridge", identify.ridge, "for stlsq; default 0.05 with --lambda, otherwise 0");
  command->add_option("--max-terms", identify.max_terms, "for best_subset, per axis; 0: any")->capture_default_str();
  command->add_option("--tolerance", identify.tolerance, "of sr3");
  command->add_option("--max-iterations", identify.max_iterations, "of stlsq and sr3");
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
  command->add_option("--derivative", options->derivative, "finite_difference | savitzky_golay")->capture_default_str();
  command->add_option("--smooth", options->differentiation.smoothing_window, "samples of a running mean, odd")
      ->capture_default_str();
  command->add_option("--window", options->differentiation.window, "samples, for savitzky_golay")
      ->capture_default_str();
  command->add_option("--degree", options->differentiation.degree, "for savitzky_golay")->capture_default_str();
  command->add_option("--trim", options->differentiation.edge_s, "seconds cut off at both ends")->capture_default_str();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "csv", "json"}))->capture_default_str();
  command->add_option("--out", options->out, "MODEL.toml: the model as an [[effect]] that any experiment can include");
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
