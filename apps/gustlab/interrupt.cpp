#include "interrupt.hpp"

#include <csignal>

namespace gustlab {

namespace {

std::atomic<bool> flag{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void handle(int signal) {
  flag = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<bool>& interrupted() {
  std::signal(SIGINT, handle);
  std::signal(SIGTERM, handle);
  return flag;
}

}  // namespace gustlab
