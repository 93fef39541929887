#include "diagnosis/estimation/innovation_filter.hpp"

#include <cmath>

#include "diagnosis/estimation/direct_forces.hpp"
#include "diagnosis/estimation/filter_pass.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr std::size_t cold = 20;  // samples after a gap in which the filter forgets its prior

using RowMap = Eigen::Map<Eigen::RowVectorXd>;

// Passes along a flight; `row(k, r, variance, z, warm)` sees every innovation: z[0] is y's, z[1] the first column's.
template <int size, class Row>
void pass_along(const LinearFlight& flight, const NoiseModel& noise, const FurtherColumns& further, const Row& row) {
  const std::size_t n = flight.size();
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const Eigen::Index more = further.size;
  FilterPass<size> filter(flight, noise, own + more);
  std::size_t since_start = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (flight.starts[k]) filter.start(k), since_start = 0;
    const SpatialAccelerations* moves = more > 0 ? &further.at(k) : nullptr;
    filter.measure(k, [&](int r, double* e) {
      double* columns = e + filter.first_column;
      if (own > 0 && r >= first_force_row) RowMap(columns, own) += flight.felt_by[k].row(r - first_force_row);
      for (std::size_t i = 0; i < flight.sensed.size() && r < first_force_row; ++i)
        columns[flight.sensed[i]] += flight.sensed_by[k](r, static_cast<Eigen::Index>(i));
      if (more > 0 && r >= first_force_row)
        RowMap(columns + own, more) +=
            flight.R_WB[k].col(r - first_force_row).transpose() * moves->template topRows<3>();
    });
    for (Eigen::Index i = 0; i < filter.rows(); ++i)
      row(k, filter.row(i), filter.variance(i), &filter.innovations()(i, filter.y_at), since_start >= cold);
    ++since_start;
    if (k + 1 == n || flight.starts[k + 1]) continue;
    filter.advance(k);
    if (own > 0) flight.add_moved_by(flight.acceleration_by[k], k, filter.state().middleCols(filter.first_column, own));
    if (more > 0) flight.add_moved_by(*moves, k, filter.state().middleCols(filter.first_column + own, more));
  }
}

template <int size>
Whitened whiten_with(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                     const FurtherColumns& further) {
  Eigen::Index rows = 0, columns = static_cast<Eigen::Index>(flight.columns.size()) + further.size;
  for (const auto& measured : flight.measured) rows += measured.count();
  Whitened out;
  out.rows.resize(rows, columns + 1);
  rows = 0;
  pass_along<size>(flight, noise, further, [&](std::size_t k, int r, double variance, const double* z, bool warm) {
    out.rows.row(rows).head(columns) = Eigen::Map<const Eigen::RowVectorXd>(z + 1, columns);
    out.rows(rows++, columns) = *z;
    out.minus_two_log_likelihood += std::log(variance) + *z * *z;
    out.time_s.push_back(data.samples[k].time_s);
    out.channel.push_back(r);
    out.warm.push_back(warm);
  });
  return out;
}

template <int size>
void add_with(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise, GramBlocks& blocks,
              const FurtherColumns& further) {
  pass_along<size>(flight, noise, further, [&](std::size_t k, int, double, const double* z, bool warm) {
    blocks.add(data.samples[k].time_s, warm, z + 1, *z);
  });
}

template <int size>
double misfit_with(const LinearFlight& flight, const NoiseModel& noise) {
  double sum = 0.0;
  pass_along<size>(flight, noise, {}, [&](std::size_t, int, double variance, const double* z, bool) {
    sum += std::log(variance) + *z * *z;
  });
  return sum;
}

}  // namespace

Whitened whiten(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                const FurtherColumns& further) {
  if (flight.forces_alone) return whiten_forces(data, flight, noise, further);
  return noise.errors_last() ? whiten_with<state_size + row_count>(data, flight, noise, further)
                             : whiten_with<state_size>(data, flight, noise, further);
}

void add_innovations(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise, GramBlocks& blocks,
                     const FurtherColumns& further) {
  if (flight.forces_alone) return blocks.add(whiten_forces(data, flight, noise, further));
  noise.errors_last() ? add_with<state_size + row_count>(data, flight, noise, blocks, further)
                      : add_with<state_size>(data, flight, noise, blocks, further);
}

double misfit(const LinearFlight& flight, const NoiseModel& noise) {
  return noise.errors_last() ? misfit_with<state_size + row_count>(flight, noise)
                             : misfit_with<state_size>(flight, noise);
}

}  // namespace gustlab::diagnosis
