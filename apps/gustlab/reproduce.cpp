#include "report/reproduction.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>

#include "calibration/calibration.hpp"
#include "commands.hpp"
#include "config/resources.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "sweep/sweep.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

// the tables of the paper, and the experiments that stand for them
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> paper_tables{
    {{"table1", "table1_iris"}, {"table2", "table2_crazyflie"}, {"table3", "table3_real_proxy"}}};
constexpr std::string_view proxy_table = "table3";

struct ReproduceArguments {
  std::string table = "all", experiment, out;
  int jobs = default_jobs();
};

// one report: tables of the paper, and the experiments that are flown for them
struct Report {
  std::string folder;
  std::vector<OurTable> tables;  // still without runs
  std::vector<Experiment> experiments;

  void add(std::string_view table, Experiment experiment, bool all_replicates) {
    tables.push_back({std::string(table), experiment.name, experiment.vehicle.name, {}, all_replicates});
    experiments.push_back(std::move(experiment));
  }
};

// what still air lacks; a constant force stays, which is a vehicle's own as well
bool is_wind(std::string_view effect) {
  const EffectRow& row = *find_effect(effect);
  return row.air == Airflow::wind || (row.external && !row.is_predictable());
}

// flies what the folder does not hold yet
std::vector<ResultRow> fly_table(const Experiment& experiment, const std::string& folder, int jobs) {
  const std::atomic<bool>& stop = interrupted();
  Progress progress;
  const SweepReport report = sweep(experiment, {folder, {}, jobs, true}, stop,
                                   [&](std::size_t done, std::size_t all) { progress.show(done, all); });
  progress.end();
  if (report.done < report.planned) throw ExitCode{130};
  return read_results(folder).rows;
}

void write(Report& report, const Published& published, const std::vector<Calibration>& calibrations, int jobs) {
  const fs::path out(report.folder);
  for (std::size_t i = 0; i < report.tables.size(); ++i) {
    Experiment& experiment = report.experiments[i];
    OurTable& table = report.tables[i];
    table.rows = fly_table(experiment, (out / table.experiment).string(), jobs);
    table.arcs = arcs_of(experiment);
    std::erase_if(experiment.effects, [](const EffectSpec& spec) { return is_wind(spec.type); });
    table.still = fly_table(experiment, (out / (table.experiment + ".still_air")).string(), jobs);
  }

  const Reproduction reproduction =
      reproduce(published, report.tables, [&](const PublishedRow& row, std::size_t metric) {
        if (row.table == proxy_table) return Use::proxy;
        for (const Calibration& calibration : calibrations) {
          if (calibration.table != row.table) continue;
          if (calibration.fits(row.trajectory, row.controller, metric)) return Use::fitted;
          if (const KnownCell* known = calibration.find_known(row.trajectory, row.controller, metric))
            return known->by_construction ? Use::by_construction : Use::after_seeing;
        }
        return Use::blind;
      });
  const std::string markdown = to_markdown(reproduction, report.tables);
  write_together([&] {
    make_folder((out / "figures").string());
    write_file((out / "figures" / "ours_against_paper.svg").string(), to_svg(reproduction));
    write_file((out / "reproduction.json").string(), to_json(reproduction));
    write_file((out / "reproduction.md").string(), markdown);
  });
  std::fwrite(markdown.data(), 1, markdown.size(), stdout);
}

void reproduce_command(const ReproduceArguments& options) {
  const Published published = read_published(find_resource("experiments/published_tables.toml"));
  std::vector<Report> reports;
  std::vector<Calibration> calibrations;
  if (!options.experiment.empty()) {
    if (options.table == "all")
      throw ConfigError(
          "--experiment stands for one table (which of the paper's is it compared with?); name table1, table2 or "
          "table3");
    for (Experiment& variant : read_variants(find_experiment(options.experiment))) {
      const std::string folder = variant_folder(options.out, variant);
      published.check_vehicle(options.table, variant);
      reports.push_back({folder, {}, {}});
      reports.back().add(options.table, std::move(variant), true);
    }
  } else {
    reports.push_back({options.out, {}, {}});
  }
  for (const auto& [table, name] : paper_tables) {
    if (options.table != "all" && options.table != table) continue;
    const std::string path = find_experiment(std::string(name));
    if (options.experiment.empty()) reports.front().add(table, read_experiment(path), false);
    // an experiment in a table's place may have been fitted by itself
    std::string calibration = options.experiment.empty() ? "" : calibration_path(find_experiment(options.experiment));
    if (!fs::is_regular_file(calibration)) calibration = calibration_path(path);
    if (fs::is_regular_file(calibration)) calibrations.push_back(read_calibration(calibration));
  }
  for (const Report& report : reports) {
    check_files_can_be_written(report.folder, {"reproduction.json", "reproduction.md"});
    check_files_can_be_written((fs::path(report.folder) / "figures").string(), {"ours_against_paper.svg"});
  }
  for (Report& report : reports) write(report, published, calibrations, options.jobs);
}

}  // namespace

void add_reproduce(CLI::App& app) {
  const auto options = std::make_shared<ReproduceArguments>();
  CLI::App* command =
      app.add_subcommand("reproduce", "flies the paper's tables and puts ours beside the published ones");
  command->add_option("TABLE", options->table, "table1, table2, table3 or all")
      ->check(CLI::IsMember({"table1", "table2", "table3", "all"}))
      ->capture_default_str();
  command->add_option("--experiment", options->experiment,
                      "flown in the place of TABLE's own, each of its variants: every replicate counts");
  command
      ->add_option("--out", options->out,
                   "folder of reproduction.json, .md, figures, and of the sweeps, which go on where they stand")
      ->required();
  add_jobs(*command, options->jobs);
  command->callback([options] { reproduce_command(*options); });
}

}  // namespace gustlab
