#include "calibration/calibration.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "config/resources.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

struct CalibrateArguments {
  std::string experiment, calibration, out;
  std::vector<std::string> set;
  int jobs = default_jobs();
};

nlohmann::ordered_json to_json(const CalibrationStage& stage, const StageResult& result, const Published& published,
                               const std::string& table) {
  nlohmann::ordered_json json{{"stage", stage.name},       {"evaluations", result.evaluations},
                              {"flights", result.flights}, {"start_loss", result.start_loss},
                              {"loss", result.loss},       {"share_as_far", result.share_as_far}};
  for (std::size_t i = 0; i < stage.parameters.size(); ++i) {
    const OpenParameter& p = stage.parameters[i];
    json["parameters"].push_back({{"key", p.key},
                                  {"unit", p.unit},
                                  {"min", p.min},
                                  {"max", p.max},
                                  {"start", p.start},
                                  {"value", result.values[i]}});
  }
  for (std::size_t i = 0; i < stage.targets.size(); ++i) {
    const Target& cell = stage.targets[i];
    const Summary& paper = published.find(table, cell.trajectory, cell.controller)->figures[cell.metric];
    json["targets"].push_back({{"trajectory", cell.trajectory},
                               {"controller", cell.controller},
                               {"metric", published_metrics[cell.metric]},
                               {"statistic", statistic_names[static_cast<std::size_t>(cell.statistic)]},
                               {"paper", statistic_of(paper, cell.statistic)},
                               {"ours", result.figures[i]}});
  }
  return json;
}

std::string to_markdown(const std::vector<CalibrationStage>& stages, const std::vector<StageResult>& results,
                        const nlohmann::ordered_json& json) {
  std::string text = fmt::format(
      "Calibration on replicates {} to {}, none of which is reported.\n", json["first_replicate"].get<std::int64_t>(),
      json["first_replicate"].get<std::int64_t>() + json["replicates"].get<std::int64_t>() - 1);
  for (std::size_t k = 0; k < results.size(); ++k) {
    text += fmt::format(
        "\n**{}**: {} evaluations, {} flights, {} figures; mean squared log ratio {:.4f}, at the start {:.4f}. "
        "Of tables of as few runs as the paper's, drawn from these flights, {:.0f} % are as far from all of them as "
        "the paper's.\n\n",
        stages[k].name, results[k].evaluations, results[k].flights, stages[k].targets.size(), results[k].loss,
        results[k].start_loss, 100.0 * results[k].share_as_far);
    text += "| parameter | unit | searched | value |\n|---|---|---|--:|\n";
    for (std::size_t i = 0; i < stages[k].parameters.size(); ++i) {
      const OpenParameter& p = stages[k].parameters[i];
      text += fmt::format("| `{}` | {} | {} to {} | {} |\n", p.key, p.unit, config::shortest(p.min),
                          config::shortest(p.max), config::shortest(results[k].values[i]));
    }
    text += "\n| figure | paper, m | ours, m | ratio |\n|---|--:|--:|--:|\n";
    for (const auto& target : json["stages"][k]["targets"]) {
      const double paper = target["paper"].get<double>(), ours = target["ours"].get<double>();
      text += fmt::format("| {} {} {}, {} | {:.3f} | {:.3f} | {:.2f} |\n", target["trajectory"].get<std::string>(),
                          target["controller"].get<std::string>(), target["metric"].get<std::string>(),
                          target["statistic"].get<std::string>(), paper, ours, ours / paper);
    }
  }
  return text;
}

void calibrate_command(const CalibrateArguments& options) {
  check_set_once(options.set);
  const std::string path = find_experiment(options.experiment);
  const std::string beside = options.calibration.empty() ? calibration_path(path) : options.calibration;
  const Calibration calibration = read_calibration(beside);
  const Published published = read_published(find_resource("experiments/published_tables.toml"));
  const std::string name = read_experiment(path).name;
  check_files_can_be_written(options.out, {"calibration.json", "calibration.md", "values.txt", "flown.jsonl"});

  const std::atomic<bool>& stop = interrupted();
  make_folder(options.out);
  const std::string flown = (std::filesystem::path(options.out) / "flown.jsonl").string();
  Progress progress;
  const std::vector<StageResult> results = calibrate(
      path, options.set, calibration, published, options.jobs, stop,
      [&](std::size_t done, std::size_t all) { progress.show(done, all); }, flown);
  progress.end();
  if (results.size() < calibration.stages.size()) throw ExitCode{130};

  nlohmann::ordered_json json{{"format", "gustlab-calibrated/1"},
                              {"experiment", name},
                              {"first_replicate", calibration.first_replicate},
                              {"replicates", calibration.replicates}};
  std::string values;
  for (std::size_t k = 0; k < results.size(); ++k) {
    json["stages"].push_back(to_json(calibration.stages[k], results[k], published, calibration.table));
    for (std::size_t i = 0; i < results[k].values.size(); ++i)
      values +=
          fmt::format("{} = {}\n", calibration.stages[k].parameters[i].key, config::shortest(results[k].values[i]));
  }
  const std::string markdown = to_markdown(calibration.stages, results, json);
  write_together([&] {
    const std::filesystem::path out(options.out);
    write_file((out / "calibration.json").string(), config::json_text(json, 2) + "\n");
    write_file((out / "calibration.md").string(), markdown);
    write_file((out / "values.txt").string(), values);
  });
  std::filesystem::remove(flown);
  std::fwrite(markdown.data(), 1, markdown.size(), stdout);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  const auto options = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand(
      "calibrate", "fits what the paper leaves open to some of its cells, on seeds that are not reported");
  command
      ->add_option("EXPERIMENT", options->experiment,
                   "a TOML file, or its name under experiments/; NAME.calibration.toml stands beside it")
      ->required();
  command->add_option("--calibration", options->calibration,
                      "another file that says what may vary and what it is fitted to");
  command
      ->add_option("--set", options->set,
                   "changes a key of the experiment: key=value with a dotted key, any number of them")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command
      ->add_option("--out", options->out,
                   "folder of calibration.json, calibration.md and values.txt (for --set); a "
                   "calibration that was interrupted goes on there")
      ->required();
  add_jobs(*command, options->jobs);
  command->callback([options] { calibrate_command(*options); });
}

}  // namespace gustlab
