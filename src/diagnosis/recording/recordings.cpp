#include "diagnosis/recording/recordings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "diagnosis/recording/attitude_check.hpp"
#include "diagnosis/recording/log_checks.hpp"
#include "diagnosis/recording/stretches.hpp"
#include "gustlab/errors.hpp"
#include "vehicle/gaps.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {

namespace {

void note_stretches(const std::string& file, const std::vector<FlightLog>& flights, Recordings& out) {
  for (const FlightLog& flight : flights)
    out.stretches.push_back({label_of(flight.path), file, flight.time_s.front(), flight.time_s.back()});
  out.remarks.notes.push_back(fmt::format(
      "{} lasts longer than {:g} s: of each of its {} parts the {:g} s that tell most are diagnosed, each as a "
      "flight of its own, and the rest is not",
      file, most_flight_s, flights.size(), stretch_s));
}

// a log that cannot be read is set aside, and said
std::vector<FlightLog> read_all(const std::vector<std::string>& paths, Recordings& out) {
  std::vector<FlightLog> logs;
  for (const std::string& path : paths) {
    try {
      std::vector<FlightLog> flights = read_flights(path);
      if (flights.size() > 1) note_stretches(label_of(path), flights, out);
      std::move(flights.begin(), flights.end(), std::back_inserter(logs));
    } catch (const DataError& error) {
      out.remarks.findings.push_back({label_of(path), "*", "inconsistent", 0.0, 0.0, error.what(), true, false});
      out.set_aside.push_back({label_of(path), "set_aside", 0.0, 0.0});
    }
  }
  return logs;
}

// faults come before any physics
void set_aside(std::vector<FlightLog>& logs, const std::vector<LogFinding>& copies, Recordings& out) {
  std::vector<bool> away(logs.size(), false);
  const auto note = [&](const std::vector<LogFinding>& findings, std::size_t i) {
    for (const LogFinding& finding : findings) {
      if (finding.file != label_of(logs[i].path)) continue;
      out.remarks.findings.push_back(finding);
      away[i] = away[i] || finding.sets_flight_aside;
    }
  };
  for (std::size_t i = 0; i < logs.size(); ++i) {
    note(copies, i);
    if (!away[i]) note(check_attitude(logs[i], out.vehicle), i);
    if (!away[i]) note(check_log(logs[i], out.vehicle), i);
    if (away[i]) out.set_aside.push_back({label_of(logs[i].path), "set_aside", 0.0, 0.0});
  }
  std::size_t at = 0;
  std::erase_if(logs, [&](const FlightLog&) { return away[at++]; });
}

std::string nothing_usable(const Remarks& remarks) {
  std::string text = "no fit flight is usable:";
  for (const LogFinding& f : remarks.findings)
    if (f.sets_flight_aside) text += fmt::format("\n  {}: {}{}", f.file, f.column == "*" ? "" : f.column + " ", f.says);
  return text;
}

}  // namespace

Recordings read_recordings(const std::vector<std::string>& fit, const std::vector<std::string>& holdout,
                           const std::vector<std::string>& reference, const std::optional<std::string>& vehicle) {
  Recordings read;
  read.fit = read_all(fit, read);
  read.holdout = read_all(holdout, read);
  read.reference = read_all(reference, read);
  if (read.fit.empty()) throw DataError(read.remarks.findings.front().says);
  if (vehicle) {
    read.vehicle = read_vehicle(*vehicle);
    return read;
  }
  OneVehicle flown;
  for (const auto* logs : {&read.fit, &read.holdout, &read.reference})
    for (const FlightLog& log : *logs) read.vehicle = flown.of({log.path, log.meta.vehicle});
  return read;
}

Recordings check(Recordings recordings) {
  const std::array roles = {&recordings.fit, &recordings.holdout, &recordings.reference};
  std::vector<const FlightLog*> before;
  std::vector<std::vector<LogFinding>> copies;  // as they were recorded: columns that are of no use are left out below
  for (const std::vector<FlightLog>* logs : roles) {
    copies.push_back(check_copies(*logs, before));
    for (const FlightLog& log : *logs) before.push_back(&log);
  }
  for (std::size_t i = 0; i < roles.size(); ++i) set_aside(*roles[i], copies[i], recordings);
  if (recordings.fit.empty()) throw DataError(nothing_usable(recordings.remarks));
  assume_nominal_voltage(recordings.vehicle, recordings.fit.front());
  if (recordings.holdout.empty() && recordings.fit.size() > 1) {
    recordings.holdout.push_back(std::move(recordings.fit.back()));
    recordings.fit.pop_back();
    recordings.remarks.notes.push_back(
        fmt::format("no flight was held out by the user: {} is", label_of(recordings.holdout.front().path)));
  }
  return recordings;
}

Recordings with_held_out_part(Recordings recordings) {
  if (!recordings.holdout.empty()) return recordings;
  const FlightLog whole = std::move(recordings.fit.front());
  const double first_s = whole.time_s.front(), last_s = whole.time_s.back();
  std::vector<std::pair<double, double>> gaps;  // begin, length; none of it is flight
  double flown_s = last_s - first_s;
  for (std::size_t k = 1; k < whole.rows(); ++k)
    if (const double gap_s = whole.time_s[k] - whole.time_s[k - 1]; gap_s > longest_walk_s)
      gaps.emplace_back(whole.time_s[k - 1], gap_s), flown_s -= gap_s;
  double cut_s = first_s + flown_s * 2.0 / 3.0;
  for (const auto& [begin_s, gap_s] : gaps)
    if (begin_s < cut_s) cut_s += gap_s;
  recordings.fit.front() = part_of(whole, {first_s, cut_s});
  recordings.holdout.push_back(part_of(whole, {cut_s, last_s + 1.0}));
  recordings.remarks.notes.emplace_back("there is one flight only: its last third is held out");
  return recordings;
}

bool is_recorded(const std::vector<FlightLog>& logs, std::initializer_list<const char*> any_of) {
  std::ptrdiff_t seen = 0;
  for (const FlightLog& log : logs)
    for (const char* name : any_of)
      if (const auto* column = log.find(name))
        seen += std::count_if(column->begin(), column->end(), [](double v) { return std::isfinite(v); });
  return seen > 100;
}

std::vector<FlightData> prepare(const std::vector<FlightLog>& logs, const VehicleModel& vehicle,
                                const ReadingOptions& options, const std::vector<double>& offset_s, std::size_t first) {
  std::vector<FlightData> flights;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    flights.push_back(prepare_flight(logs[i], vehicle, options));
    if (first + i >= offset_s.size()) continue;
    flights.back().delay_inputs(offset_s[first + i]);
  }
  return flights;
}

}  // namespace gustlab::diagnosis
