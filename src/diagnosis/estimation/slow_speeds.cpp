#include "diagnosis/estimation/slow_speeds.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/model/speed_comparison.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr std::size_t slow_rows = 5;

// sums over changes from one mean to the next: of measured speeds, of predicted ones, and of both
struct Changes {
  double measured = 0.0, predicted = 0.0, both = 0.0, rows = 0.0;
  void add(double of_measured, double of_predicted) {
    measured += of_measured * of_measured;
    predicted += of_predicted * of_predicted;
    both += of_measured * of_predicted;
  }
  // what predicted speeds leave, whatever the rotors' map
  double left() const { return measured - both * both / std::max(predicted, 1e-300); }
};

// Adds the changes of one segment's means over `width` rows, with predictions `later` rows earlier (at most one).
void add_segment(const LinearFlight& flight, std::size_t begin, std::size_t end, std::size_t rotor, std::size_t width,
                 double later, Changes& sum) {
  const auto predicted = [&](std::size_t k) {
    return (1.0 - later) * flight.predicted[k][rotor] + later * flight.predicted[k - 1][rotor];
  };
  const auto change = [&](std::size_t k, const auto& speed) {
    double difference = 0.0;
    for (std::size_t i = 0; i < width; ++i) difference += speed(k + width + i) - speed(k + i);
    return difference / static_cast<double>(width);
  };
  // `faster` is what was measured less what is predicted
  const auto measured = [&](std::size_t k) { return flight.predicted[k][rotor] + flight.faster[k][rotor]; };
  for (std::size_t k = begin + 1; k + 2 * width <= end; ++k) {
    sum.add(change(k, measured), change(k, predicted));
    if (rotor == 0) sum.rows += 1.0;
  }
}

Changes changes_of(const std::vector<FlightData>& flights, const std::vector<LinearFlight>& compared, std::size_t width,
                   double later) {
  Changes sum;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const std::size_t rows = compared[f].predicted.size();
    for (std::size_t begin = 0, end = 0; begin < rows; begin = end) {
      for (end = begin + 1; end < rows && !flights[f].samples[end].starts_segment;) ++end;
      for (std::size_t i = 0; i < static_cast<std::size_t>(flights[f].vehicle.rotor_count); ++i)
        add_segment(compared[f], begin, end, i, width, later, sum);
    }
  }
  return sum;
}

std::vector<LinearFlight> compared_at(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                      const Eigen::VectorXd& value) {
  std::vector<LinearFlight> compared(flights.size());
  for (std::size_t f = 0; f < flights.size(); ++f)
    compare_speeds_again(flights[f], static_cast<int>(f), catalogue, value, compared[f]);
  return compared;
}

}  // namespace

std::optional<double> latency_of_slow_speeds(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                             const Eigen::VectorXd& found, const Eigen::VectorXd& without) {
  const std::vector<LinearFlight> late = compared_at(flights, catalogue, found);
  const Changes from_row_to_row = changes_of(flights, late, 1, 0.0);
  if (!(from_row_to_row.left() > decisions::most_speed_left * from_row_to_row.measured)) return std::nullopt;
  const std::vector<LinearFlight> prompt = compared_at(flights, catalogue, without);
  double least = changes_of(flights, prompt, slow_rows, 0.0).left();
  for (const double later : {0.5, 1.0}) least = std::min(least, changes_of(flights, prompt, slow_rows, later).left());
  const Changes with = changes_of(flights, late, slow_rows, 0.0);
  return with.rows / static_cast<double>(slow_rows) * std::log(least / std::max(with.left(), 1e-300));
}

}  // namespace gustlab::diagnosis
