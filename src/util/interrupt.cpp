#include "util/interrupt.hpp"

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
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGHUP})
    // who starts a program with nohup wants it to live on
    if (std::signal(signal, handle) == SIG_IGN && signal == SIGHUP) std::signal(signal, SIG_IGN);
  return flag;
}

void throw_if_interrupted() {
  if (flag) throw Interrupted{};
}

}  // namespace gustlab
