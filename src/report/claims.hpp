// The paper's claims, judged on our flights.
//
// pass: our flights show it with p < 0.05; fail: they show the opposite with p < 0.05; not significant otherwise. Flights of
// one trajectory are paired by their gust (Student's t on differences; scatter: Pitman & Morgan, Biometrika 31, 1939, that is
// the correlation of sums and differences), others are not (Welch). Nothing is corrected for the number of claims.
#pragma once

#include "report/reproduction.hpp"

namespace gustlab {

std::vector<JudgedClaim> judge_claims(const Published& published, const std::vector<OurTable>& tables,
                                      const std::vector<ReproducedCell>& cells);
// The runs of a cell that count, by replicate: as many as were published, or all.
std::vector<ResultRow> counted_runs(const Published& published, const OurTable& table, std::string_view trajectory,
                                    std::string_view controller);
// A metric of runs, m.
std::vector<double> metric_of(const std::vector<ResultRow>& rows, std::size_t metric);

}  // namespace gustlab
