#!/usr/bin/env bash
# flies a sweep as one shard per rank with Open MPI, and merges them; run again, it goes on.
# usage: scripts/cluster/mpi.sh N EXPERIMENT OUT [mpirun option...]
# The rank is Open MPI's own: every rank that mpirun starts below Slurm sees SLURM_PROCID 0.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
(($# >= 3)) || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
parts="$1" experiment="$2" out="$(realpath -m "$3")"

mpirun -n "$parts" "${@:4}" bash -c '"$0/shard.sh" "$((OMPI_COMM_WORLD_RANK + 1))" "$1" "$2" "$3" --jobs 1' \
  "$here" "$parts" "$experiment" "$out"
"$here/merge.sh" "$parts" "$out"
