#!/usr/bin/env bash
# one task of the array job of slurm.sh, which copies this file: the folder of the scripts is an argument
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$1" parts="$2" experiment="$3" out="$4"
# a signal may come before the child is there, or before it heeds signals: it is kept for it, and who dies of it was interrupted
child="" asked=0
trap 'asked=1; [[ -z $child ]] || kill -s USR1 "$child" 2> /dev/null' TERM USR1
"$here/shard.sh" "$SLURM_ARRAY_TASK_ID" "$parts" "$experiment" "$out" --jobs "${SLURM_CPUS_ON_NODE:-1}" &
child=$!
((asked)) && kill -s USR1 "$child" 2> /dev/null
code=0
while wait "$child"; code=$?; kill -0 "$child" 2> /dev/null; do :; done
((asked && code > 128)) && code=130
# interrupted, and not finished: again, from where the store stands. A busy controller says "try again later", and a task that ends
# without it takes the merge with it.
((code == 130)) && for _ in {1..30}; do
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID" && break
  sleep 1
done
exit "$code"
