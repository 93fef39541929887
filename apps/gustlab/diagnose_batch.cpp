#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "diagnose.hpp"
#include "flight_log/sidecar.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "progress.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/sha256.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_log_bytes = std::size_t{4} << 30;

struct FlightSet {
  std::string name;
  diagnosis::DiagnoseOptions wanted;
};

// flights are relative to the file that names them
std::string beside(const std::string& file, const std::string& from) {
  return (fs::path(from).parent_path() / file).lexically_normal().string();
}

// a name that is a folder of its own in OUT
bool is_folder_name(const std::string& name) {
  return !name.empty() && name.find_first_of("/\\ \n") == std::string::npos && !name.starts_with(".") &&
         config::printable(name) == name;
}

// Runs `check`. What it throws is said with the place in the file of sets, and is wrong with that file.
template <class Check>
void check_at(const std::string& place, Check check) {
  try {
    check();
  } catch (const UserError& error) {
    const std::string says = error.what();
    throw ConfigError(says.starts_with(place) ? says : place + ": " + says);
  }
}

// the vehicle that a flight names; what else is wrong with a flight makes its set unusable, and is said when it is diagnosed
void check_vehicle_of(const std::string& flight, OneVehicle& flown) {
  const std::string sidecar = sidecar_path(flight);
  try {
    flown.of({sidecar, read_sidecar(sidecar).vehicle});
  } catch (const DataError&) {
  }
}

// Before work begins on any set: flights and vehicles that are not there, and a flight that is there twice, are slips of the hand.
void check_set(const config::Table& table, FlightSet& set) {
  diagnosis::DiagnoseOptions& wanted = set.wanted;
  const auto at = [&](const std::string& where) { return fmt::format("{}: set \"{}\"", where, set.name); };
  if (wanted.vehicle) {
    const std::string place = at(table.where("vehicle"));
    check_at(place, [&] { wanted.vehicle = read_vehicle(*wanted.vehicle, place).source_path; });
  }
  std::set<fs::path> seen;
  OneVehicle flown;
  for (const auto& [key, paths] :
       {std::pair{"fit", &wanted.fit}, {"holdout", &wanted.holdout}, {"reference", &wanted.reference}})
    for (const std::string& flight : *paths)
      check_at(at(table.where(key)), [&] {
        check_flight(flight, seen);
        if (!wanted.vehicle) check_vehicle_of(flight, flown);
      });
}

std::vector<FlightSet> read_sets(const std::string& path, int jobs) {
  config::Table document = config::Table::read_file(path);
  if (document.need_text("format") != "gustlab-sets/1")
    document.fail("format", "this is no list of flight sets", "", "write format = \"gustlab-sets/1\"");
  std::vector<FlightSet> sets;
  std::set<std::string> seen;
  std::vector<config::Table> tables = document.tables("set");
  for (config::Table& table : tables) {
    FlightSet& set = sets.emplace_back();
    set.name = table.need_text("name");
    if (!is_folder_name(set.name) || !seen.insert(set.name).second)
      table.fail("name", fmt::format("\"{}\" is no name of a folder of its own", config::printable(set.name)), "",
                 "use another");
    diagnosis::DiagnoseOptions& wanted = set.wanted;
    for (const auto& [key, paths] :
         {std::pair{"fit", &wanted.fit}, {"holdout", &wanted.holdout}, {"reference", &wanted.reference}})
      for (const std::string& file : table.texts(key).value_or(std::vector<std::string>{}))
        paths->push_back(beside(file, path));
    if (wanted.fit.empty()) table.fail("fit", "there is no flight to fit", "", "list flight logs under \"fit\"");
    wanted.vehicle = table.text("vehicle");
    wanted.jobs = jobs;
  }
  if (sets.empty()) document.fail("set", "there is no [[set]]", "nothing would be diagnosed", "add one");
  document.finish();
  config::Problems problems;
  for (std::size_t i = 0; i < sets.size(); ++i) problems.collect([&] { check_set(tables[i], sets[i]); });
  problems.raise();
  return sets;
}

