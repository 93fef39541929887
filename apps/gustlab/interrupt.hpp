// Ctrl-C finishes the runs in hand; a second one ends the program at once.
#pragma once

#include <atomic>

namespace gustlab {

// Becomes true at SIGINT or SIGTERM. The first call installs the handlers.
const std::atomic<bool>& interrupted();

}  // namespace gustlab
