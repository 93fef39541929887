#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "diagnosis/diagnose.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

struct Options {
  std::vector<std::string> flights, holdout;
  std::string vehicle, out;
  int jobs = default_jobs();
};

constexpr const char* outputs[] = {"diagnosis.json", "augmented.toml", "report.html"};

// an existing folder is replaced only when it holds a former diagnosis and nothing else
void check_out(const std::filesystem::path& out) {
  if (!std::filesystem::exists(out)) return;
  if (!std::filesystem::is_directory(out)) throw ConfigError(fmt::format("{}: is a file (--out is a folder) name another", out.string()));
  for (const auto& entry : std::filesystem::directory_iterator(out))
    if (std::find(std::begin(outputs), std::end(outputs), entry.path().filename().string()) == std::end(outputs))
      throw ConfigError(fmt::format("{}: holds {} (only a former diagnosis is replaced) name another folder", out.string(),
                                    entry.path().filename().string()));
}

void run(const Options& options) {
  check_out(options.out);
  diagnosis::DiagnoseOptions wanted;
  wanted.fit = options.flights;
  wanted.holdout = options.holdout;
  if (!options.vehicle.empty()) wanted.vehicle = options.vehicle;
  wanted.jobs = options.jobs;
  const diagnosis::Diagnosis result = diagnosis::diagnose(wanted);
  const nlohmann::ordered_json document = diagnosis::to_json(result);

  // written beside and renamed, so that the folder is the old diagnosis or the new one
  const std::filesystem::path out = std::filesystem::path(options.out).lexically_normal();
  std::string bare = out.string();
  if (bare.size() > 1 && bare.back() == '/') bare.pop_back();
  const std::filesystem::path fresh = bare + ".new";
  std::filesystem::remove_all(fresh);
  make_folder(fresh.string());
  write_file((fresh / "diagnosis.json").string(), document.dump(1) + "\n");
  write_file((fresh / "augmented.toml").string(), result.augmented_toml);
  std::error_code error;
  std::filesystem::remove_all(bare, error);
  std::filesystem::rename(fresh, bare, error);
  if (error) throw IoError(fmt::format("{}: cannot be replaced ({})", bare, error.message()));

  fmt::print("{}: {}", result.vehicle, to_string(result.verdict));
  for (const auto& effect : result.effects) {
    fmt::print("\n  {}", effect.effect);
    for (const auto& value : effect.parameters) fmt::print(" {} = {:.4g}{}", value.name, value.value, value.unit == "-" ? "" : " " + value.unit);
    fmt::print(" (confidence {:.2f})", effect.confidence);
  }
  fmt::print("\n");
}

}  // namespace

void add_diagnose(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("diagnose", "names the physics that the simulation of these flights leaves out");
  command->add_option("FLIGHT", options->flights, "flight logs of one vehicle, NAME.csv or NAME.csv.gz")->required();
  command->add_option("--holdout", options->holdout, "flights to verify on (default: the last one)");
  command->add_option("--vehicle", options->vehicle, "name under models/ or path to a vehicle.toml (default: what the logs say)");
  command->add_option("--out", options->out, "folder for diagnosis.json, augmented.toml and report.html")->required();
  command->add_option("--jobs", options->jobs, "threads")->check(CLI::PositiveNumber)->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
