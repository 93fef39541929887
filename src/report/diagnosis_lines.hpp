// A diagnosis in a few lines, for a terminal.
#pragma once

#include <string>

#include "diagnosis/result/diagnosis.hpp"

namespace gustlab {

// The verdict; a line for each name, with its alternatives below it; what is only suspected.
std::string diagnosis_lines(const diagnosis::Diagnosis& result);

}  // namespace gustlab
