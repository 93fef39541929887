#include "diagnosis/alignment/between_rows.hpp"

#include <cmath>

#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/row_acceleration.hpp"

namespace gustlab::diagnosis {

namespace {

// Sums over the rows of a flight: what turns further times what the rates say [rad²], its square, and the square of what the rates say.
struct Sums {
  double further = 0.0, scatter = 0.0, squared = 0.0;
};

bool has_each_command(const FlightData& flight) { return !flight.collective_only && !flight.commands.empty(); }

Sums sums_of(const FlightData& flight) {
  const std::vector<Vector3> turns = further_turns(flight);
  Sums sums;
  for (std::size_t k = 0; k + 1 < flight.samples.size(); ++k) {
    const Sample &now = flight.samples[k], &next = flight.samples[k + 1];
    if (!has_rates(now, next)) continue;
    const Vector3 turn = 0.5 * (next.time_s - now.time_s) * (now.body_rate_B_radps + next.body_rate_B_radps);
    const double further = turns[k].dot(turn);
    sums.further += further, sums.scatter += further * further;
    sums.squared += turn.squaredNorm();
  }
  return sums;
}

}  // namespace

std::vector<Vector3> further_turns(FlightData flight) {
  std::vector<Vector3> turns(flight.samples.size(), Vector3::Zero());
  if (!has_each_command(flight)) return turns;
  // each until the next comes, as they are on their rows; measured speeds of a row may be those before its commands
  flight.commands = {flight.commands.time_s(), flight.commands.speed_radps(), false};
  flight.measured_speed = flight.jumping_speed = {}, flight.estimated = {};
  const std::vector<Eigen::Vector4d> commanded = rotor_acceleration(flight);
  Vector3 trim = Vector3::Zero();
  double rows = 0.0;
  const auto for_rows = [&flight](const auto& visit) {
    for (std::size_t k = 0; k + 1 < flight.samples.size(); ++k)
      if (has_rates(flight.samples[k], flight.samples[k + 1])) visit(k, flight.samples[k], flight.samples[k + 1]);
  };
  for_rows([&](std::size_t k, const Sample& now, const Sample& next) {
    turns[k] = commanded[k].head<3>() - (next.body_rate_B_radps - now.body_rate_B_radps) / (next.time_s - now.time_s);
    trim += turns[k], rows += 1.0;
  });
  for_rows([&](std::size_t k, const Sample& now, const Sample& next) {
    turns[k] = (turns[k] - trim / rows) * std::pow(next.time_s - now.time_s, 2) / 6.0;
  });
  return turns;
}

TurnBetweenRows turn_between_rows(const std::vector<FlightData>& flights) {
  Sums all;
  for (const FlightData& flight : flights) {
    if (!has_each_command(flight)) continue;
    const Sums own = sums_of(flight);
    all.further += own.further, all.scatter += own.scatter, all.squared += own.squared;
  }
  if (all.squared == 0.0) return {};
  return {all.further / all.squared, std::sqrt(all.scatter) / all.squared};
}

}  // namespace gustlab::diagnosis
