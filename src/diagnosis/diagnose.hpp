// From recordings to the name of the missing physics (DIAGNOSIS.md §3).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/result/diagnosis.hpp"
#include "util/progress.hpp"

namespace gustlab::diagnosis {

struct DiagnoseOptions {
  std::vector<std::string> fit;        // flight logs
  std::vector<std::string> holdout;    // empty: the last flight, or the last third of the only one
  std::vector<std::string> reference;  // normal flights of the vehicle, for logs without attitude and body rate
  std::optional<std::string> vehicle;  // overrides the logs'
  int jobs = 1;
  ProgressReport progress;  // empty: none
};

// Throws DataError when no fit flight is usable.
Diagnosis diagnose(const DiagnoseOptions& options);

}  // namespace gustlab::diagnosis
