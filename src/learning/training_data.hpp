// Flights under several wind conditions, flown for training and reduced to what the network sees and should explain.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "learning/meta_loss.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

// One variant of the experiment: every sample of all its flights.
struct Condition {
  std::string name;
  bool held_out = false;
  Samples samples;  // inputs in units, as control/daiml_input.hpp has them
};

// Flies every run of every variant on at most `jobs` threads. A sample's residual is m a + m g − thrust per mass, from the
// flight log alone (identification/force_residual: derivative of the velocity, a running mean over 5 rows, 1 s cut off at
// both ends). Throws ConfigError when a flight does not complete, or fewer than two conditions are there to train on.
std::vector<Condition> collect(std::span<const Experiment> variants, int jobs);

}  // namespace gustlab
