#!/usr/bin/env bash
# flies experiments/ci_small.toml and compares every run with experiments/ci_small.baseline.csv; fails when one is worse.
# usage: scripts/gate.sh [--update]    (--update makes these flights the baseline)    GUSTLAB: another program than the built one
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

gustlab="${GUSTLAB:-build/release/gustlab}"
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
"$gustlab" sweep ci_small --out "$out/sweep"
"$gustlab" gate "$out/sweep" --baseline experiments/ci_small.baseline.csv "$@"
