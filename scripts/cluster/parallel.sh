#!/usr/bin/env bash
# flies a sweep as N shards with GNU parallel, here or on other machines, and merges them. Run again, it goes on.
# usage: scripts/cluster/parallel.sh N EXPERIMENT OUT [parallel option...]
#   as --jobs 4, or --sshloginfile hosts.txt where all machines see OUT and this folder under the same names
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
(($# >= 3)) || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
parts="$1" experiment="$2" out="$(realpath -m "$3")"

parallel --halt soon,fail=1 "${@:4}" "$here/shard.sh" {} "$parts" "$experiment" "$out" --jobs 1 ::: $(seq "$parts")
"$here/merge.sh" "$parts" "$out"
