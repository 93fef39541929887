#include "diagnosis/recording/stretches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "flight_log/csv.hpp"
#include "gustlab/vehicle.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double block_s = 1.0;  // of which stretches are made
constexpr std::size_t blocks_of_stretch = static_cast<std::size_t>(stretch_s / block_s);
constexpr std::size_t most_stretches = static_cast<std::size_t>(most_flight_s / stretch_s);

// of one signal
struct Sums {
  double count = 0.0, sum = 0.0, squares = 0.0;
  void add(const Sums& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
  double variance() const { return count > 1.0 ? std::max(0.0, squares / count - (sum / count) * (sum / count)) : 0.0; }
};

struct Block {
  double first_s = 0.0, last_s = 0.0;
  std::vector<Sums> signals;
};

// time, a column that shows an attitude, and signals: what the vehicle did and was asked for, rotors last
std::vector<std::string> columns_read() {
  std::vector<std::string> names{"time_s", "qw", "px", "py", "pz", "vx", "vy",
                                 "vz",     "wx", "wy", "wz", "ax", "ay", "az"};
  for (const char* prefix : {"u", "rotor"})
    for (int i = 1; i <= max_rotors; ++i) names.push_back(fmt::format("{}{}", prefix, i));
  return names;
}
constexpr std::size_t first_signal = 2, first_rotor = 12, body_rate = 6;  // the last two counted from the first signal

// the log in blocks, with its flight time; in memory are the blocks
struct Excitation {
  std::vector<Block> blocks;
  std::vector<Sums> whole;
  double lasts_s = 0.0;
  bool turns = false;  // attitude or body rate is there
};

Excitation excitation_of(const std::string& csv_path) {
  Excitation log;
  const std::vector<std::string> columns = columns_read();
  log.whole.resize(columns.size() - first_signal);
  double first_s = 0.0, last_s = -std::numeric_limits<double>::infinity();
  for_each_row(csv_path, columns, [&](const std::vector<double>& cells) {
    const double time_s = cells[0];
    if (!(time_s > last_s)) return;  // what is wrong there is said by whoever reads these rows
    if (log.blocks.empty()) first_s = time_s;
    else log.lasts_s += std::min(time_s - last_s, block_s);  // a gap is no flight time
    const auto number = [&](double at_s) { return std::floor((at_s - first_s) / block_s); };
    if (log.blocks.empty() || number(time_s) > number(last_s))
      log.blocks.push_back({time_s, time_s, std::vector<Sums>(log.whole.size())});
    log.blocks.back().last_s = last_s = time_s;
    log.turns = log.turns || !std::isnan(cells[1]) || !std::isnan(cells[first_signal + body_rate]);
    for (std::size_t s = 0; s < log.whole.size(); ++s) {
      const double cell = cells[s + first_signal];
      if (std::isnan(cell)) continue;
      log.blocks.back().signals[s].add({1.0, cell, cell * cell});
    }
  });
  for (const Block& block : log.blocks)
    for (std::size_t s = 0; s < log.whole.size(); ++s) log.whole[s].add(block.signals[s]);
  return log;
}

// Which blocks fly: their mean command is not far below what is usual in flight. Rotors of a vehicle that stands turn slower.
std::vector<bool> flying(const std::vector<Block>& blocks) {
  constexpr double usual = 0.9, far_below = 0.6;
  std::vector<double> command;
  for (const Block& block : blocks) {
    double sum = 0.0, count = 0.0;
    for (std::size_t s = first_rotor; s < block.signals.size(); ++s)
      if (const Sums& sums = block.signals[s]; sums.count > 0.0) sum += sums.sum / sums.count, count += 1.0;
    command.push_back(count > 0.0 ? sum / count : 0.0);
  }
  const double least = far_below * quantile(command, usual);
  std::vector<bool> result;
  for (const double c : command) result.push_back(c >= least);
  return result;
}

// logarithm of the product of the variances, each over that of the whole log
double excites(const std::vector<Block>& blocks, std::size_t first, const std::vector<Sums>& whole) {
  constexpr double nothing = 1e-12;
  double result = 0.0;
  for (std::size_t s = 0; s < whole.size(); ++s) {
    if (whole[s].variance() == 0.0) continue;
    Sums sums;
    for (std::size_t b = first; b < first + blocks_of_stretch; ++b) sums.add(blocks[b].signals[s]);
    result += std::log(sums.variance() / whole[s].variance() + nothing);
  }
  return result;
}

}  // namespace

