// How far long work is. The work reports it; who shows it, and whether, is the caller's.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

namespace gustlab {

// The stage that begins now, and the share of the whole work that is done (0 to 1, never falling); nothing where nobody knows it. Called from
// one thread.
using ProgressReport = std::function<void(std::string_view stage, std::optional<double> done)>;

}  // namespace gustlab
