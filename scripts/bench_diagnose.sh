#!/usr/bin/env bash
# times `gustlab diagnose`: one trial of the simulator logged at 100, 200 and 500 Hz, and recorded sets.
# usage: scripts/bench_diagnose.sh [--against OLD_BINARY] [--jobs N] [SET...]
# A SET is a folder with fit_*.csv and holdout_*.csv, as scripts/prove/families.py lays out recorded flights.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ -x .venv/bin/python ]] || scripts/setup.sh
scripts/build.sh release gustlab
exec .venv/bin/python scripts/prove/bench_diagnose.py "$@"
