#!/usr/bin/env bash
# sets up, builds and makes the paper's tables and figures. usage: scripts/reproduce.sh [output folder]
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
out="$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../out/reproduce}")"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
scripts/build.sh release gustlab

gustlab=build/release/gustlab
python=.venv/bin/python
"$gustlab" reproduce all --out "$out"

# tables of one experiment, and its first seeded gust flown by each controller on each trajectory
show() {
  local experiment="$1" flights=() trajectory controller replicate
  for format in md csv latex json; do
    "$gustlab" table "$out/$experiment" --format "$format" > "$out/$experiment/table.${format/latex/tex}"
  done
  while IFS=, read -r trajectory controller replicate _; do
    [[ $replicate == 1 ]] || continue
    flights+=("$out/$experiment/flights/${trajectory}_$controller")
    "$gustlab" run "$experiment" --trajectory "$trajectory" --controller "$controller" --replicate 1 --quiet \
      --out "${flights[-1]}"
  done < <("$gustlab" sweep "$experiment" --dry-run)
  "$python" scripts/plot_overlay.py "${flights[@]}" --out "$out/figures/${experiment}_paths"
}

sweeps=() shown=()
for experiment in table1_iris table2_crazyflie table3_real_proxy; do
  sweeps+=("$out/$experiment")
  show "$experiment" &
  shown+=($!)
done
for one in "${shown[@]}"; do wait "$one"; done
"$python" scripts/plot_heatmap.py "${sweeps[@]}" --out "$out/figures"
echo "tables and figures: $out" >&2
