#include "diagnosis/result/evidence.hpp"

#include <algorithm>

namespace gustlab::diagnosis {

double Evidence::robust_delta_chi2() const {
  return std::min(delta_chi2, delta_chi2_with_partner) /
         std::max({1.0, surrogates.movable ? surrogates.inflation : 1.0, clustered_inflation});
}

int Evidence::flights_for() const {
  return static_cast<int>(std::count_if(flights.begin(), flights.end(), [](const FlightShare& f) {
    return f.share > 0.5 && f.share > 2.0 * f.deviation;
  }));
}

int Evidence::flights_against() const {
  return static_cast<int>(std::count_if(flights.begin(), flights.end(), [](const FlightShare& f) {
    return f.share < 0.25 && f.share + 2.0 * f.deviation < 1.0;
  }));
}

}  // namespace gustlab::diagnosis
