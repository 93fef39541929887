// Ctrl-C finishes the runs in hand; a second one ends the program at once.
#pragma once

#include <atomic>

namespace gustlab {

// What ends a command that was interrupted: exit 130.
struct Interrupted {};

// Becomes true at SIGINT, SIGTERM, SIGUSR1 (which batch systems send) or SIGHUP (unless it is ignored, as by nohup). The first call
// installs the handlers: a command that calls it sees to it that it ends soon.
const std::atomic<bool>& interrupted();
// Throws Interrupted when that has happened. parallel_for asks before every body.
void throw_if_interrupted();

}  // namespace gustlab
