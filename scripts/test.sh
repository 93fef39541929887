#!/usr/bin/env bash
# sets up, builds and runs all tests; the last lines are ctest's summary. usage: scripts/test.sh [ctest option...]
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh --test
scripts/build.sh release
ctest --test-dir build/release --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
