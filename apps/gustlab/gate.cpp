#include "report/gate.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "options.hpp"
#include "sweep/sweep.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

struct GateArguments {
  std::string folder, baseline, junit, summary;
  bool update = false;
  GateTolerance tolerance;
};

void gate_command(const GateArguments& options) {
  const Results results = read_results(options.folder);
  if (options.update) return write_file(options.baseline, to_csv(results.rows));
  const GateReport report = gate(results.rows, read_results_csv(options.baseline), options.tolerance);
  const std::string summary = to_markdown(report);
  for (const std::string& path : {options.junit, options.summary})
    if (!path.empty()) check_file_can_be_written(path);
  if (!options.junit.empty()) write_file(options.junit, to_junit(report));
  if (!options.summary.empty()) write_file(options.summary, summary);
  std::fwrite(summary.data(), 1, summary.size(), stdout);
  if (report.failures() > 0) throw ExitCode{1};
}

}  // namespace

void add_gate(CLI::App& app) {
  const auto options = std::make_shared<GateArguments>();
  CLI::App* command = app.add_subcommand("gate", "compares a sweep with a baseline, run by run; exit 1 when it is worse");
  command->add_option("DIR", options->folder, "folder of a finished sweep")->required();
  command->add_option("--baseline", options->baseline, "a runs.csv of the same plan")->required();
  command->add_flag("--update", options->update, "makes the sweep the baseline");
  command->add_option("--absolute", options->tolerance.absolute_m, "rise of an error that is allowed, m")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--relative", options->tolerance.relative, "share of the baseline that is allowed as well")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--junit", options->junit, "writes JUnit XML");
  command->add_option("--summary", options->summary, "writes the Markdown that is printed");
  command->callback([options] { gate_command(*options); });
}

}  // namespace gustlab
