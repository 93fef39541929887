#!/usr/bin/env bash
# the job of slurm.sh that runs after all tasks
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
exec "$1/merge.sh" "$2" "$3"
