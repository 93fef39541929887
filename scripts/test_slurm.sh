#!/usr/bin/env bash
# brings up a real Slurm on this host alone, flies a sweep as an array job, kills and requeues a task, merges, and compares the
# bytes with a sweep that no scheduler saw. Stops what it started. Needs root, slurm-wlm and munge; no systemd.
# usage: scripts/test_slurm.sh    GUSTLAB: another program than the built one; REPLICATES: of each cell
set -euo pipefail
case "${1:-}" in -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export GUSTLAB="$(realpath "${GUSTLAB:-build/release/gustlab}")"
for program in munged slurmctld slurmd; do
  command -v "$program" > /dev/null || { echo "test_slurm: $program is missing; run scripts/setup.sh --cluster" >&2; exit 4; }
done
((EUID == 0)) || { echo "test_slurm: slurmd runs as root only" >&2; exit 4; }

room="$(mktemp -d)"
chmod 755 "$room"
started=()
stop() {
  # jobs that a failure left, which outlive their daemons; then the controller last, so that it hears of their end
  if [[ -n ${controller:-} ]] && kill -0 "$controller" 2> /dev/null; then
    timeout 20 scancel --quiet --full --signal=KILL --user="$(id -un)" 2> /dev/null || true
    for _ in {1..50}; do [[ -z $(timeout 5 squeue -h -t RUNNING,COMPLETING 2> /dev/null) ]] && break; sleep 0.2; done
  fi
  for pid in "${started[@]}"; do kill "$pid" 2> /dev/null || true; done
  for pid in "${started[@]}"; do wait "$pid" 2> /dev/null || true; done
  rm -rf "$room"
}
trap stop EXIT

# an authentication daemon with a key of its own
mkdir -p "$room"/{state,spool}
dd if=/dev/urandom of="$room/munge.key" bs=1024 count=1 status=none
chmod 600 "$room/munge.key"
munged --foreground --force --key-file="$room/munge.key" --socket="$room/munge.socket" --pid-file="$room/munge.pid" \
  --seed-file="$room/munge.seed" --log-file="$room/munge.log" 2> /dev/null &
started+=($!)

# a controller and a node, both this host, on ports that nothing else has: another process may take one before they do.
# Slurm lets a task that was queued again wait until its old credential is out of date (cred_expire), two minutes by default. One
# that is told to start at once (StartTime=now) can meet the node in the second in which that was revoked: "already killed, do not
# launch", and it has failed.
host="$(hostname -s)"
export SLURM_CONF="$room/slurm.conf"
for _ in {1..50}; do [[ -S $room/munge.socket ]] && break; sleep 0.1; done
for attempt in 1 2 3; do
  read -r port1 port2 < <(python3 -c '
import socket
sockets = [socket.create_server(("", 0)) for _ in range(2)]
print(*(s.getsockname()[1] for s in sockets))')
cat > "$SLURM_CONF" << END
ClusterName=gustlab
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=$port1
SlurmdPort=$port2
AuthType=auth/munge
AuthInfo=socket=$room/munge.socket,cred_expire=5
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1
StateSaveLocation=$room/state
SlurmdSpoolDir=$room/spool
SlurmctldPidFile=$room/slurmctld.pid
SlurmdPidFile=$room/slurmd.pid
SlurmctldLogFile=$room/slurmctld.log
SlurmdLogFile=$room/slurmd.log
ReturnToService=2
KillWait=5
NodeName=$host NodeAddr=127.0.0.1 CPUs=2
PartitionName=all Nodes=$host Default=YES MaxTime=10
END
  slurmctld -D 2> /dev/null & controller=$!
  slurmd -D -N "$host" 2> /dev/null & node=$!
  for _ in {1..100}; do
    kill -0 "$controller" 2> /dev/null && kill -0 "$node" 2> /dev/null || break
    [[ $(timeout 5 sinfo -h -o %t 2> /dev/null) == idle ]] && break 2
    sleep 0.2
  done
  kill "$controller" "$node" 2> /dev/null || true
  wait "$controller" "$node" 2> /dev/null || true
  ((attempt < 3)) || { cat "$room"/slurm*.log >&2; echo "test_slurm: the node does not come up" >&2; exit 4; }
done
started+=("$node" "$controller")

# four tasks, of which the first is interrupted, and the second killed and queued again
parts=4
sed "s/^replicates = .*/replicates = ${REPLICATES:-2000}/" experiments/ci_small.toml > "$room/small.toml"
"$GUSTLAB" sweep "$room/small.toml" --out "$room/alone"
read -r array merge < <(scripts/cluster/slurm.sh "$parts" "$room/small.toml" "$room/out" --cpus-per-task=1)
flies() { [[ -f $room/out/shards/$1/runs.sqlite-wal ]]; }
until flies 1 && flies 2; do sleep 0.05; done
# right after its start a task cannot be signalled yet, and scancel says "try again later" of signals that it has sent, too
for _ in {1..60}; do
  grep -qs "go on with --resume" "$room/out/log/1.txt" && break
  timeout 2 scancel --quiet --signal=USR1 --batch "${array}_1" 2> /dev/null || true
  sleep 0.5
done
for _ in {1..100}; do scontrol requeue "${array}_2" && break; sleep 0.2; done
for _ in {1..600}; do
  # a controller that does not answer says nothing of the queue
  queued="$(squeue -h -j "$merge" 2> /dev/null)" && [[ -z $queued ]] && break
  sleep 0.5
done
grep -h "go on with --resume" "$room"/out/log/1.txt || { echo "test_slurm: task 1 was not interrupted" >&2; exit 1; }
[[ -f $room/out/whole/runs.csv ]] || { tail -n 5 "$room"/out/log/*.txt >&2; echo "test_slurm: no merge" >&2; exit 1; }
cmp "$room/alone/runs.csv" "$room/out/whole/runs.csv"
echo "test_slurm: $(($(wc -l < "$room/alone/runs.csv") - 1)) runs, one task interrupted, one killed, and the same bytes" >&2
