#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <span>
#include <system_error>

#include "commands.hpp"
#include "config/text.hpp"
#include "config/toml.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "messages.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"

namespace {

using namespace gustlab;

std::string version_text() {
  const BuildInfo& build = build_info();
  return fmt::format("gustlab {} ({})\nMuJoCo {}\n{} {}", build.version, build.commit, build.mujoco_version,
                     build.compiler, build.flags);
}

// a message may quote a file
class PrintableText final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& out) override {
    const std::string text = config::printable({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<PrintableText>(); }
};

void say(std::string_view message) { say_on_stderr(config::printable(message) + "\n"); }

// messages go to stderr, data to stdout; colours only on a terminal that wants them
void start_messages() {
  const char* no_color = std::getenv("NO_COLOR");
  const bool plain = no_color != nullptr && *no_color != '\0';
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_st>(plain ? spdlog::color_mode::never
                                                                          : spdlog::color_mode::automatic);
  auto logger = std::make_shared<spdlog::logger>("gustlab", sink);
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableText>('*').set_pattern("%^%l%$: %*");
  logger->set_formatter(std::move(formatter));
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
  add_scripts(app);
  add_replay(app);
  add_diagnose(app);
  add_identify(app);
  add_train(app);
  add_tune(app);
  add_conceal(app);
  add_score(app);
  add_vehicle(app);
  add_completion(app);
}

// a file of no name would be the present folder to some commands, and not given to others
void check_words(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (argv[i][0] == '\0')
      throw ConfigError(
          fmt::format("gustlab: there is an empty word behind \"{}\" (a variable of the shell that is not set?)",
                      i > 1 ? argv[i - 1] : "gustlab"));
}

// CLI11 takes the value of an option that no command has yet for a command. Options of a command above are taken below it.
void check_option(const CLI::App& app, const std::string& word, const std::string& before) {
  const std::string name = word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
  if (name == "--" || name == "-") return;
  for (const CLI::App* all = &app; all != nullptr; all = all->get_parent())
    if (all->get_option_no_throw(name) != nullptr) return;
  throw ConfigError(worded(fmt::format("gustlab: unknown option \"{}\" before a command", name),
                           "options of a command stand behind it", fmt::format("write {}COMMAND {}", before, name)));
}

// CLI11 only says that a command is missing; one of commands below another, too
void check_command(const CLI::App& app, std::span<char*> words, const std::string& before = "gustlab ") {
  const auto word = std::find_if(words.begin(), words.end(), [](const char* argument) { return *argument != '-'; });
  std::vector<const CLI::App*> commands = app.get_subcommands(nullptr);
  if (word == words.end() || commands.empty()) return;
  for (auto option = words.begin(); option != word; ++option) check_option(app, *option, before);
  std::vector<std::string> known;
  for (const CLI::App* command : commands) {
    if (command->get_name() == *word)
      return check_command(*command, words.subspan(static_cast<std::size_t>(word - words.begin()) + 1),
                           before + *word + " ");
    known.push_back(command->get_name());
  }
  const std::string near = config::suggest(*word, known);
  throw ConfigError(worded(fmt::format("gustlab: unknown command \"{}\"", *word),
                           near.empty() ? fmt::format("see {}--help", before) : "", near));
}

// CLI11's words where they are no sentence of this program
std::string words_of(const CLI::Error& error) {
  const std::string said = error.what();
  if (const auto* wrong = dynamic_cast<const CLI::ConversionError*>(&error); wrong && said.find(" = ") < said.size()) {
    const std::size_t begin = said.find("--"), equals = said.find(" = ");
    if (begin < equals)
      return fmt::format("{}: \"{}\" is no number that it takes", said.substr(begin, equals - begin),
                         said.substr(equals + 3));
  }
  if (said == "A subcommand is required") return "a command is missing";
  return said;
}

int run(int argc, char** argv) {
  CLI::App app{"Flies multirotors in simulation and finds the physics that a simulation leaves out", "gustlab"};
  app.require_subcommand(1);
  app.failure_message([](const CLI::App* all, const CLI::Error& error) {
    std::string command;
    for (auto below = all->get_subcommands(); !below.empty(); below = below.front()->get_subcommands())
      command += below.front()->get_name() + " ";
    return fmt::format("gustlab: {} (see gustlab {}--help)\n", config::printable(words_of(error)), command);
  });
  app.fallthrough();
  app.set_version_flag("--version", version_text());
  CLI::Option* quiet = app.add_flag_callback(
      "-q,--quiet", [] { spdlog::set_level(spdlog::level::err); }, "errors only");
  app.add_flag_callback(
         "-v,--verbose", [] { spdlog::set_level(spdlog::level::debug); }, "says more")
      ->excludes(quiet);
  try {
    start_messages();
    protect_inputs();
    add_commands(app);
    check_words(argc, argv);
    check_command(app, {argv + 1, argv + argc});
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const ExitCode& exit) {
    return exit.code;
  } catch (const Interrupted&) {
    say("interrupted");
    return 130;
  } catch (const UserError& error) {
    say(error.what());
    return error.exit_code();
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string path = error.path1().string(), why = error.code().message();
    const bool of_the_path = is_fault_of_path(error.code().value());
    say(of_the_path ? worded(path + ": cannot be used", why, "name another") : fmt::format("{}: {}", path, why));
    return of_the_path ? 2 : 4;
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) != 0) return 0;  // main() says it
    say(fmt::format("gustlab: {}", error.what()));
    return 4;
  } catch (const std::exception& error) {
    say(fmt::format("gustlab: {}", error.what()));
    return 4;
  }
  return 0;
}

// Says why it is not. Who could not write before has kept no reason: one more byte is refused for the same.
bool stdout_is_written() {
  errno = 0;
  std::cout.flush();
  if (std::cout && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return true;
  if (errno == 0 && write(STDOUT_FILENO, "\n", 1) == 1) errno = EIO;
  say(fmt::format("stdout: cannot write ({})", std::strerror(errno)));
  return false;
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // MuJoCo's memory of one flight (some 13 MB, of which little is touched) goes back to the system with the flight. Without this,
  // glibc takes it from the heap after the first flight, and how much of the heap is touched then depends on where things lie.
  mallopt(M_MMAP_THRESHOLD, 8 << 20);
#endif
  const int code = run(argc, argv);
  if (code == 4) return code;  // with its one line
  if (stdout_is_written()) return code;
  return 4;
}
