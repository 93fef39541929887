#!/usr/bin/env bash
# proves the diagnosis on trials it has not seen and writes docs/PROOF.md with its figures; see --count, --only.
# usage: scripts/prove.sh [--quick] [--count X] [--seed 9000] [--flights DIR] [--semi-real N] [--only SETS] [--jobs N]   (see scripts/prove/prove.py)
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ -x .venv/bin/python ]] || scripts/setup.sh
scripts/build.sh release gustlab reality
exec .venv/bin/python scripts/prove/prove.py "$@"
