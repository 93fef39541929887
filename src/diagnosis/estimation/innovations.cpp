#include "diagnosis/estimation/innovations.hpp"

#include <cmath>
#include <limits>
#include <numeric>

namespace gustlab::diagnosis {

std::vector<std::array<double, row_count>> lag_correlation(const std::vector<Whitened>& flights, std::size_t lags) {
  constexpr std::size_t fewest = 100;
  std::vector<std::array<double, row_count>> sums(lags + 1);
  std::array<bool, row_count> enough{};
  for (auto& of_lag : sums) of_lag.fill(0.0);
  for (const Whitened& w : flights) {
    std::array<std::vector<double>, row_count> z;
    for (std::size_t i = 0; i < w.time_s.size(); ++i)
      if (w.warm[i])
        z[static_cast<std::size_t>(w.channel[i])].push_back(w.rows(static_cast<Eigen::Index>(i), w.rows.cols() - 1));
    for (std::size_t c = 0; c < row_count; ++c) {
      if (z[c].size() < fewest) continue;
      enough[c] = true;
      const double mean = std::accumulate(z[c].begin(), z[c].end(), 0.0) / static_cast<double>(z[c].size());
      for (std::size_t lag = 0; lag <= lags; ++lag)
        for (std::size_t i = lag; i < z[c].size(); ++i) sums[lag][c] += (z[c][i] - mean) * (z[c][i - lag] - mean);
    }
  }
  for (std::size_t lag = 1; lag <= lags; ++lag)
    for (std::size_t c = 0; c < row_count; ++c)
      sums[lag][c] = enough[c] ? sums[lag][c] / sums[0][c] : std::numeric_limits<double>::quiet_NaN();
  sums.erase(sums.begin());
  return sums;
}

}  // namespace gustlab::diagnosis
