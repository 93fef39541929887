// one sealed trial: what is concealed, the flights, and apart from them the answer
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "flight.hpp"

namespace reality {

struct Request {
  std::uint64_t seed = 0;
  std::string kind = "mixed";         // clean | scatter | single | pair | outside | mixed
  std::optional<std::string> effect;  // forces kind single
  std::optional<double> factor;       // strength over the detection limit
  std::optional<bool> large;
  std::optional<int> noise;
  std::optional<double> roughness;  // of the air, over the quiet room; without it the noise level's
  AirKind air = AirKind::steady;
};

struct Trial {
  Nominal vehicle;
  Columns columns;
  Surroundings surroundings;
  std::vector<Flight> flight;  // three to fit, one held out
  nlohmann::ordered_json answer;
};

constexpr int kFitFlights = 3;

/// Draws trial `index`; the result depends on nothing but the request and the index. A vehicle that flies none of its
/// paths is drawn again with the same thing concealed; the answer's `redraws` says how often.
Trial draw_trial(const Request& request, std::uint64_t index);

}  // namespace reality
