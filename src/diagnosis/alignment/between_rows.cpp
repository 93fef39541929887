#include "diagnosis/alignment/between_rows.hpp"

#include <cmath>

#include "diagnosis/model/command_innovation.hpp"

namespace gustlab::diagnosis {

namespace {

// Sums over the rows of a flight: what turns further times what the rates say [rad²], its square, and the square of what the rates say.
struct Sums {
  double further = 0.0, scatter = 0.0, squared = 0.0;
};

Sums sums_of(FlightData flight) {
  // each until the next comes, as they are on their rows; measured speeds of a row may be those before its commands
  flight.commands = {flight.commands.time_s(), flight.commands.speed_radps(), false};
  flight.measured_speed = flight.jumping_speed = {}, flight.estimated = {};
  const std::vector<Eigen::Vector4d> commanded = rotor_acceleration(flight);
  const auto size = static_cast<Eigen::Index>(flight.samples.size());
  Eigen::Matrix3Xd excess(3, size), turn(3, size);
  Eigen::RowVectorXd interval_s(size);
  Eigen::Index count = 0;
  for (std::size_t k = 0; k + 1 < flight.samples.size(); ++k) {
    const Sample &now = flight.samples[k], &next = flight.samples[k + 1];
    if (next.starts_segment || !(now.channels & has_rate) || !(next.channels & has_rate)) continue;
    const double T = next.time_s - now.time_s;
    excess.col(count) = commanded[k].head<3>() - (next.body_rate_B_radps - now.body_rate_B_radps) / T;
    turn.col(count) = 0.5 * T * (now.body_rate_B_radps + next.body_rate_B_radps);
    interval_s[count++] = T;
  }
  if (count == 0) return {};
  const Vector3 trim = excess.leftCols(count).rowwise().mean();
  Sums sums;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double further = (excess.col(i) - trim).dot(turn.col(i)) * interval_s[i] * interval_s[i] / 6.0;
    sums.further += further, sums.scatter += further * further;
    sums.squared += turn.col(i).squaredNorm();
  }
  return sums;
}

}  // namespace

TurnBetweenRows turn_between_rows(const std::vector<FlightData>& flights) {
  Sums all;
  for (const FlightData& flight : flights) {
    if (flight.collective_only || flight.commands.empty()) continue;
    const Sums own = sums_of(flight);
    all.further += own.further, all.scatter += own.scatter, all.squared += own.squared;
  }
  if (all.squared == 0.0) return {};
  return {all.further / all.squared, std::sqrt(all.scatter) / all.squared};
}

}  // namespace gustlab::diagnosis
