// What is reported is fresh: no search may fly the gusts that a table shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gustlab {

// A search over these replicates, which `where` (file:line:col) asks for.
struct SearchedReplicates {
  std::string_view searching;  // "tunes", "calibrates"
  std::string where;
  std::int64_t first, count;
};

// Throws ConfigError there when they are replicates of the paper's tables, or those that the experiment reports, as its file
// stands or as `overrides` have it.
void check_fresh(const SearchedReplicates& searched, const std::string& experiment_path,
                 const std::vector<std::string>& overrides);

}  // namespace gustlab
