// The figures of a score: power, parameters, reliability, held-out closure.
#pragma once

#include "report/score_trial.hpp"

namespace gustlab {

// {k, n, share, low, high}; share and interval are null when n is 0.
nlohmann::ordered_json score_rate(std::size_t k, std::size_t n);

// Share of concealed effects that were named against strength over limit, and of single trials that were exact.
nlohmann::ordered_json score_power(const std::vector<ScoredTrial>& trials);

// Error of each fitted parameter whose effect was named by its own name, and how often its 95 % interval covers the
// truth. Relative errors are to the norm of all parameters of the effect that share its unit.
nlohmann::ordered_json score_parameters(const std::vector<ScoredTrial>& trials);

// Of every name given: how often was it right, against how sure it said it was (ten bins; ECE: Naeini et al., AAAI 2015).
nlohmann::ordered_json score_reliability(const std::vector<ScoredTrial>& trials);

// (before − after) / (before − floor) on held-out flights of trials that conceal an effect above its limit; the floor is
// the measurement noise and, where the answers give it, the error of the oracle, which knows what is concealed.
nlohmann::ordered_json score_closure(const std::vector<ScoredTrial>& trials);

}  // namespace gustlab
