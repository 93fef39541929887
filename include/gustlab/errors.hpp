// What can go wrong on the user's side, and the exit code that says so.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace gustlab {

// How a message is worded: `problem (why); suggestion`, without what is empty. Messages that are written as one text keep to it.
inline std::string worded(std::string_view problem, std::string_view why, std::string_view suggestion) {
  std::string text(problem);
  if (!why.empty()) text.append(" (").append(why).append(")");
  if (!suggestion.empty()) text.append("; ").append(suggestion);
  return text;
}

// A message `file:line:col: problem (why); suggestion`, written once to stderr by main().
class UserError : public std::runtime_error {
 public:
  UserError(int exit_code, const std::string& message) : std::runtime_error(message), exit_code_(exit_code) {}
  int exit_code() const { return exit_code_; }

 private:
  int exit_code_;
};

// usage or configuration: exit 2
struct ConfigError : UserError {
  explicit ConfigError(const std::string& message) : UserError(2, message) {}
};

// What an object says is wrong with one of its parameters. Where that was written it does not know: whoever read it puts the
// place before (config::at_place).
struct ParameterError : ConfigError {
  ParameterError(std::string_view of, const std::string& message) : ConfigError(message), parameter(of) {}
  std::string parameter;
};

// input data: exit 3
struct DataError : UserError {
  explicit DataError(const std::string& message) : UserError(3, message) {}
};

// internal, or the disk said no: exit 4
struct IoError : UserError {
  explicit IoError(const std::string& message) : UserError(4, message) {}
};

}  // namespace gustlab
