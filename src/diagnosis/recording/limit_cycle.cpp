#include "diagnosis/recording/limit_cycle.hpp"

#include <algorithm>

namespace gustlab::diagnosis {

double share_at_both_limits(const std::vector<FlightData>& flights) {
  constexpr double cut_off = 1e-6;  // of the range
  double rows = 0.0, high = 0.0, low = 0.0;
  for (const FlightData& flight : flights) {
    if (flight.commands.empty() || flight.vehicle.rotor_count < 2) continue;
    const auto range = [&flight](const RotorArray& row) {
      return std::minmax_element(row.begin(), row.begin() + flight.vehicle.rotor_count);
    };
    const std::vector<RotorArray>& commands = flight.commands.speed_radps();
    double least = *range(commands.front()).first, most = *range(commands.front()).second;
    for (const RotorArray& row : commands)
      least = std::min(least, *range(row).first), most = std::max(most, *range(row).second);
    if (!(most > least)) continue;
    for (const RotorArray& row : commands) {
      low += *range(row).first <= least + cut_off * (most - least) ? 1.0 : 0.0;
      high += *range(row).second >= most - cut_off * (most - least) ? 1.0 : 0.0;
    }
    rows += static_cast<double>(commands.size());
  }
  return rows > 0.0 ? std::min(high, low) / rows : 0.0;
}

}  // namespace gustlab::diagnosis
