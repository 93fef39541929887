#include "diagnosis/model/speed_comparison.hpp"

#include "diagnosis/model/propagation.hpp"

namespace gustlab::diagnosis {

namespace {

// one of the two was written down twice
bool same_rows(const CommandRecord& a, const CommandRecord& b) {
  return a.time_s() == b.time_s() && a.speed_radps() == b.speed_radps();
}

// speed at every sample
std::vector<RotorArray> commanded(const FlightData& flight, const Catalogue& catalogue, const Eigen::VectorXd& value,
                                  int index, int also) {
  return commanded_history(flight, force_model(flight, catalogue, value, index, also)).at_sample;
}

// the switch of a lower speed limit that is suspected of a flight, or −1
int limit_column(const Catalogue& catalogue, const FlightData& flight) {
  const int g = catalogue.find(ColumnFrom::speed_limit);
  return g < 0 || flight.limit_speed_change.empty() ? -1 : catalogue.group(g).columns.front();
}

}  // namespace

std::vector<RotorArray> measured_beside_commands(const FlightData& flight) {
  if (flight.commands.empty() || flight.measured_speed.empty() || flight.collective_only) return {};
  return measured_history(flight).at_sample;
}

void compare_speeds_again(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                          const Eigen::VectorXd& value, LinearFlight& out) {
  out.predicted.clear(), out.faster.clear();
  if (flight.measured_at_sample.empty() || same_rows(flight.commands, flight.measured_speed)) return;
  out.predicted = commanded(flight, catalogue, value, flight_index, -1);
  if (const int c = limit_column(catalogue, flight); c >= 0)
    for (std::size_t k = 0; k < out.predicted.size(); ++k)
      for (std::size_t i = 0; i < max_rotors; ++i) out.predicted[k][i] += value[c] * flight.limit_speed_change[k][i];
  out.faster = flight.measured_at_sample;
  for (std::size_t k = 0; k < out.faster.size(); ++k)
    for (std::size_t i = 0; i < max_rotors; ++i) out.faster[k][i] -= out.predicted[k][i];
}

void compare_speeds(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                    const Eigen::VectorXd& value, LinearFlight& out) {
  compare_speeds_again(flight, flight_index, catalogue, value, out);
  out.predicted_by.assign(out.columns.size(), {});
  if (out.predicted.empty()) return;
  for (std::size_t j = 0; j < out.columns.size(); ++j) {
    const int c = out.columns[j];
    const Column& column = catalogue.column(c);
    if (column.group < 0) continue;
    const EffectRow& row = *catalogue.group(column.group).row;
    if (c == limit_column(catalogue, flight)) out.predicted_by[j] = flight.limit_speed_change;
    if (!row.on_command || row.is_history()) continue;
    Eigen::VectorXd to = value;
    const double step = 1e-3 * column.natural;
    to[c] += step;
    std::vector<RotorArray> by = commanded(flight, catalogue, to, flight_index, column.group);
    if (const int limit = limit_column(catalogue, flight); limit >= 0 && value[limit] != 0.0)
      for (std::size_t k = 0; k < by.size(); ++k)
        for (std::size_t i = 0; i < max_rotors; ++i) by[k][i] += value[limit] * flight.limit_speed_change[k][i];
    bool acts = false;
    for (std::size_t k = 0; k < by.size(); ++k)
      for (std::size_t i = 0; i < max_rotors; ++i) {
        by[k][i] = (by[k][i] - out.predicted[k][i]) * column.natural / step;
        acts = acts || by[k][i] != 0.0;
      }
    if (acts) out.predicted_by[j] = std::move(by);
  }
}

std::vector<std::vector<RotorArray>> limit_speed_changes(const FlightData& flight, int flight_index,
                                                         const Catalogue& catalogue, const Eigen::VectorXd& value,
                                                         const std::vector<double>& limits_radps) {
  const std::vector<RotorArray> free = commanded(flight, catalogue, value, flight_index, -1);
  FlightData limited = flight;
  std::vector<std::vector<RotorArray>> changes;
  for (const double limit_radps : limits_radps) {
    limited.vehicle.max_speed_radps = limit_radps;
    std::vector<RotorArray>& change = changes.emplace_back(commanded(limited, catalogue, value, flight_index, -1));
    for (std::size_t k = 0; k < change.size(); ++k)
      for (std::size_t i = 0; i < max_rotors; ++i) change[k][i] -= free[k][i];
  }
  return changes;
}

}  // namespace gustlab::diagnosis
