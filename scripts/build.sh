#!/usr/bin/env bash
# builds build/<preset>/gustlab. usage: scripts/build.sh [release|debug|asan|tsan] [target...]
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
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

# a build tree knows where it was made: when the checkout was moved or copied, it is configured afresh (objects are kept)
cache="build/$preset/CMakeCache.txt"
if [[ -f $cache ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$cache"; then
  echo "build: build/$preset was made in another place: configuring it again" >&2
  rm -rf "$cache" "build/$preset/CMakeFiles" "build/$preset/build.ninja"
fi
[[ -f build/$preset/build.ninja ]] || cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" "${targets[@]}"
