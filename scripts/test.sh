#!/usr/bin/env bash
# sets up, builds and runs the tests; the last lines are ctest's summary. usage: scripts/test.sh [--quick | --all] [ctest option...]
# --quick: no whole diagnoses, no recorded flights, none of the commands end to end (two minutes on two cores, once it is built)
# --all: all trials in which an effect is concealed, not an eighth of them, all wrong inputs, not a quarter, and the slowest diagnoses and commands
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

targets=()
if [[ ${1:-} == --quick ]]; then
  targets=(gustlab quick_tests)
  set -- --label-regex quick "${@:2}"
elif [[ ${1:-} == --all ]]; then
  export GUSTLAB_EVERY_TEST=1
  shift
else
  set -- --label-exclude slow "$@"
fi
scripts/setup.sh --test
scripts/build.sh release "${targets[@]}"
ctest --test-dir build/release --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
