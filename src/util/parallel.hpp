// The one way to use several cores: independent calls, numbered, in no order.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace gustlab {

// Calls body(i) once for each i in [0, count), on at most `jobs` threads (this one included; jobs ≥ 1), and returns when
// every call has ended. The order of the calls is not defined: for results that do not depend on the number of threads,
// body writes to a place of its own for each i. When a body throws, calls that have not begun are dropped and one of the
// exceptions is thrown here; so is Interrupted once the program is asked to stop.
void parallel_for(std::int64_t count, int jobs, const std::function<void(std::int64_t)>& body);

// Number of threads when the user names none: the CPUs that this process may use, by its affinity and its control group.
int default_jobs();
// CPUs that a control group allows (cgroups 7): `cgroup_list` as /proc/self/cgroup, groups mounted at `mounted_at`.
// Infinite without a limit.
double cpu_quota(const std::string& cgroup_list, const std::string& mounted_at);

}  // namespace gustlab
