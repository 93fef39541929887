// `gustlab score`: how good were the diagnoses of concealed trials?
//
// A missing or unreadable diagnosis is a failure of its trial, never left out. Proportions carry Wilson 95 % intervals.
// Strength is counted in detection limits (DIAGNOSIS.md §6); headline figures are of trials above the limit, the rest is
// shown beside them.
#pragma once

#include "report/score_trial.hpp"

namespace gustlab {

// All figures, with the list of trials that were not right. `diagnosis_folder`: where in a trial's folder to look.
nlohmann::ordered_json score_trials(const std::vector<TrialSet>& sets,
                                    const std::string& diagnosis_folder = "diagnosis");

// The same as Markdown tables, readable as plain text.
std::string score_markdown(const nlohmann::ordered_json& score);

}  // namespace gustlab
