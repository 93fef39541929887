// Where the vehicle should be: a pure function of time.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "gustlab/parameters.hpp"
#include "gustlab/types.hpp"

namespace gustlab {

class Trajectory : public Parameterized {
 public:
  // Called once after the parameters are read; throws ParameterError when they contradict each other.
  virtual void prepare() {}
  virtual Reference at(double time_s) const = 0;
  // Length of the manoeuvre; 0: no natural end, the experiment's duration decides.
  virtual double duration_s() const { return 0.0; }
  // Time of one lap from the start; of what ends, of the whole. 0: it has none.
  virtual double lap_s() const { return duration_s(); }
  // Where the vehicle starts: by default at rest on the reference, hovering.
  virtual Vector3 start_position_W_m() const { return at(0.0).position_W_m; }
};

struct TrajectoryRow {
  std::string_view name;
  std::string_view says;
  std::unique_ptr<Trajectory> (*make)();
};

std::span<const TrajectoryRow> trajectory_registry();
const TrajectoryRow* find_trajectory(std::string_view name);

}  // namespace gustlab
