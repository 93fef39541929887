// what kind of trial is drawn, on which vehicle, in which room
#pragma once

#include "draw.hpp"
#include "plan.hpp"

namespace reality {

struct Setting {
  std::string kind;
  bool large = false;
  int noise = 1;
  std::vector<std::string> effects;  // of the catalogue
  std::string stranger;              // outside it
  bool needs(Need need) const;
};

Setting draw_setting(const Request& request, Rng& rng);

/// Known surroundings: what the effects need, and now and then some that nothing needs, so that they tell nothing.
Surroundings draw_surroundings(const Setting& setting, Rng& rng);

/// Small errors of the maker's numbers; `size` is their share of the reporting tolerances. Combinations that act alike
/// stay below the tolerance of one.
void scatter(Truth& truth, double size, Rng& rng);

}  // namespace reality
