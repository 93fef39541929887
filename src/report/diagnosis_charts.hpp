// The figures of the report, each with its units, its N and what was left out.
#pragma once

#include "report/diagnosis_page.hpp"

namespace gustlab::report {

std::string horizon_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures);
std::string residual_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures);
std::string window_section(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures);

}  // namespace gustlab::report
