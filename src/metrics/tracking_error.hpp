// How far a flight was from where it should have been (FORMATS.md §3).
#pragma once

#include <cstddef>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab {

// Of the norms of an error over a flight, m. NaN when there was no sample.
struct ErrorFigures {
  double rmse_m;  // sqrt(mean ‖e‖²)
  double mae_m;   // mean ‖e‖
  double p95_m;   // 95th percentile of ‖e‖, linear interpolation
  double max_m;   // max ‖e‖
};

struct TrackingFigures {
  std::size_t samples = 0;
  ErrorFigures planar;   // e = p_xy − p_ref,xy
  ErrorFigures spatial;  // e = p − p_ref
  double rmse_z_m;
};

// Collects errors during a flight, without allocating after construction up to `capacity` samples.
class TrackingError {
 public:
  // Samples before settle_s do not count.
  TrackingError(double settle_s, std::size_t capacity);

  void add(double time_s, const Vector3& position_W_m, const Vector3& reference_W_m) {
    if (time_s < settle_s_) return;
    const Vector3 error = position_W_m - reference_W_m;
    planar_m2_.push_back(error.head<2>().squaredNorm());
    vertical_m2_.push_back(error.z() * error.z());
  }
  TrackingFigures figures() const;

 private:
  double settle_s_;
  std::vector<double> planar_m2_, vertical_m2_;
};

}  // namespace gustlab
