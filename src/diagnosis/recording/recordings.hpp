// The logs of one diagnosis: read, checked, and sorted by what they are for.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/recording/flight_labels.hpp"
#include "diagnosis/result/diagnosis.hpp"
#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab::diagnosis {

struct Recordings {
  VehicleModel vehicle;
  std::vector<FlightLog> fit, holdout, reference;
  std::vector<FlightUse> set_aside;
  std::vector<Stretch> stretches;  // of logs that are too long
  Remarks remarks;
};

// Reads the logs and their vehicle; what cannot be read is set aside, and said. Throws DataError when no flight is left to fit,
// or when they are of two vehicles.
Recordings read_recordings(const std::vector<std::string>& fit, const std::vector<std::string>& holdout,
                           const std::vector<std::string>& reference, const std::optional<std::string>& vehicle);
// The same without what faults of the log make unusable. Where no flight was held out and there are several, the last is. Throws likewise.
Recordings check(Recordings recordings);
// Of one flight alone the last third is held out.
Recordings with_held_out_part(Recordings recordings);

// Whether any of these columns holds more than a hundred numbers.
bool is_recorded(const std::vector<FlightLog>& logs, std::initializer_list<const char*> any_of);
// Flights ready for the filter. Commands and rotor speeds of flight i are read offset_s[first + i] later.
std::vector<FlightData> prepare(const std::vector<FlightLog>& logs, const VehicleModel& vehicle,
                                const ReadingOptions& options, const std::vector<double>& offset_s = {},
                                std::size_t first = 0);

}  // namespace gustlab::diagnosis
