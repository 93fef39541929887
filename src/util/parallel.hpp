// The one way to use several cores: independent calls, numbered, in no order.
#pragma once

#include <cstdint>
#include <functional>

namespace gustlab {

// Calls body(i) once for each i in [0, count), on at most `jobs` threads (this one included; jobs ≥ 1), and returns when
// every call has ended. The order of the calls is not defined: for results that do not depend on the number of threads,
// body writes to a place of its own for each i. When a body throws, calls that have not begun are dropped and one of the
// exceptions is thrown here. To stop early, let the body return at once.
void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body);

// Number of threads when the user names none.
int default_jobs();

}  // namespace gustlab
