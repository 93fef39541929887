// reality draw: sealed trials for the diagnosis; reality vehicles: the nominal vehicles it is given
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>

#include "catalogue.hpp"
#include "draw.hpp"
#include "log.hpp"
#include "sha256.hpp"
#include "vehicle.hpp"

namespace {

constexpr const char* kUsage =
    "usage: reality draw --seed S --count N [--first I] [--kind clean|scatter|single|pair|outside|mixed]\n"
    "                    [--effect NAME] [--strength-factor X] [--vehicle cf|ir] [--noise 1|2]\n"
    "                    [--roughness X [--air steady|gusty|outdoor]]\n"
    "                    --out DIR --answers FILE\n"
    "       reality --write-vehicle DIR\n";

struct Options {
  reality::Request request;
  std::uint64_t first = 1, count = 0;
  std::filesystem::path out, answers, vehicles;
};

const std::map<std::string, reality::AirKind> air_kinds{
    {"steady", reality::AirKind::steady}, {"gusty", reality::AirKind::gusty}, {"outdoor", reality::AirKind::outdoor}};

Options read(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (key == "draw" && i == 1) continue;
    if (i + 1 >= argc) throw std::invalid_argument("'" + key + "' needs a value");
    const std::string value = argv[++i];
    if (key == "--seed") o.request.seed = std::stoull(value);
    else if (key == "--count") o.count = std::stoull(value);
    else if (key == "--first") o.first = std::stoull(value);
    else if (key == "--kind") o.request.kind = value;
    else if (key == "--effect") o.request.effect = value;
    else if (key == "--strength-factor") o.request.factor = std::stod(value);
    else if (key == "--vehicle" && (value == "cf" || value == "ir")) o.request.large = value == "ir";
    else if (key == "--noise" && (value == "1" || value == "2")) o.request.noise = std::stoi(value);
    else if (key == "--roughness" && std::stod(value) > 0) o.request.roughness = std::stod(value);
    else if (key == "--air" && air_kinds.count(value)) o.request.air = air_kinds.at(value);
    else if (key == "--out") o.out = value;
    else if (key == "--answers") o.answers = value;
    else if (key == "--write-vehicle") o.vehicles = value;
    else throw std::invalid_argument("'" + key + " " + value + "' is not understood");
  }
  const bool draws = !o.out.empty() && !o.answers.empty() && o.count > 0;
  if (!draws && o.vehicles.empty()) throw std::invalid_argument("nothing to do");
  return o;
}

std::string draw(const Options& o) {
  std::string answers;
  for (std::uint64_t index = o.first; index < o.first + o.count; ++index) {
    const reality::Trial trial = reality::draw_trial(o.request, index);
    char name[32];
    std::snprintf(name, sizeof name, "trial%03llu", static_cast<unsigned long long>(index));
    const std::filesystem::path folder = o.out / name;
    std::filesystem::create_directories(folder);
    reality::write_vehicle(trial.vehicle, o.out / "vehicles");
    const std::string vehicle = "../vehicles/" + reality::vehicle_folder(trial.vehicle) + "/vehicle.toml";
    for (std::size_t n = 0; n < trial.flight.size(); ++n) {
      const std::string file = n < reality::kFitFlights ? "fit_" + std::to_string(n + 1) : "holdout_1";
      reality::write_log(trial.flight[n], trial.surroundings, trial.columns, vehicle, folder / (file + ".csv"));
    }
    nlohmann::ordered_json line;
    line["trial"] = name;
    line.update(trial.answer);
    answers += line.dump() + "\n";
  }
  return answers;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = read(argc, argv);
    if (!options.vehicles.empty())
      for (const bool large : {false, true})
        for (const bool drag : {false, true})
          reality::write_vehicle(reality::nominal_vehicle(large, drag), options.vehicles);
    if (options.count == 0) return 0;
    const std::string answers = draw(options);
    std::ofstream file(options.answers, std::ios::binary);
    file << answers;
    if (!file) throw std::runtime_error("cannot write " + options.answers.string());
    std::cout << reality::sha256(answers) << "\n";
    return 0;
  } catch (const std::invalid_argument& e) {
    std::cerr << "reality: " << e.what() << "\n" << kUsage;
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "reality: " << e.what() << "\n";
    return 4;
  }
}
