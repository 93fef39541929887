// Runs a program and keeps what it says.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "gustlab/build_info.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::test {

struct Said {
  int exit_code = -1;  // 128 + signal when a signal ended it
  std::string out, err;
};

// The gustlab of this build.
inline std::string gustlab_program() {
  const char* program = std::getenv("GUSTLAB_PROGRAM");
  if (program == nullptr) throw std::runtime_error("GUSTLAB_PROGRAM is not set: run the tests by ctest");
  return program;
}

// The Python of the project's environment; empty where there is none.
inline std::string python_program() {
  const std::filesystem::path python = std::filesystem::path(source_directory()) / ".venv" / "bin" / "python";
  return std::filesystem::exists(python) ? python.string() : "";
}

// `environment`: NAME=value pairs that are set for the program. `folder`: where it runs; empty: here.
inline Said run_program(const std::vector<std::string>& command, const std::string& folder = {},
                        const std::vector<std::string>& environment = {}) {
  const TemporaryFolder files;
  const std::string out = files.file("out"), err = files.file("err");
  std::vector<char*> arguments;
  for (const std::string& part : command) arguments.push_back(const_cast<char*>(part.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (!folder.empty() && chdir(folder.c_str()) != 0) _exit(126);
    for (const std::string& pair : environment) putenv(const_cast<char*>(pair.c_str()));
    if (!std::freopen(out.c_str(), "w", stdout) || !std::freopen(err.c_str(), "w", stderr)) _exit(126);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  Said said;
  said.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  said.out = read_text(out);
  said.err = read_text(err);
  return said;
}

// Runs gustlab with these arguments.
inline Said gustlab(std::vector<std::string> arguments, const std::string& folder = {},
                    const std::vector<std::string>& environment = {}) {
  arguments.insert(arguments.begin(), gustlab_program());
  return run_program(arguments, folder, environment);
}

}  // namespace gustlab::test
