#!/usr/bin/env bash
# flies experiments/ci_small.toml and compares every run with experiments/ci_small.baseline.csv; fails when one is worse.
# usage: scripts/gate.sh [--update]    (--update makes these flights the baseline)    GUSTLAB: another program than the built one
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

gustlab="${GUSTLAB:-build/release/gustlab}"
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT
"$gustlab" sweep ci_small --out "$out/sweep"
"$gustlab" gate "$out/sweep" --baseline experiments/ci_small.baseline.csv "$@"
