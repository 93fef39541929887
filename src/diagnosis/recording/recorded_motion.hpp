// The states of a recording as they were written, and a missing one as it is estimated from the samples before it.
#pragma once

#include <algorithm>
#include <vector>

#include "gustlab/flight_log.hpp"
#include "gustlab/types.hpp"

namespace gustlab::diagnosis {

// Of quantities with rates or rows of their own: the rows of the slowest, with all else between its neighbours. A log whose rows
// all hold everything as it is.
FlightLog with_shared_rows(const FlightLog& log);

class RecordedMotion {
 public:
  // Throws DataError when the log has no attitude.
  explicit RecordedMotion(const FlightLog& log);

  bool has_position() const { return !position_.empty(); }
  bool has_velocity() const { return !velocity_.empty(); }
  bool has_body_rate() const { return !rate_.empty(); }

  std::size_t rows() const { return time_s_.size(); }
  double time_s(std::size_t row) const { return time_s_[row] - time_s_.front(); }
  // median interval
  double sample_s() const { return sample_s_; }
  // Whether row and row + 1 belong together: an open-loop rollout needs no sample between its ends, and commands hold through a short
  // gap. And whether all that the log has is there in a row.
  bool follows(std::size_t row) const {
    return time_s_[row + 1] - time_s_[row] <= std::max(shortest_gap_s, 1.6 * sample_s_);
  }
  bool complete(std::size_t row) const { return complete_[row]; }
  // Whether the state at a row is recorded, or can be estimated from the samples before it about as well as at other rows.
  bool can_start(std::size_t row) const;
  // first row of the unbroken stretch that a row belongs to
  std::size_t stretch(std::size_t row) const { return stretch_[row]; }
  // row nearest to a time
  std::size_t nearest(double time_s) const;

  Vector3 position_W_m(std::size_t row) const { return has_position() ? position_[row] : Vector3::Zero(); }
  // where the log has none, from positions (attitudes) up to the row
  Vector3 velocity_W_mps(std::size_t row) const;
  Quaternion attitude_WB(std::size_t row) const { return attitude_[row]; }
  Vector3 body_rate_B_radps(std::size_t row) const;
  // interpolated
  Vector3 body_rate_at(double time_s) const;
  Quaternion attitude_at(double time_s) const;

  // standard deviations of white noise per axis: m, m/s, rad, rad/s; for a missing channel that of its estimate
  std::array<double, 4> noise() const { return noise_; }

 private:
  static constexpr double shortest_gap_s = 0.1;
  struct Slope {
    Vector3 value = Vector3::Zero();
    double noise_gain = 0.0;  // deviation of the slope per deviation of a sample
  };
  template <class Value>
  Slope slope(std::size_t row, Value value) const;

  std::vector<double> time_s_;
  std::vector<Vector3> position_, velocity_, rate_;
  std::vector<Quaternion> attitude_;
  std::vector<bool> complete_;
  std::vector<double> noise_gain_;  // of the slope at a row; empty: nothing is estimated by one
  std::vector<std::size_t> stretch_;
  double sample_s_ = 0.0, usual_gain_ = 0.0;
  std::array<double, 4> noise_{};
};

}  // namespace gustlab::diagnosis
