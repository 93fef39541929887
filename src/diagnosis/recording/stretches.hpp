// A log that is too long to be diagnosed whole: which stretches of it say most, and each of them as a flight of its own.
#pragma once

#include <string>
#include <vector>

#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// Flight time that is taken of a log. At 500 Hz a diagnosis takes half a second of a processor and 13 MB for each second of flight, so
// these five minutes are some minutes and 4 GB. Flights in laboratories are shorter, and so are most batteries of small vehicles.
inline constexpr double most_flight_s = 300.0;
// As long as the flights that are usually diagnosed; ten of them are spread over the log.
inline constexpr double stretch_s = 30.0;

// Times of those stretches: the log is divided in ten parts of equal flight time, and of each the stretch is taken whose commands, motion
// and inertial data vary most (the largest product of variances), among those that fly throughout where there are any. Empty: the log
// lasts no longer than most_flight_s, or has neither attitude nor body rate (such logs are compared in hover), and all of it is read.
std::vector<TimeRange> telling_stretches(const std::string& csv_path);

// All of the log in parts, none with more rows, each what read_flight_log takes as `only`. One part where the log is shorter, or where its
// time does not rise (whoever reads it says so). Replaying so many rows of 43 columns needs 300 MB.
std::vector<std::vector<TimeRange>> parts_of(const std::string& csv_path, std::size_t most_rows = 150'000);

// The log as one flight, or its stretches; the path of a stretch ends in its times, as "a.csv (60 to 90 s)". Throws DataError.
std::vector<FlightLog> read_flights(const std::string& csv_path);
// Rows of a log between two times.
FlightLog part_of(const FlightLog& log, const TimeRange& range);
// Whether a flight of this name is the file, or a stretch of it; both without folders.
bool is_flight_of(const std::string& flight, const std::string& file);

}  // namespace gustlab::diagnosis
