#!/usr/bin/env bash
# do two programs diagnose alike, byte for byte? prints each difference and exits 1 when there is one.
# usage: scripts/same_diagnoses.sh BEFORE AFTER [--full] [--only NAME,NAME] [--jobs N] [--work DIR]   (see scripts/prove/same_diagnoses.py)
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ -x .venv/bin/python ]] || scripts/setup.sh
[[ -x build/release/tests/reality/reality ]] || scripts/build.sh release reality
exec .venv/bin/python scripts/prove/same_diagnoses.py "$@"
