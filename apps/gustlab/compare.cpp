#include "report/compare.hpp"

#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {

void add_compare(CLI::App& app) {
  struct Options {
    ExperimentOptions experiment;
    std::string folder, format = "md";
    std::vector<std::string> variants;
    double limit_m = 0.5;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "compare", "prints which controller is best where, and when each breaks, over the variants of a sweep");
  options->experiment.add_to(*command);
  command->add_option("DIR", options->folder, "OUT of its finished sweep")->required();
  command
      ->add_option("--limit", options->limit_m, "planar RMSE in m up to which a run that was completed counts as held")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--variant", options->variants, "of these only, as they were flown by `gustlab sweep --variant`")
      ->allow_extra_args(false);
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "json"}))->capture_default_str();
  command->callback([options] {
    std::vector<NamedResults> results;
    for (const Experiment& variant : options->experiment.read_variants(options->variants))
      results.push_back({variant.variant.empty() ? variant.name : variant.variant,
                         read_results_of(variant, options->folder), variant.alone});
    const std::vector<ComparedVariant> compared = compare(results, options->limit_m);
    if (options->format == "json") fmt::print("{}", to_json(compared, options->limit_m));
    else say_on_stdout(to_markdown(compared, options->limit_m));
  });
}

}  // namespace gustlab
