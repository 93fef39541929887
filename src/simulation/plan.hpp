// The runs of an experiment by their number: each is made when it is asked for, so that a plan of any size takes no memory.
#pragma once

#include <vector>

#include "config/hash.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

// In the order trajectory, controller, replicate. The experiment is not kept.
class Plan {
 public:
  explicit Plan(const Experiment& experiment);
  std::size_t size() const { return cells_.size() * replicates_; }
  // `index` below size().
  RunSpec operator[](std::size_t index) const;
  // The index of the i-th run to fly: of every cell the first replicate, then of every cell the second, and so on. Cells take unlike
  // times, so a tenth of this order tells how long the rest takes.
  std::size_t in_turn(std::size_t i) const { return i % cells_.size() * replicates_ + i / cells_.size(); }

 private:
  std::vector<config::Hash> cells_;  // of each trajectory and, within it, each controller
  std::size_t controllers_, replicates_;
  std::int64_t first_replicate_;
};

}  // namespace gustlab
