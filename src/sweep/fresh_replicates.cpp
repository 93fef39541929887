#include "sweep/fresh_replicates.hpp"

#include <fmt/format.h>

#include "gustlab/errors.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

namespace {

constexpr std::int64_t last_table_replicate = 10;

}  // namespace

void check_fresh(const SearchedReplicates& searched, const std::string& experiment_path,
                 const std::vector<std::string>& overrides) {
  const auto check = [&](std::int64_t first, std::int64_t count, const std::string& whose) {
    if (first < searched.first + searched.count && searched.first < first + count)
      throw ConfigError(fmt::format(
          "{}: {} on replicates {} to {}, which are {} (what is reported must be fresh); move first_replicate",
          searched.where, searched.searching, searched.first, searched.first + searched.count - 1, whose));
  };
  check(1, last_table_replicate, "the tables'");
  for (const std::vector<std::string>& set : {std::vector<std::string>{}, overrides})
    for (const Experiment& variant : read_variants(experiment_path, set))
      check(variant.first_replicate, variant.replicates, "those of " + variant.name);
}

}  // namespace gustlab
