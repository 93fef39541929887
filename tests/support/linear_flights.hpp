// A noise model and transitions for tests of the filter, of no flight in particular.
#pragma once

#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/model/linear_flight.hpp"

namespace gustlab::test {

inline diagnosis::NoiseModel some_noise() {
  diagnosis::NoiseModel noise;
  noise.variance = {0.04, 0.09, 0.5, 0.7};
  noise.time_s = {0.2, 0.3, 0.1, 0.05};
  noise.white = {1e-4, 2e-4, 3e-3, 4e-3};
  noise.measurement = {1e-6, 2e-5, 3e-4, 0.01};
  return noise;
}

// in which every state drives others
inline diagnosis::Matrix12 some_transition(double dt) {
  diagnosis::Matrix12 F = diagnosis::Matrix12::Identity();
  for (int i = 0; i < 3; ++i) {
    F(i, 3 + i) = F(6 + i, 9 + i) = dt;
    for (int j = 0; j < 3; ++j) F(3 + i, 6 + j) = dt * (1.0 + i - 2.0 * j), F(9 + i, 3 + j) = 0.3 * dt * (i + j + 1);
  }
  return F;
}

}  // namespace gustlab::test
