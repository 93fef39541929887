#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "report/tables.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {

void add_table(CLI::App& app) {
  struct Options {
    std::string folder, format = "md";
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("table", "prints a sweep: mean ± sd (median) over runs, completed of all");
  command->add_option("DIR", options->folder, "folder of a finished sweep")->required();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "csv", "latex", "json"}))->capture_default_str();
  command->callback([options] {
    const std::string text = to_table(read_results(options->folder), find_table_format(options->format).value());
    std::fwrite(text.data(), 1, text.size(), stdout);
  });
}

}  // namespace gustlab
