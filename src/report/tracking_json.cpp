#include "report/tracking_json.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "flight_log/columns.hpp"
#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

TrackingOfLog tracking_of(const std::string& csv_path, double settle_s) {
  TrackingError error(settle_s, 0);
  std::optional<double> first_s;
  std::vector<LogRepair> repairs;
  read_flight_log_in_parts(csv_path, [&](const FlightLog& log) {
    throw_if_interrupted();
    repairs = log.repairs;
    std::array<const std::vector<double>*, 6> columns;
    constexpr std::array<const char*, 6> names{"px", "py", "pz", "rpx", "rpy", "rpz"};
    for (std::size_t i = 0; i < names.size(); ++i) {
      columns[i] = log.find(names[i]);
      if (columns[i] != nullptr) continue;
      std::vector<std::string> there;
      for (const LogColumn& column : log.columns) there.push_back(column.name);
      const std::string near = suggest_column(names[i], there);
      throw DataError(worded(fmt::format("{}:1:1: column \"{}\" is missing", log.path, names[i]),
                             "a tracking error needs position and reference", near));
    }
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const auto at = [&](std::size_t i) { return (*columns[i])[row]; };
      if (!first_s) first_s = log.time_s[row];
      const Vector3 position_W_m(at(0), at(1), at(2)), reference_W_m(at(3), at(4), at(5));
      if (position_W_m.allFinite() && reference_W_m.allFinite())
        error.add(log.time_s[row] - *first_s, position_W_m, reference_W_m);
    }
  });
  const TrackingFigures figures = error.figures();
  if (figures.samples == 0)
    throw DataError(fmt::format("{}: no sample with position and reference from {} s on", csv_path, settle_s));
  return {figures, std::move(repairs)};
}

nlohmann::ordered_json to_json(const TrackingFigures& figures) {
  const auto norms = [](const ErrorFigures& e) {
    return nlohmann::ordered_json{{"rmse_m", e.rmse_m}, {"mae_m", e.mae_m}, {"p95_m", e.p95_m}, {"max_m", e.max_m}};
  };
  return {{"samples", figures.samples},
          {"planar", norms(figures.planar)},
          {"spatial", norms(figures.spatial)},
          {"rmse_z_m", figures.rmse_z_m}};
}

}  // namespace gustlab
