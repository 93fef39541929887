#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "report/tracking_json.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

struct MetricsArguments {
  std::vector<std::string> logs;
  double settle_s = 0.0;
  std::string format = "md";
};

void metrics(const MetricsArguments& options) {
  check_paths_differ(options.logs, "its errors would stand there twice");
  std::vector<TrackingFigures> figures;
  interrupted();
  for (const std::string& path : options.logs) {
    const TrackingOfLog tracking = tracking_of(path, options.settle_s);
    for (const LogRepair& repair : tracking.repairs) spdlog::warn(repair.says);
    figures.push_back(tracking.figures);
  }
  if (options.format == "json") {
    nlohmann::ordered_json result{{"format", "gustlab-metrics/1"}, {"settle_s", options.settle_s}};
    result["logs"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < figures.size(); ++i) {
      nlohmann::ordered_json entry{{"file", options.logs[i]}};
      entry.update(to_json(figures[i]));
      result["logs"].push_back(std::move(entry));
    }
    fmt::print("{}\n", config::json_text(result, 2));
    return;
  }
  fmt::print(
      "| log | error | samples | RMSE [m] | MAE [m] | P95 [m] | Max [m] | RMSE z [m] "
      "|\n|---|---|--:|--:|--:|--:|--:|--:|\n");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const auto line = [&](const char* kind, const ErrorFigures& e, const std::string& z) {
      say_on_stdout(fmt::format("| {} | {} | {} | {:.4f} | {:.4f} | {:.4f} | {:.4f} | {} |\n", options.logs[i], kind,
                                figures[i].samples, e.rmse_m, e.mae_m, e.p95_m, e.max_m, z));
    };
    line("planar", figures[i].planar, fmt::format("{:.4f}", figures[i].rmse_z_m));
    line("3-D", figures[i].spatial, "");
  }
  fmt::print("\nSamples from {} s after each log's start.\n", options.settle_s);
}

}  // namespace

void add_metrics(CLI::App& app) {
  const auto options = std::make_shared<MetricsArguments>();
  CLI::App* command =
      app.add_subcommand("metrics", "tracking error of recordings that have a reference, planar and 3-D");
  command->add_option("LOG", options->logs, "flight logs with px, py, pz and rpx, rpy, rpz")->required();
  command->add_option("--settle", options->settle_s, "seconds after each log's start that do not count")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "json"}))->capture_default_str();
  command->callback([options] { metrics(*options); });
}

}  // namespace gustlab
