// Findings of logs in short: one line for all flights that show the same.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

struct FindingLine {
  std::string kind, says;
};

// One line per kind, column and wording, in the order of their first: "3 of 8 flights: u1…uN …". Numbers that differ between
// flights become ranges. `flights`: how many there are.
std::vector<FindingLine> finding_lines(const std::vector<LogFinding>& findings, std::size_t flights);

}  // namespace gustlab::diagnosis
