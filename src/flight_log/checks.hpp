// Does the recorded attitude turn as the recorded body rate says?
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gustlab {

// Columns of a log; NaN: no sample.
struct AttitudeColumns {
  const std::vector<double>& time_s;
  const std::vector<double>* q[4];  // w, x, y, z
  const std::vector<double>* w[3];
};

struct Contradiction {
  std::size_t row = 0;     // where it shows first
  std::string suggestion;  // the convention under which they agree, or empty
};

// Integrates the body rate over a fifth of a second and compares the turn with the attitude's; std::nullopt when they
// agree, or when too little turns to tell.
std::optional<Contradiction> find_contradiction(const AttitudeColumns& columns);

}  // namespace gustlab
