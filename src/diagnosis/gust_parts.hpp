// What a disturbance is made of: a slow random part (Ornstein–Uhlenbeck) and a spectral line (DIAGNOSIS.md §5, gust).
#pragma once

#include <vector>

#include "diagnosis/session.hpp"

namespace gustlab::diagnosis {

// Forces per mass, m/s². Standard deviations of the slow part, horizontal per axis and vertical, and its correlation time; the
// amplitude of a horizontal sinusoid per axis (0: there is none), its angular frequency, and their standard errors.
struct GustParts {
  double horizontal_mps2 = 0.0, vertical_mps2 = 0.0, time_s = 0.0;
  double line_mps2 = 0.0, line_radps = 0.0, line_deviation_mps2 = 0.0, line_deviation_radps = 0.0;
};

// From the disturbance that the findings leave. Exponential through its autocovariance between a fifth of a second, where what
// is faster has died away, and a second; without one, what EM learned. A line is one that stands out of the periodogram
// beside it by chance in one of 10⁶ cases.
GustParts gust_parts(const Session& session, const std::vector<Smoothed>& left);

}  // namespace gustlab::diagnosis
