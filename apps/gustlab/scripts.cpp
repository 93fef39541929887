#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "commands.hpp"
#include "config/resources.hpp"
#include "gustlab/errors.hpp"
#include "python.hpp"

namespace gustlab {

namespace {

struct Script {
  std::string name, says, file;
};

const std::array<Script, 4> scripts{
    {{"import", "turns flight computers' logs into flight logs, or says what is in them", "import_log.py"},
     {"export", "writes a flight log as Parquet, MCAP or one CSV per topic", "export_flight.py"},
     {"render", "draws a flight as a film, without a display", "render_flight.py"},
     {"view", "plays a flight in MuJoCo's viewer", "view_flight.py"}}};

// The libraries that read foreign logs, write other formats and draw are Python's: this process becomes the script, so that its
// output, exit code and signals are the command's.
[[noreturn]] void become_script(const std::string& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> command{find_resource(".venv/bin/python3"), find_resource("scripts/" + script)};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  // a script that needs another command of the program finds this one
  std::error_code failed;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (!failed) setenv("GUSTLAB_PROGRAM", program.c_str(), 1);
  execv(words[0], words.data());
  throw std::runtime_error(
      fmt::format("{}: cannot be started ({}); run scripts/setup.sh", command[0], std::strerror(errno)));
}

// its options are the script's own, --help too
void add_script(CLI::App& app, const Script& script) {
  CLI::App* command = app.add_subcommand(script.name, script.says);
  command->set_help_flag();
  command->fallthrough(false);
  command->prefix_command();
  command->callback([command, &script] { become_script(script.file, command->remaining()); });
}

}  // namespace

void add_scripts(CLI::App& app) {
  for (const Script& one : scripts) add_script(app, one);
}

std::string help_of_script(const std::string& command) {
  const auto one = std::find_if(scripts.begin(), scripts.end(), [&](const Script& s) { return s.name == command; });
  setenv("COLUMNS", "10000", 1);  // one line an option
  try {
    return output_of_script(one->file, {"--help"});
  } catch (const ConfigError&) {
    return "";
  }
}

}  // namespace gustlab
