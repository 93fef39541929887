#!/usr/bin/env bash
# sets up, builds and makes the tables and figures. usage: scripts/reproduce.sh [output folder]
set -euo pipefail
out="$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../out/reproduce}")"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
scripts/build.sh release gustlab

gustlab=build/release/gustlab
python=.venv/bin/python
sweeps=()
for experiment in experiments/table*.toml; do
  name="$(basename "$experiment" .toml)"
  sweeps+=("$out/$name")
  "$gustlab" sweep "$experiment" --out "$out/$name" --resume
  for format in md csv latex json; do
    "$gustlab" table "$out/$name" --format "$format" > "$out/$name/table.${format/latex/tex}"
  done

  # the first of the seeded gusts, flown by each controller on each trajectory
  flights=()
  while IFS=, read -r trajectory controller replicate _; do
    [[ $replicate == 1 ]] || continue
    flights+=("$out/$name/flights/${trajectory}_$controller")
    "$gustlab" run "$experiment" --trajectory "$trajectory" --controller "$controller" --replicate 1 --quiet \
      --out "${flights[-1]}"
  done < <("$gustlab" sweep "$experiment" --dry-run)
  "$python" scripts/plot_overlay.py "${flights[@]}" --out "$out/figures/${name}_paths"
done
"$python" scripts/plot_heatmap.py "${sweeps[@]}" --out "$out/figures"

for sweep in "${sweeps[@]}"; do cat "$sweep/table.md"; done
echo "tables and figures: $out" >&2
