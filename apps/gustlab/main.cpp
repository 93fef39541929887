#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>

#include "commands.hpp"
#include "config/toml.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"

namespace {

using namespace gustlab;

std::string version_text() {
  const BuildInfo& build = build_info();
  return fmt::format("gustlab {} ({})\nMuJoCo {}\n{} {}", build.version, build.commit, build.mujoco_version, build.compiler,
                     build.flags);
}

// messages go to stderr, data to stdout; colours only on a terminal that wants them
void start_messages() {
  const char* no_color = std::getenv("NO_COLOR");
  const bool plain = no_color != nullptr && *no_color != '\0';
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_st>(plain ? spdlog::color_mode::never : spdlog::color_mode::automatic);
  auto logger = std::make_shared<spdlog::logger>("gustlab", sink);
  logger->set_pattern("%^%l%$: %v");
  spdlog::set_default_logger(logger);
}

void add_commands(CLI::App& app) {
  add_run(app);
  add_sweep(app);
  add_merge(app);
  add_table(app);
  add_compare(app);
  add_metrics(app);
  add_gate(app);
  add_reproduce(app);
  add_calibrate(app);
  add_bench(app);
  add_list(app);
  add_defaults(app);
  add_replay(app);
  add_diagnose(app);
  add_identify(app);
  add_train(app);
  add_tune(app);
  add_conceal(app);
  add_score(app);
}

// CLI11 only says that a command is missing
void check_command(const CLI::App& app, int argc, char** argv) {
  const char* const* word = std::find_if(argv + 1, argv + argc, [](const char* argument) { return *argument != '-'; });
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands(nullptr)) known.push_back(command->get_name());
  if (word == argv + argc || std::find(known.begin(), known.end(), *word) != known.end()) return;
  const std::string near = config::suggest(*word, known);
  throw ConfigError(fmt::format("gustlab: unknown command \"{}\" {}", *word, near.empty() ? "(see gustlab --help)" : near));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Flies multirotors in simulation and finds the physics that a simulation leaves out", "gustlab"};
  app.require_subcommand(1);
  app.failure_message([](const CLI::App* all, const CLI::Error& error) {
    const auto commands = all->get_subcommands();
    return fmt::format("gustlab: {} (see gustlab {}--help)\n", error.what(), commands.empty() ? "" : commands.front()->get_name() + " ");
  });
  app.fallthrough();
  app.set_version_flag("--version", version_text());
  app.add_flag_callback("-q,--quiet", [] { spdlog::set_level(spdlog::level::err); }, "errors only");
  app.add_flag_callback("-v,--verbose", [] { spdlog::set_level(spdlog::level::debug); }, "says more");
  try {
    start_messages();
    add_commands(app);
    check_command(app, argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const ExitCode& exit) {
    return exit.code;
  } catch (const UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    fmt::print(stderr, "gustlab: {}\n", error.what());
    return 4;
  }
  return 0;
}
