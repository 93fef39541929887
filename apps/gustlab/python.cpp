#include "python.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>

#include "config/resources.hpp"
#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

// what a child writes, until it ends; a signal that ends this program ends the child
std::string read_all(int file, pid_t child, const std::atomic<bool>& stop) {
  std::string text;
  std::array<char, 4096> part{};
  pollfd waiting{file, POLLIN, 0};
  const auto next = [&] {
    while (poll(&waiting, 1, 100) <= 0)
      if (stop && child > 0) kill(child, SIGTERM);
    return read(file, part.data(), part.size());
  };
  for (ssize_t n; (n = next()) > 0;) text.append(part.data(), static_cast<std::size_t>(n));
  close(file);
  return text;
}

[[noreturn]] void become(std::vector<std::string> command, int out, int err) {
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  execv(words[0], words.data());
  _exit(127);
}

}  // namespace

std::string output_of_script(const std::string& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> command;
  try {
    command = {find_resource(".venv/bin/python3"), find_resource("scripts/" + script)};
  } catch (const ConfigError&) {
    throw ConfigError("this needs the project's Python environment (.venv is not there); run scripts/setup.sh");
  }
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::array<int, 2> out{}, err{};
  if (pipe(out.data()) != 0 || pipe(err.data()) != 0) throw IoError("no pipe to a script can be opened");
  const std::atomic<bool>& stop = interrupted();
  const pid_t child = fork();
  if (child == 0) become(command, out[1], err[1]);
  close(out[1]);
  close(err[1]);
  // what a script prints is small, and its messages come last: one after the other never blocks it
  const std::string said = read_all(out[0], child, stop), message = read_all(err[0], child, stop);
  int status = 0;
  const bool ended = child > 0 && waitpid(child, &status, 0) == child;
  throw_if_interrupted();
  if (!ended || !WIFEXITED(status) || WEXITSTATUS(status) == 127)
    throw IoError(fmt::format("{}: cannot be run", command[1]));
  if (WEXITSTATUS(status) != 0)
    throw DataError(message.empty() ? command[1] + ": failed" : message.substr(0, message.find_last_not_of('\n') + 1));
  return said;
}

}  // namespace gustlab
