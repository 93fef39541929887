#include "fuzz/readers.hpp"

#include <filesystem>
#include <fstream>

#include "config/toml.hpp"
#include "control/network.hpp"
#include "flight_log/sidecar.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "report/score.hpp"
#include "report/tracking_json.hpp"
#include "simulation/experiment.hpp"
#include "sweep/sweep.hpp"
#include "vehicle/mjcf.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::fuzz {

namespace {

namespace fs = std::filesystem;

std::string write(const std::string& folder, const char* name, const std::string& bytes) {
  const fs::path path = fs::path(folder) / name;
  std::ofstream file(path, std::ios::binary);
  if (!file) {
    fs::create_directories(path.parent_path());
    file.open(path, std::ios::binary);
  }
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path.string();
}

const char* const sidecar_text_of_a_log =
    "format = \"gustlab-flight/1\"\nvehicle = \"crazyflie\"\nactuator = \"rotor_speed\"\n";

const char* const body_of_a_vehicle = R"(<mujoco><worldbody><body><freejoint/>
<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.02"/>
<site name="a" pos="1 -1 0"/><site name="b" pos="-1 -1 0"/><site name="c" pos="-1 1 0"/><site name="d" pos="1 1 0"/>
</body></worldbody></mujoco>)";

void read_toml(const std::string& bytes, const std::string&) {
  config::Table table = config::Table::parse(bytes, "fuzz.toml");
  for (const std::string& key : table.keys()) table.literal(key);
  table.finish();
}

void read_log(const std::string& bytes, const std::string& folder) {
  const std::string path = write(folder, "log.csv", bytes);
  write(folder, "log.meta.toml", sidecar_text_of_a_log);
  tracking_of(path, 0.0);
  if (bytes.size() % 2 == 1)
    read_flight_log_in_parts(
        path, [](const FlightLog&) {}, 3);
}

void read_meta(const std::string& bytes, const std::string& folder) {
  const std::string path = write(folder, "log.meta.toml", bytes), text = sidecar_text(read_sidecar(path));
  config::Table::parse(text, path);  // what is written reads back
}

void read_a_vehicle(const std::string& bytes, const std::string& folder) {
  write(folder, "body.xml", body_of_a_vehicle);
  read_vehicle(write(folder, "vehicle.toml", bytes));
}

void read_body(const std::string& bytes, const std::string& folder) { read_mjcf(write(folder, "body.xml", bytes)); }

void read_an_experiment(const std::string& bytes, const std::string& folder) {
  for (const Experiment& variant : read_variants(write(folder, "experiment.toml", bytes))) resolved_text(variant);
}

void read_store(const std::string& bytes, const std::string& folder) {
  for (const char* left : {"runs.sqlite-wal", "runs.sqlite-shm", "runs.sqlite-journal"})
    fs::remove(fs::path(folder) / left);
  write(folder, "runs.sqlite", bytes);
  read_results(folder);
}

void read_weights(const std::string& bytes, const std::string&) { parse_network(bytes, "weights"); }

void read_baseline(const std::string& bytes, const std::string& folder) {
  read_results_csv(write(folder, "runs.csv", bytes));
}

void read_diagnosis(const std::string& bytes, const std::string& folder) {
  const std::string answers =
      write(folder, "answers.jsonl",
            R"({"trial": "t", "kind": "single", "effects": [{"effect": "mass", "parameters": {"delta": 0.1}}]})");
  write(folder, "trials/t/diagnosis/diagnosis.json", bytes);
  const TrialSet set{answers, (fs::path(folder) / "trials").string()};
  // the tables of a score take most of the time: of one input in sixteen (its size and sum tell which) they are made, too
  unsigned sum = static_cast<unsigned>(bytes.size());
  for (const char byte : bytes) sum += static_cast<unsigned char>(byte);
  if (sum % 16 == 0) score_trials({set}, "diagnosis");
  else read_trials(set, "diagnosis");
}

void read_answers(const std::string& bytes, const std::string& folder) {
  fs::create_directories(fs::path(folder) / "trials");
  score_trials({{write(folder, "answers.jsonl", bytes), (fs::path(folder) / "trials").string()}}, "diagnosis");
}

}  // namespace

const std::vector<ReaderTarget>& reader_targets() {
  static const std::vector<ReaderTarget> all{
      {"toml", read_toml},           {"flight_log", read_log},  {"sidecar", read_meta},
      {"vehicle", read_a_vehicle},   {"mjcf", read_body},       {"experiment", read_an_experiment},
      {"store", read_store},         {"weights", read_weights}, {"baseline", read_baseline},
      {"diagnosis", read_diagnosis}, {"answers", read_answers}};
  return all;
}

}  // namespace gustlab::fuzz
