#!/usr/bin/env bash
# sets up, builds and runs all tests; the last lines are ctest's summary. usage: scripts/test.sh [ctest option...]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh --test
scripts/build.sh release
ctest --test-dir build/release --output-on-failure --no-tests=error --parallel "$(nproc)" "$@"
