#include "learning/training_data.hpp"

#include <fmt/format.h>

#include "control/daiml_input.hpp"
#include "gustlab/errors.hpp"
#include "identification/force_residual.hpp"
#include "simulation/flight.hpp"
#include "simulation/recorded_forces.hpp"
#include "simulation/recorder.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

FlightLog fly_logged(const Experiment& experiment, const RunSpec& spec) {
  LoggedRun flown = run_logged(experiment, spec, AtInterrupt::end);
  const RunRecord& end = flown.record;
  if (end.outcome != Outcome::completed)
    throw ConfigError(fmt::format("{}: {} replicate {} {} after {:.1f} s (training needs whole flights); use less wind",
                                  experiment.name, experiment.trajectories[spec.trajectory].name, spec.replicate,
                                  to_string(end.outcome), end.duration_s));
  return std::move(flown.log);
}

Samples samples_of(const FlightLog& log, const VehicleModel& vehicle) {
  const RecordedForces forces(log, vehicle, Known::thrust);
  const KnownModel known = [&](std::size_t row, const VehicleState& state) {
    const RecordedForces::Force force = forces.at(row, state);
    return KnownForce{force.force_B_N, force.thrust_N};
  };
  const Differentiation differentiation{.smoothing_window = 5, .edge_s = 1.0};
  const auto parts = force_residual(log, forces.vehicle(), known, differentiation, AccelerationSource::velocity);

  Eigen::Index count = 0, i = 0;
  for (const ResidualSamples& part : parts) count += part.force_W_N.rows();
  Samples samples{Eigen::MatrixXd(count, daiml_inputs), Eigen::MatrixXd(count, 3)};
  const Mixer mixer(vehicle);
  std::size_t row = 0;
  const auto cell = [&](const char* name) { return (*log.find(name))[row]; };
  for (const ResidualSamples& part : parts)
    for (std::size_t k = 0; k < part.time_s.size(); ++k, ++i) {
      while (log.time_s[row] < part.time_s[k]) ++row;
      RotorArray speed_radps{};
      for (std::size_t r = 0; r < static_cast<std::size_t>(vehicle.rotor_count); ++r)
        speed_radps[r] = (*log.find(fmt::format("rotor{}", r + 1)))[row];
      const auto input = daiml_input(vehicle, mixer, {cell("vx"), cell("vy"), cell("vz")},
                                     {cell("qw"), cell("qx"), cell("qy"), cell("qz")}, speed_radps);
      samples.inputs.row(i) = Eigen::Map<const Eigen::RowVectorXd>(input.data(), daiml_inputs);
      samples.residual.row(i) = part.force_W_N.row(static_cast<Eigen::Index>(k)) / vehicle.mass_kg;
    }
  return samples;
}

// rows of `more` below those of `all`
void append(Eigen::MatrixXd& all, const Eigen::MatrixXd& more) {
  const Eigen::Index rows = all.rows();
  all.conservativeResize(rows + more.rows(), more.cols());
  all.bottomRows(more.rows()) = more;
}

}  // namespace

std::vector<Condition> collect(std::span<const Experiment> variants, int jobs) {
  struct Planned {
    std::size_t variant;
    RunSpec spec;
  };
  std::vector<Planned> runs;
  for (std::size_t v = 0; v < variants.size(); ++v)
    for (const RunSpec& spec : plan(variants[v])) runs.push_back({v, spec});
  std::vector<Samples> flown(runs.size());
  parallel_for(static_cast<std::int64_t>(runs.size()), jobs, [&](std::int64_t i) {
    const Planned& run = runs[static_cast<std::size_t>(i)];
    const Experiment& experiment = variants[run.variant];
    flown[static_cast<std::size_t>(i)] = samples_of(fly_logged(experiment, run.spec), experiment.vehicle);
  });

  std::vector<Condition> conditions;
  for (const Experiment& variant : variants) conditions.push_back({variant.variant, variant.held_out, {}});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Samples& all = conditions[runs[i].variant].samples;
    append(all.inputs, flown[i].inputs);
    append(all.residual, flown[i].residual);
  }
  return conditions;
}

}  // namespace gustlab
