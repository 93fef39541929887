// The table of decisions: thresholds that decide a name, an alarm or a verdict. Per entry: the statistic, what the value was derived from
// or measured on, and what it costs. "No derivation" means that the value was chosen and not measured. Thresholds that have not moved
// here yet stand at the top of the file that uses them.
#pragma once

namespace gustlab::diagnosis::decisions {

// Length of a block, s: of Gram matrices, regimes, dependence, plots of residuals and hover balances. Some correlation times of a calm
// room's air (0.2 s), so that blocks hardly depend on each other. Costs: what changes within a block is one value.
inline constexpr double block_s = 0.5;

// A line of a gust. Statistic: probability by chance of the periodogram's peak. Derived: one false line in 10⁶ flights with none. Costs:
// fainter lines are not named.
inline constexpr double surely_a_line = 1e-6;
// A constant force beside a gust. Statistic: probability that it is more than the mean of the gust over a flight. Derived: one false
// force in a thousand flights.
inline constexpr double surely_no_mean = 0.999;
// Dependence of a disturbance on the state. Statistic: standard deviations above the same series moved along its flight. No derivation.
inline constexpr double surely_dependent = 4.9;

}  // namespace gustlab::diagnosis::decisions
