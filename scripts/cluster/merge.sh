#!/usr/bin/env bash
# joins OUT/shards/1..N into OUT/whole, each [[variant]] into a folder of its own; a shard that is missing is an error, and what was
# joined before stays as it is.
# usage: scripts/cluster/merge.sh N OUT    GUSTLAB: another program than the built one
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
gustlab="${GUSTLAB:-$here/../../build/release/gustlab}"
(($# == 2)) || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
parts="$1" out="$2"

for store in "$out"/shards/1/runs.sqlite "$out"/shards/1/*/runs.sqlite; do
  [[ -f $store ]] || continue
  found=yes variant="$(dirname "${store#"$out"/shards/1/}")"
  shards=()
  for ((part = 1; part <= parts; ++part)); do shards+=("$out/shards/$part/$variant"); done
  if [[ -f $out/whole/$variant/runs.sqlite ]]; then
    echo "merge: $out/whole/$variant is there already" >&2
    continue
  fi
  "$gustlab" merge "${shards[@]}" --out "$out/whole/$variant"
done
[[ -n ${found:-} ]] || { echo "merge: $out/shards/1: no runs.sqlite of a shard is there" >&2; exit 3; }
