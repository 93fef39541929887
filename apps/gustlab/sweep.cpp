#include "sweep/sweep.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <memory>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "simulation/recorder.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

struct SweepArguments {
  ExperimentOptions experiment;
  int jobs = default_jobs();
  std::string out, shard = "1/1";
  std::vector<std::string> variants;
  bool resume = false, dry_run = false, logs = false;
};

Shard read_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  // digits alone, and no more than a number holds
  const auto slash = std::from_chars(text.data(), end, shard.part);
  const bool both = slash.ec == std::errc() && slash.ptr != end && *slash.ptr == '/';
  const auto rest = both ? std::from_chars(slash.ptr + 1, end, shard.parts) : slash;
  if (!both || rest.ec != std::errc() || rest.ptr != end || shard.part < 1 || shard.part > shard.parts)
    throw ConfigError(fmt::format("--shard {}: not a shard (i/N with 1 ≤ i ≤ N); for example --shard 1/3", text));
  return shard;
}

void print_plan(const Experiment& experiment, const Shard& shard) {
  for (const RunSpec& spec : plan(experiment))
    if (shard.has(spec.index))
      fmt::print("{}{},{},{},{}\n", experiment.variant.empty() ? "" : experiment.variant + ",",
                 experiment.trajectories[spec.trajectory].name, experiment.controllers[spec.controller].name,
                 spec.replicate, to_hex(spec.key));
}

void check_logs(const Experiment& experiment) {
  RunSpec spec;
  for (spec.trajectory = 0; spec.trajectory < experiment.trajectories.size(); ++spec.trajectory)
    for (spec.controller = 0; spec.controller < experiment.controllers.size(); ++spec.controller)
      check_log_rows(experiment, spec);
}

void sweep_into(const std::string& out, const Experiment& experiment, const Shard& shard,
                const SweepArguments& options) {
  const std::atomic<bool>& stop = interrupted();
  Progress progress;
  const SweepReport report = sweep(experiment, {out, shard, options.jobs, options.resume, options.logs}, stop,
                                   [&](std::size_t done, std::size_t all) { progress.show(done, all); });
  progress.end();
  if (!report.redone_because.empty())
    spdlog::warn("{}: runs of another program were flown again ({})", out, report.redone_because);
  if (report.done < report.planned) {
    spdlog::warn("interrupted: {} of {} runs in {} are done, go on with --resume", report.done, report.planned, out);
    throw ExitCode{130};
  }
  spdlog::info("{}: {} runs", out, report.done);
}

void sweep_command(const SweepArguments& options) {
  const Shard shard = read_shard(options.shard);
  const std::vector<Experiment> variants = options.experiment.read_variants(options.variants);
  for (const Experiment& variant : variants) check_axis_names(variant);
  if (options.dry_run) {
    fmt::print("{}trajectory,controller,replicate,key\n", variants.front().variant.empty() ? "" : "variant,");
    for (const Experiment& variant : variants) print_plan(variant, shard);
    return;
  }
  if (options.out.empty()) throw ConfigError("sweep: --out is missing (the folder of the results); or use --dry-run");

  if (options.logs)
    for (const Experiment& variant : variants) check_logs(variant);
  check_results_in(options.out, options.variants.empty() ? variants : options.experiment.read_variants({}));
  for (const Experiment& variant : variants) sweep_into(variant_folder(options.out, variant), variant, shard, options);
  if (variants.front().variant.empty()) return;
  if (const std::vector<std::string> left_out = write_combined(options.out); !left_out.empty())
    spdlog::warn("{}/runs.csv is without {} (not finished); go on with --resume", options.out,
                 fmt::join(left_out, ", "));
}

}  // namespace

void add_sweep(CLI::App& app) {
  const auto options = std::make_shared<SweepArguments>();
  CLI::App* command = app.add_subcommand(
      "sweep",
      "flies every run of an experiment into OUT/runs.sqlite and OUT/runs.csv, of each variant into OUT/VARIANT");
  options->experiment.add_to(*command);
  command->add_option("--out", options->out, "folder of the results");
  command
      ->add_option("--variant", options->variants,
                   "flies these only: a [[variant]], or a point of the grid of its [[axis]] tables")
      ->allow_extra_args(false);
  command->add_option("--shard", options->shard, "flies every N-th run, from the i-th on; join with `gustlab merge`")
      ->type_name("i/N")
      ->capture_default_str();
  command->add_flag("--resume", options->resume, "goes on where OUT stands");
  command->add_flag(
      "--logs", options->logs,
      "writes the flight log of every run, too: TRAJECTORY_CONTROLLER_REPLICATE.csv; with --resume also of those "
      "that are done, which are flown again for it");
  command->add_flag("--dry-run", options->dry_run, "prints the plan and flies nothing");
  add_jobs(*command, options->jobs);
  command->callback([options] { sweep_command(*options); });
}

void add_merge(CLI::App& app) {
  struct MergeOptions {
    std::vector<std::string> folders;
    std::string out;
  };
  const auto options = std::make_shared<MergeOptions>();
  CLI::App* command =
      app.add_subcommand("merge", "joins the shards of a sweep; missing, double or unequal runs are errors");
  command->add_option("DIR", options->folders, "folders of the shards")->required();
  command->add_option("--out", options->out, "folder of the whole")->required();
  command->callback([options] { merge(options->folders, options->out); });
}

}  // namespace gustlab
