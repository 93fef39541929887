#include "report/gate.hpp"

#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "sweep/sweep.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

struct GateArguments {
  std::string folder, baseline, junit, summary;
  std::string fails_by = "both";
  bool update = false;
  GateRule rule;
};

void gate_command(const GateArguments& options, const CLI::App& command) {
  check_is_read(command, {"--fails-by", "--margin", "--level", "--floor", "--allow-extra", "--junit", "--summary"},
                !options.update, "--update", "a comparison");
  const Results results = read_results(options.folder);
  if (options.update) return write_file(options.baseline, to_csv(results.rows));
  GateRule rule = options.rule;
  rule.by_margin = options.fails_by != "test";
  rule.by_test = options.fails_by != "margin";
  const std::vector<ResultRow> baseline = read_results_csv(options.baseline);
  if (baseline.empty())
    throw DataError(fmt::format("{}:1:1: the baseline has no rows (no run to compare with); make one with --update",
                                options.baseline));
  const GateReport report = gate(results.rows, baseline, rule);
  const std::string summary = to_markdown(report);
  for (const std::string& path : {options.junit, options.summary})
    if (!path.empty()) check_file_can_be_written(path);
  write_together([&] {
    if (!options.junit.empty()) write_file(options.junit, to_junit(report));
    if (!options.summary.empty()) write_file(options.summary, summary);
  });
  say_on_stdout(summary);
  if (report.failures() > 0) throw ExitCode{1};
}

// what both were called before
std::string former_word(std::string word) { return word == "margin,test" ? "both" : word; }

}  // namespace

void add_gate(CLI::App& app) {
  const auto options = std::make_shared<GateArguments>();
  CLI::App* command =
      app.add_subcommand("gate", "compares a sweep with a baseline, cell by cell in pairs; exit 1 when one is worse");
  command->add_option("DIR", options->folder, "folder of a finished sweep")->required();
  command->add_option("--baseline", options->baseline, "a runs.csv of the same experiment")->required();
  command->add_flag("--update", options->update, "makes the sweep the baseline");
  command
      ->add_option("--fails-by", options->fails_by,
                   "what fails a cell: margin (its mean error rose beyond it), test (it rose significantly) or both")
      ->transform(CLI::IsMember({"margin", "test", "both"}, former_word))
      ->capture_default_str();
  command
      ->add_option("--margin", options->rule.margin,
                   "rise of a mean error that is allowed, as a share of the baseline's")
      ->check(not_negative())
      ->capture_default_str();
  command
      ->add_option("--level", options->rule.level,
                   "p below which a rise is significant, over all tests together (Holm)")
      ->check(number_up_to(1.0))
      ->capture_default_str();
  command->add_option("--floor", options->rule.floor_m, "rise of a mean error that never fails, m")
      ->check(not_negative())
      ->capture_default_str();
  command->add_flag("--allow-extra", options->rule.allow_extra, "leaves out runs that the baseline does not have");
  command->add_option("--junit", options->junit, "writes JUnit XML, one test for each cell");
  command->add_option("--summary", options->summary, "writes the Markdown that is printed");
  command->callback([options, command] { gate_command(*options, *command); });
}

}  // namespace gustlab
