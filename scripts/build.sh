#!/usr/bin/env bash
# builds build/<preset>/gustlab. usage: scripts/build.sh [release|debug|asan|tsan] [target...]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset="${1:-release}"
case "$preset" in
  release | debug | asan | tsan) ;;
  *) echo "usage: scripts/build.sh [release|debug|asan|tsan] [target...]" >&2; exit 2 ;;
esac
targets=()
if (($# > 1)); then targets=(--target "${@:2}"); fi

# a compiler cache is used where there is one
if [[ -z ${CMAKE_CXX_COMPILER_LAUNCHER:-} ]] && command -v ccache > /dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
fi

[[ -f build/$preset/build.ninja ]] || cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" "${targets[@]}"
