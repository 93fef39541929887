#include "diagnosis/shooting.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/propagation.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int rows_per_horizon = error_size;
constexpr auto window_rows = static_cast<Eigen::Index>(shooting_horizon_s.size()) * rows_per_horizon;

struct Window {
  std::size_t start;
  std::array<std::size_t, shooting_horizon_s.size()> at;
};

std::vector<Window> windows_of(const FlightData& flight) {
  std::vector<Window> windows;
  const auto length = static_cast<std::size_t>(std::lround(shooting_horizon_s.back() / flight.sample_s));
  for (std::size_t k = length; k + 2 * length < flight.samples.size(); k += length) {
    bool whole = true;
    for (std::size_t j = k + 1; j <= k + length; ++j) whole = whole && !flight.samples[j].starts_segment && !flight.samples[j].saturated;
    if (!whole) continue;
    Window w{k, {}};
    for (std::size_t h = 0; h < w.at.size(); ++h)
      w.at[h] = k + std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(shooting_horizon_s[h] / flight.sample_s)));
    windows.push_back(w);
  }
  return windows;
}

// measured ⊟ predicted at every horizon of every window
Eigen::MatrixXd residuals(const FlightData& flight, const ForceModel& forces, const RotorHistory& rotors,
                          const std::vector<Window>& windows) {
  Eigen::MatrixXd out(window_rows, static_cast<Eigen::Index>(windows.size()));
  const auto count = static_cast<std::size_t>(rotors.substeps);
  const Vector3 arm = forces.vehicle().center_of_mass_B_m;
  Evaluator evaluate{forces, {}, {}};
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Point x = center_of_mass(flight.motion[windows[w].start], arm);
    std::size_t k = windows[w].start;
    for (std::size_t h = 0; h < windows[w].at.size(); ++h) {
      for (; k < windows[w].at[h]; ++k) {
        const Sample& sample = flight.samples[k];
        x = propagate(evaluate, x, sample.time_s - flight.start_s, flight.samples[k + 1].time_s - sample.time_s, sample.voltage_V,
                      rotors.substeps, &rotors.mean[k * count], &rotors.acceleration[k * count]);
      }
      out.block<rows_per_horizon, 1>(static_cast<Eigen::Index>(h) * rows_per_horizon, static_cast<Eigen::Index>(w)) =
          center_of_mass(flight.motion[k], arm).minus(x);
    }
  }
  return out;
}

}  // namespace

ShotFlight shoot(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                 const std::vector<int>& wanted) {
  ShotFlight shot;
  const std::vector<Window> windows = windows_of(flight);
  const ForceModel base = force_model(flight, catalogue, value, flight_index, -1);
  const RotorHistory rotors = rotor_history(flight, base);
  const Eigen::MatrixXd r0 = residuals(flight, base, rotors, windows);
  for (const int c : wanted) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (column.flight < 0 || column.flight == flight_index) shot.columns.push_back(c);
  }
  const auto width = static_cast<Eigen::Index>(shot.columns.size()) + 1;
  shot.window.assign(windows.size(), Eigen::MatrixXd::Zero(window_rows, width));
  for (std::size_t w = 0; w < windows.size(); ++w) {
    shot.time_s.push_back(flight.samples[windows[w].start].time_s);
    shot.window[w].col(width - 1) = r0.col(static_cast<Eigen::Index>(w));
  }
  for (Eigen::Index j = 0; j + 1 < width; ++j) {
    const int c = shot.columns[static_cast<std::size_t>(j)];
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    // sensor effects and histories are told by innovations, not by shooting
    if (column.group < 0) continue;
    const EffectRow& row = *catalogue.groups()[static_cast<std::size_t>(column.group)].row;
    if (row.place == Place::measurement || row.name == "slung_load" || row.name == "saturation" || row.name == "steady_wind") continue;
    Eigen::VectorXd moved = value;
    const double step = 1e-3 * column.natural;
    moved[c] += step;
    const ForceModel model = force_model(flight, catalogue, moved, flight_index, column.group);
    const Eigen::MatrixXd r = residuals(flight, model, row.place == Place::actuation ? rotor_history(flight, model) : rotors, windows);
    for (std::size_t w = 0; w < windows.size(); ++w)
      shot.window[w].col(j) = (r0.col(static_cast<Eigen::Index>(w)) - r.col(static_cast<Eigen::Index>(w))) * (column.natural / step);
  }
  return shot;
}

ShootingWeights shooting_weights(const std::vector<ShotFlight>& flights, const std::vector<int>& columns,
                                 const Eigen::VectorXd& coefficient) {
  // robust: median of the size of what is left
  std::vector<std::vector<double>> left(static_cast<std::size_t>(window_rows));
  for (const ShotFlight& flight : flights)
    for (const Eigen::MatrixXd& window : flight.window) {
      Eigen::VectorXd r = window.col(window.cols() - 1);
      for (std::size_t j = 0; j < flight.columns.size(); ++j)
        for (std::size_t i = 0; i < columns.size(); ++i)
          if (columns[i] == flight.columns[j]) r -= window.col(static_cast<Eigen::Index>(j)) * coefficient[static_cast<Eigen::Index>(i)];
      for (Eigen::Index row = 0; row < window_rows; ++row) left[static_cast<std::size_t>(row)].push_back(std::abs(r[row]));
    }
  ShootingWeights sd(window_rows);
  constexpr std::array<double, 4> least = {1e-4, 1e-3, 1e-3, 1e-2};
  for (Eigen::Index row = 0; row < window_rows; ++row) {
    auto& values = left[static_cast<std::size_t>(row)];
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    if (!values.empty()) std::nth_element(values.begin(), middle, values.end());
    sd[row] = std::max(values.empty() ? 1.0 : *middle / 0.6745, least[static_cast<std::size_t>(row % rows_per_horizon / 3)]);
  }
  return sd;
}

Grams shooting_grams(const std::vector<ShotFlight>& flights, const ShootingWeights& weights, int catalogue_size) {
  Grams grams;
  grams.columns = catalogue_size;
  const double share = 1.0 / static_cast<double>(shooting_horizon_s.size());
  for (std::size_t f = 0; f < flights.size(); ++f) {
    std::vector<int> at = flights[f].columns;
    at.push_back(catalogue_size);
    for (const Eigen::MatrixXd& window : flights[f].window) {
      Eigen::MatrixXd z = weights.cwiseInverse().asDiagonal() * window;
      // a window that the model loses altogether weighs no more than one that it loses clearly
      const double size = z.col(z.cols() - 1).norm() / std::sqrt(static_cast<double>(window_rows));
      if (size > 3.0) z *= std::sqrt(3.0 / size);
      const Eigen::MatrixXd local = share * (z.transpose() * z);
      Eigen::MatrixXd full = Eigen::MatrixXd::Zero(catalogue_size + 1, catalogue_size + 1);
      for (std::size_t i = 0; i < at.size(); ++i)
        for (std::size_t j = 0; j < at.size(); ++j)
          full(at[i], at[j]) = local(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      grams.block.push_back(std::move(full));
      grams.flight.push_back(static_cast<int>(f));
      grams.cluster.push_back(grams.clusters++);
      grams.rows += rows_per_horizon;
    }
  }
  return grams;
}

}  // namespace gustlab::diagnosis
