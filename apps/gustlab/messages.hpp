// What is said on stderr, and what is read by people on stdout.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

#include "config/text.hpp"

namespace gustlab {

// Text for a terminal: names that it quotes from files and paths cannot steer it.
inline void say_on_stdout(std::string_view text) {
  const std::string safe = config::printable(text);
  std::fwrite(safe.data(), 1, safe.size(), stdout);
}

// Says it there, or nowhere: that it cannot be said changes nothing of what a command does.
inline void say_on_stderr(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace gustlab
