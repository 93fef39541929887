// Kinds of concealed trials: `conceal` writes them into the answers, `score` counts by them.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace gustlab {

// scatter: small errors of a maker; outside: physics that no effect means; nothing: another word for clean
inline const std::vector<std::string>& trial_kinds() {
  static const std::vector<std::string> all{"clean", "scatter", "single", "pair", "many", "outside", "nothing"};
  return all;
}

// of a trial that does not say it
inline std::string trial_kind_of(std::size_t effects) {
  constexpr std::array<const char*, 3> kinds{"clean", "single", "pair"};
  return effects < kinds.size() ? kinds[effects] : "many";
}

}  // namespace gustlab
