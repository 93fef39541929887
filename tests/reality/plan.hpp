// what a trial conceals, before its strength is known
#pragma once

#include "catalogue.hpp"

namespace reality {

/// An effect, its direction in natural sizes (norm about one) and the numbers that do not scale (rotor, length, ...).
struct Plan {
  std::string effect;
  std::vector<std::map<std::string, double>> direction;  // one, or one per flight for values per flight
  Values fixed;
};

/// Draws direction and fixed numbers for `flights` flights.
Plan draw_plan(const std::string& effect, const Nominal& nominal, bool voltage_logged, std::size_t flights, Rng& rng);

/// Total values of `plan` on one flight at this strength (in natural sizes).
Values values_at(const Plan& plan, const Nominal& nominal, double strength, std::size_t flight);

/// Largest strength that can still be built and flown.
double most_strength(const Plan& plan, const Nominal& nominal);

/// True for two effects that an exact alias or the static part of one makes alike: they are not drawn together.
bool alike(const std::string& a, const std::string& b);

}  // namespace reality