// What a flight's vehicle is made of. Empty where its own is not there: it flew with that of the flights before it.
std::string vehicle_bytes(const FlightSet& set, const std::string& sidecar) {
  if (set.wanted.vehicle) return read_vehicle(*set.wanted.vehicle).source_bytes;
  const std::string vehicle = read_sidecar(sidecar).vehicle;
  try {
    return read_vehicle(vehicle, sidecar).source_bytes;
  } catch (const ConfigError&) {
    return {};
  }
}

// everything that can change a diagnosis
std::string key_of(const FlightSet& set) {
  std::string all(build_info().commit);
  for (const auto* paths : {&set.wanted.fit, &set.wanted.holdout, &set.wanted.reference}) {
    all += '\n';
    for (const std::string& path : *paths) {
      const std::string sidecar = sidecar_path(path);
      all += sha256(fs::path(path).filename().string()) + '\n' + sha256_of_file(path, most_log_bytes) + '\n' +
             sha256(read_file<DataError>(sidecar)) + '\n' + sha256(vehicle_bytes(set, sidecar)) + '\n';
    }
  }
  return sha256(all);
}

// what a diagnosis says in one line
struct Said {
  std::string verdict;
  std::vector<std::string> named, alike;  // "mass"; "mass or thrust_scale", where the flights cannot tell them apart
};
Said read_said(const std::string& folder) {
  const std::string path = (fs::path(folder) / "diagnosis.json").string();
  const auto document = nlohmann::ordered_json::parse(read_file<IoError>(path));
  Said said{document.at("verdict").get<std::string>(), {}, {}};
  for (const auto& effect : document.at("effects")) {
    said.named.push_back(effect.at("effect").get<std::string>());
    said.alike.push_back(fmt::format("{}", fmt::join(effect.at("class").get<std::vector<std::string>>(), " or ")));
  }
  return said;
}

// Of a diagnosis that was made before; nothing where it is another, is not there or was damaged: it is made again.
std::optional<Said> said_before(const std::string& folder, const std::string& key) {
  if (diagnosed_key(folder) != key) return std::nullopt;
  try {
    return read_said(folder);
  } catch (const IoError&) {
  } catch (const nlohmann::json::exception&) {
  }
  return std::nullopt;
}

void print_counts(const char* title, const std::map<std::string, std::size_t>& counts, std::size_t all) {
  fmt::print("\n| {} | sets | of {} |\n|---|--:|--:|\n", title, all);
  for (const auto& [name, count] : counts)
    fmt::print("| {} | {} | {:.0f} % |\n", name, count, 100.0 * static_cast<double>(count) / static_cast<double>(all));
}

}  // namespace

void diagnose_batch(const std::string& sets_path, const std::string& out, int jobs) {
  const std::vector<FlightSet> sets = read_sets(sets_path, jobs);
  check_folder_can_be_made(out);
  std::map<std::string, std::size_t> verdicts, names;
  Progress progress;
  double begun = 0.0;  // sets that are through
  for (const FlightSet& set : sets) {
    throw_if_interrupted();
    const std::string folder = (fs::path(out) / set.name).string();
    Said said{"unusable", {}, {}};
    try {
      const std::string key = key_of(set);
      if (const std::optional<Said> before = said_before(folder, key)) {
        said = *before;
      } else {
        diagnosis::DiagnoseOptions wanted = set.wanted;
        wanted.progress = [&](std::string_view stage, std::optional<double>) {
          progress.show(fmt::format("{}: {}", set.name, stage), begun / static_cast<double>(sets.size()));
        };
        warn_of_set_aside(diagnose_into(folder, wanted, key));
        said = read_said(folder);
      }
    } catch (const DataError& error) {
      spdlog::warn("{}: {}", set.name, error.what());
    }
    begun += 1.0;
    progress.end();
    fmt::print("{}: {}{}{}\n", set.name, said.verdict, said.alike.empty() ? "" : " ", fmt::join(said.alike, ", "));
    ++verdicts[said.verdict];
    for (const std::string& name : std::set<std::string>(said.named.begin(), said.named.end())) ++names[name];
  }
  print_counts("verdict", verdicts, sets.size());
  print_counts("named", names, sets.size());
  if (verdicts["unusable"] == sets.size()) throw DataError(fmt::format("{}: no set has a usable flight", sets_path));
}

}  // namespace gustlab
