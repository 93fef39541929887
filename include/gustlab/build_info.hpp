#pragma once

#include <string_view>

namespace gustlab {

/// What this binary was built from; goes into `--version` and into the provenance of every result.
struct BuildInfo {
  std::string_view version;  ///< of the project, e.g. "0.1.0"
  std::string_view commit;   ///< 12 hex digits, "-dirty" behind them if tracked files differ; "unknown" without git
  std::string_view mujoco_version;  ///< of the headers, e.g. "4.0.1"
  std::string_view compiler;        ///< e.g. "GNU 12.2.0"
  std::string_view flags;           ///< those that can change a result: optimisation, floating point, sanitizers
};

const BuildInfo& build_info();

/// Absolute path of the source tree this binary was built from. For finding models/, configs/ and experiments/ when
/// running from a build tree; never for output.
std::string_view source_directory();

}  // namespace gustlab
