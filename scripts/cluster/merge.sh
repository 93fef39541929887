#!/usr/bin/env bash
# joins OUT/shards/1..N into OUT/whole, each [[variant]] into a folder of its own; a shard that is missing is an error (exit 3).
# usage: scripts/cluster/merge.sh N OUT    GUSTLAB: another program than the built one
# Run again, it says that the same whole stands there; another one is never overwritten.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
gustlab="${GUSTLAB:-$here/../../build/release/gustlab}"
(($# == 2)) && [[ $1 =~ ^[1-9][0-9]*$ ]] || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
parts="$1" out="$2"

# of every shard: a store, or one for each variant
variants=()
for ((part = 1; part <= parts; ++part)); do
  stores=()
  for store in "$out/shards/$part"/{,*/}runs.sqlite; do [[ ! -f $store ]] || stores+=("$store"); done
  ((${#stores[@]})) || { echo "merge: $out/shards/$part: shard $part of $parts is missing; fly it with shard.sh $part $parts" >&2; exit 3; }
  for store in "${stores[@]}"; do variants+=("$(dirname "${store#"$out/shards/$part/"}")"); done
done

scratch="$(mktemp -d)"
trap 'rm -rf "$scratch"' EXIT
while IFS= read -r variant; do
  whole="$out/whole/$variant" shards=()
  for ((part = 1; part <= parts; ++part)); do shards+=("$out/shards/$part/$variant"); done
  if [[ ! -e $whole/runs.sqlite ]]; then
    "$gustlab" merge "${shards[@]}" --out "$whole"
    continue
  fi
  # the same rows may stand in a store of other bytes: runs.csv is what a whole is known by
  "$gustlab" merge "${shards[@]}" --out "$scratch/$variant"
  cmp -s "$scratch/$variant/runs.csv" "$whole/runs.csv" ||
    { echo "merge: ${whole%/.}: results of other runs are there (a merge never overwrites); move them away" >&2; exit 2; }
  echo "merge: ${whole%/.}: the same shards are merged there already" >&2
done < <(printf '%s\n' "${variants[@]}" | sort -u)
