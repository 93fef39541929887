#!/usr/bin/env bash
# submits a sweep to Slurm as an array job of N tasks, and a merge that waits for all of them; prints the two job numbers.
# usage: scripts/cluster/slurm.sh N EXPERIMENT OUT [sbatch option...]    GUSTLAB: another program than the built one
# A minute before its time is up, or when it is preempted, a task ends its runs in hand and is queued again.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
(($# >= 3)) || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
parts="$1" experiment="$2" out="$(realpath -m "$3")"

mkdir -p "$out/log"
array="$(sbatch --parsable --array="1-$parts" --job-name=gustlab --requeue --signal=B:USR1@60 --open-mode=append \
  --output="$out/log/%a.txt" "${@:4}" "$here/slurm_task.sh" "$here" "$parts" "$experiment" "$out")"
merge="$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes --job-name=gustlab-merge \
  --output="$out/log/merge.txt" "${@:4}" "$here/slurm_merge.sh" "$here" "$parts" "$out")"
echo "$array $merge"
