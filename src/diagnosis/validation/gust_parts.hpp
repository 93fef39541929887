// What a disturbance is made of: a slow random part (Ornstein–Uhlenbeck) and a spectral line (DIAGNOSIS.md §5, gust).
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Forces per mass, m/s². Standard deviations of the slow part, horizontal per axis (0: there is none) and vertical, and its correlation time; the
// amplitude of a horizontal sinusoid per axis (0: there is none), its angular frequency, and their standard errors.
struct GustParts {
  double slow_mps2 = 0.0;  // of the horizontal disturbance, what still is there half a second later
  double horizontal_mps2 = 0.0, vertical_mps2 = 0.0, time_s = 0.0;
  double line_mps2 = 0.0, line_radps = 0.0, line_deviation_mps2 = 0.0, line_deviation_radps = 0.0;
  // the vehicle accelerates more than twice as much at this frequency, or it is a harmonic of the figure that most flights repeat
  bool line_of_motion = false;
};

// From the disturbance that the findings leave. Exponential through its autocovariance between a fifth of a second, where what
// is faster has died away, and a second; without one, what EM learned. A line is one that stands out of the periodogram
// beside it by chance in one of 10⁶ cases.
GustParts gust_parts(const Session& session, const std::vector<Smoothed>& left);

// Findings of a constant force per flight that are no larger than the mean that such a gust leaves over a flight: groups.
std::vector<int> means_of_gust(const Session& session, const Selection& selection, const GustParts& gust);

}  // namespace gustlab::diagnosis
