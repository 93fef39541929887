#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "commands.hpp"
#include "config/resources.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

// The libraries that read foreign logs are Python's: this process becomes the importer, so that its output, exit code and
// signals are the command's.
[[noreturn]] void import_command(const std::vector<std::string>& arguments) {
  std::vector<std::string> command{find_resource(".venv/bin/python3"), find_resource("scripts/import_log.py")};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  execv(words[0], words.data());
  throw std::runtime_error(
      fmt::format("{}: cannot be started ({}) run scripts/setup.sh", command[0], std::strerror(errno)));
}

}  // namespace

void add_import(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("import", "turns flight computers' logs into flight logs, or says what is in them");
  // its options are the importer's own, --help too
  command->set_help_flag();
  command->fallthrough(false);
  command->prefix_command();
  command->callback([command] { import_command(command->remaining()); });
}

}  // namespace gustlab
