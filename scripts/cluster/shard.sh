#!/usr/bin/env bash
# flies shard I of N of an experiment into OUT/shards/I, or goes on where that stands; every scheduler below runs this.
# usage: scripts/cluster/shard.sh I N EXPERIMENT OUT [sweep option...]    GUSTLAB: another program than the built one
# N is said, never asked of the scheduler: a task that Slurm runs again says that there is one task.
# SIGTERM and SIGUSR1 let the runs in hand end; then it exits with 130, and a task that is started again goes on.
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
here="$(dirname "$(realpath "${BASH_SOURCE[0]}")")"
gustlab="${GUSTLAB:-$here/../../build/release/gustlab}"
(($# >= 4)) || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
part="$1" parts="$2" experiment="$3" out="$4"

# a shell ends a signal's wait, not the program: it is passed on, and waited for again. One that comes before the program is there
# is kept for it, and a program that dies of it, because it does not heed signals yet, was interrupted too.
child="" asked=0
trap 'asked=1; [[ -z $child ]] || kill -s USR1 "$child" 2> /dev/null || true' TERM INT USR1
"$gustlab" sweep "$experiment" --out "$out/shards/$part" --shard "$part/$parts" --resume "${@:5}" &
child=$!
((!asked)) || kill -s USR1 "$child" 2> /dev/null || true
code=0
wait "$child" || code=$?
while kill -0 "$child" 2> /dev/null; do
  code=0
  wait "$child" || code=$?
done
((asked && code > 128)) && code=130
exit "$code"
