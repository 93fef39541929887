#pragma once

#include <string_view>

namespace gustlab::report {

// The style sheet of the report: light, dark and paper.
std::string_view page_style();

}  // namespace gustlab::report
