// Tracking errors of one flight, from a log and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "gustlab/flight_log.hpp"
#include "metrics/tracking_error.hpp"

namespace gustlab {

struct TrackingOfLog {
  TrackingFigures figures;
  std::vector<LogRepair> repairs;  // of the log
};

// Samples earlier than settle_s after the log's first, or without position or reference, do not count. Throws DataError
// when the log cannot be read, has no position or no reference, or no sample is left. The log is read in parts.
TrackingOfLog tracking_of(const std::string& csv_path, double settle_s);

// samples, planar and spatial {rmse_m, mae_m, p95_m, max_m}, rmse_z_m; null where there was no sample.
nlohmann::ordered_json to_json(const TrackingFigures& figures);

}  // namespace gustlab
