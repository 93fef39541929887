#include "metrics/tracking_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "util/quantiles.hpp"

namespace gustlab {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

double root_mean(const std::vector<double>& squares) {
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return squares.empty() ? nothing : std::sqrt(sum / static_cast<double>(squares.size()));
}

ErrorFigures error_figures(std::vector<double> squares) {
  if (squares.empty()) return {nothing, nothing, nothing, nothing};
  ErrorFigures figures;
  figures.rmse_m = root_mean(squares);
  std::vector<double>& norms = squares;
  double sum = 0.0;
  for (double& norm : norms) sum += norm = std::sqrt(norm);
  figures.mae_m = sum / static_cast<double>(norms.size());
  figures.max_m = *std::max_element(norms.begin(), norms.end());
  figures.p95_m = quantile(std::move(norms), 0.95);
  return figures;
}

}  // namespace

// a sample time is a multiple of the step, and rounding must not move it out of the window
TrackingError::TrackingError(double settle_s, std::size_t capacity) : settle_s_(settle_s - 1e-9) {
  planar_m2_.reserve(capacity);
  vertical_m2_.reserve(capacity);
}

TrackingFigures TrackingError::figures() const {
  TrackingFigures figures;
  figures.samples = planar_m2_.size();
  figures.planar = error_figures(planar_m2_);
  std::vector<double> spatial_m2(planar_m2_.size());
  for (std::size_t i = 0; i < spatial_m2.size(); ++i) spatial_m2[i] = planar_m2_[i] + vertical_m2_[i];
  figures.spatial = error_figures(std::move(spatial_m2));
  figures.rmse_z_m = root_mean(vertical_m2_);
  return figures;
}

}  // namespace gustlab
