// physics that no name of the catalogue means
#pragma once

#include <vector>

#include "truth.hpp"

namespace reality {

struct Stranger {
  std::string name;
  std::vector<std::string> channels;  // where a diagnosis may locate it
  Outside physics;
};

/// Names of all kinds, in the order they are drawn from.
const std::vector<std::string>& strangers();

/// Draws the numbers of one kind; `size` scales its strength (1: clearly visible in a wandering flight).
Stranger draw_stranger(const std::string& name, const Nominal& nominal, double size, Rng& rng);

}  // namespace reality