std::vector<TimeRange> telling_stretches(const std::string& csv_path) {
  const Excitation log = excitation_of(csv_path);
  const std::vector<Block>& blocks = log.blocks;
  if (!log.turns || log.lasts_s <= most_flight_s || blocks.size() < most_stretches * blocks_of_stretch) return {};
  const std::vector<bool> flies = flying(blocks);

  std::vector<TimeRange> stretches;
  for (std::size_t part = 0; part < most_stretches; ++part) {
    const std::size_t begin = part * blocks.size() / most_stretches, end = (part + 1) * blocks.size() / most_stretches;
    std::size_t best = begin;
    std::pair<bool, double> best_score{false, -std::numeric_limits<double>::infinity()};
    for (std::size_t first = begin; first + blocks_of_stretch <= end; ++first) {
      const auto at = flies.begin() + static_cast<std::ptrdiff_t>(first);
      const bool throughout =
          std::all_of(at, at + static_cast<std::ptrdiff_t>(blocks_of_stretch), [](bool f) { return f; });
      const std::pair<bool, double> score{throughout, excites(blocks, first, log.whole)};
      if (score > best_score) best = first, best_score = score;
    }
    const double last_s = blocks[best + blocks_of_stretch - 1].last_s;
    stretches.push_back({blocks[best].first_s, std::nextafter(last_s, std::numeric_limits<double>::infinity())});
  }
  return stretches;
}

std::vector<std::vector<TimeRange>> parts_of(const std::string& csv_path, std::size_t most_rows) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> time_s;
  for_each_row(csv_path, {"time_s"}, [&](const std::vector<double>& cells) { time_s.push_back(cells[0]); });
  const std::size_t count = (time_s.size() + most_rows - 1) / most_rows;
  const bool rises =
      std::adjacent_find(time_s.begin(), time_s.end(), [](double a, double b) { return !(b > a); }) == time_s.end();
  if (count < 2 || !rises) return {{}};
  std::vector<std::vector<TimeRange>> parts;
  const auto begin_s = [&](std::size_t part) { return part < count ? time_s[part * time_s.size() / count] : infinity; };
  for (std::size_t part = 0; part < count; ++part) parts.push_back({{begin_s(part), begin_s(part + 1)}});
  return parts;
}

FlightLog part_of(const FlightLog& log, const TimeRange& range) {
  FlightLog part{log.path, {}, {}, log.meta, log.repairs};
  const auto row = [&](double at_s) {
    return std::lower_bound(log.time_s.begin(), log.time_s.end(), at_s) - log.time_s.begin();
  };
  const auto first = row(range.from_s), last = row(range.to_s);
  const auto rows = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + first, values.begin() + last);
  };
  part.time_s = rows(log.time_s);
  for (const LogColumn& column : log.columns) part.columns.push_back({column.name, rows(column.values)});
  return part;
}

std::vector<FlightLog> read_flights(const std::string& csv_path) {
  const std::vector<TimeRange> stretches = telling_stretches(csv_path);
  std::vector<FlightLog> flights;
  flights.push_back(read_flight_log(csv_path, stretches));
  if (stretches.empty()) return flights;
  const FlightLog all = std::move(flights.front());
  flights.clear();
  for (const TimeRange& stretch : stretches) {
    flights.push_back(part_of(all, stretch));
    flights.back().path += fmt::format(" ({:.0f} to {:.0f} s)", stretch.from_s, stretch.to_s);
  }
  return flights;
}

bool is_flight_of(const std::string& flight, const std::string& file) {
  return flight == file || flight.starts_with(file + " (");
}

}  // namespace gustlab::diagnosis
