#!/usr/bin/env bash
# sets up, builds and makes the tables and figures. usage: scripts/reproduce.sh [output folder]
set -euo pipefail
out="$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../out/reproduce}")"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
scripts/build.sh release gustlab

gustlab=build/release/gustlab
for experiment in experiments/table*.toml; do
  name="$(basename "$experiment" .toml)"
  "$gustlab" sweep "$experiment" --out "$out/$name" --resume
  for format in md csv latex json; do
    "$gustlab" table "$out/$name" --format "$format" > "$out/$name/table.${format/latex/tex}"
  done
  cat "$out/$name/table.md"
done
