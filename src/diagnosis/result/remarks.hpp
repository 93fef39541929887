// What a stage of a diagnosis says beside the value that it returns.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

struct Remarks {
  std::vector<LogFinding> findings;
  std::vector<std::string> notes;
};

}  // namespace gustlab::diagnosis
