// A set against another set: which of the two flies the held-out flights better.
#pragma once

#include <optional>
#include <set>
#include <vector>

#include "diagnosis/rollout/rollout.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Of the sets that have one effect in place of up to three of those that stand (alternatives.hpp), fitted anew, the one that surely predicts the
// held-out flights better half a second ahead; the session is linearised there. Nothing: none does, and the session is as it was. A set of
// groups that was `tried` is not tried again.
std::optional<Selection> flies_better(Session& session, const Selection& standing,
                                      const std::vector<Recording>& held_out, const std::set<int>& left_out,
                                      std::set<std::vector<int>>& tried);

// Errors half a second ahead with some effects over those with others: mean logarithm of the ratio, over its standard error between windows
// (negative: with `some` they are smaller). Forces are asked with the attitude as it was recorded as well. `own`: effects of the vehicle file.
double log_ratio_z(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                   const std::vector<EffectSpec>& some, const std::vector<EffectSpec>& others, int jobs);

}  // namespace gustlab::diagnosis
