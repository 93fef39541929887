// What is said on stderr.
#pragma once

#include <cstdio>
#include <string>

namespace gustlab {

// Says it there, or nowhere: that it cannot be said changes nothing of what a command does.
inline void say_on_stderr(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace gustlab
