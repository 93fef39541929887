#!/usr/bin/env bash
# the job of slurm.sh that runs after all tasks
exec "$1/merge.sh" "$2" "$3"
