#include "diagnosis/estimation/latency_between_rows.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/propagation.hpp"
#include "diagnosis/model/row_acceleration.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double kept = 0.9;            // of a row, in the next one
constexpr double most_left = 0.25;      // of the variance: else something else turns the body
constexpr double most_off_rows = 0.25;  // of a row: inputs that begin between rows are on another clock
constexpr double exact = 1e-9;          // of the variance: integrators differ

// by how much a row of commands and speeds is off the nearest sample
double off_rows_s(const FlightData& flight) {
  const std::vector<double>& rows = flight.commands.time_s();
  const double at_s = flight.samples.front().time_s;
  return at_s - *std::ranges::min_element(rows, {}, [at_s](double row_s) { return std::abs(row_s - at_s); });
}

bool commands_may_move(const FlightData& flight) {
  return !flight.measured_at_sample.empty() && !flight.hold_known && !flight.read_slower &&
         flight.commands.time_s() == flight.measured_speed.time_s() &&
         std::abs(off_rows_s(flight)) < most_off_rows * flight.sample_s;
}

// `late`: how late rotors are; all else as in `found`
std::array<AccelerationLeft, 2> left_with(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                          const Eigen::VectorXd& found, const Eigen::VectorXd& late) {
  std::vector<std::vector<Eigen::Vector4d>> rotors;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    FlightData flight = flights[f];
    flight.delay_inputs(off_rows_s(flight));
    const auto model = [&](const Eigen::VectorXd& value) {
      return force_model(flight, catalogue, value, static_cast<int>(f), -1);
    };
    rotors.push_back(rotor_acceleration(flight, model(found), history_between_rows(flight, model(late))));
  }
  return acceleration_left(flights, rotors, kept);
}

}  // namespace

std::optional<double> latency_between_rows(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                           const Eigen::VectorXd& found, const Eigen::VectorXd& without) {
  if (!std::ranges::all_of(flights, commands_may_move)) return std::nullopt;
  const auto late = left_with(flights, catalogue, found, found), prompt = left_with(flights, catalogue, found, without);
  std::optional<double> likelier;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const AccelerationLeft &with = late[axis], &instead = prompt[axis];
    if (std::min(with.share, instead.share) > most_left) continue;
    likelier = likelier.value_or(0.0) + std::min(with.rows, instead.rows) *
                                            std::log(std::max(instead.share, exact) / std::max(with.share, exact));
  }
  return likelier;
}

}  // namespace gustlab::diagnosis
