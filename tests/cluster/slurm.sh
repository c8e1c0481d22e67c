#!/bin/bash
# A sweep as a Slurm job array on this machine alone (munge, slurmctld, slurmd on loopback): a task is
# killed and submitted anew, and the merged shards must give the bytes of one run. As root, with Debian's
# slurm-wlm and munge.
#
#   tests/cluster/slurm.sh [PROGRAM]         (default: target/release/impactscope)
set -euo pipefail
program=$(realpath "${1:-target/release/impactscope}")
script=$(realpath "$(dirname "$0")/sweep.sbatch")
folder=$(mktemp -d)
chmod 755 "$folder"
host=$(hostname -s)
cores=$(nproc)
cat > "$folder/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
ReturnToService=2
MpiDefault=none
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cores State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
mkdir -p "$folder/state" "$folder/spool" /run/munge
chown munge: /run/munge
[ -s /etc/munge/munge.key ] || (umask 077; head -c 1024 /dev/urandom > /etc/munge/munge.key; chown munge: /etc/munge/munge.key)
started=()
stop() {
    for file in slurmd slurmctld; do
        [ -s "$folder/$file.pid" ] && kill "$(cat "$folder/$file.pid")" || true
    done
    for process in "${started[@]}"; do kill "$process" 2>/dev/null || true; done
    # The controller writes its state while it ends.
    for _ in $(seq 50); do
        [ -e "$folder/slurmctld.pid" ] || [ -e "$folder/slurmd.pid" ] || break
        sleep 0.2
    done
    rm -rf "$folder"
}
trap stop EXIT
if ! munge -n > /dev/null 2>&1; then
    setpriv --reuid munge --regid munge --clear-groups munged --foreground --pid-file /run/munge/test.pid &
    started+=($!)
    sleep 1
fi
slurmctld
sleep 2
slurmd
for _ in $(seq 30); do
    sinfo -h -o %T 2>/dev/null | grep -q idle && break
    sleep 1
done
sinfo

cd "$folder"
count=6
arguments=(--grid f=5:100:120Hz,V=2:9:100V --measure "regime,contact,peak,drive_work")
export IMPACTSCOPE=$program SHARDS=$folder/shards SHARD_COUNT=$count
"$program" sweep "${arguments[@]}" --out whole.csv
job=$(sbatch --parsable --array=1-$count "$script" "${arguments[@]}")
# The first task that runs is killed, as by a node that fails.
for _ in $(seq 100); do
    task=$(squeue -h -j "$job" -t RUNNING -r -o %i | head -1)
    [ -n "$task" ] && break
    sleep 0.1
done
scancel --signal=KILL --full "$task"
echo "killed $task"
wait_for() { while [ -n "$(squeue -h -j "$1")" ]; do sleep 1; done; }
wait_for "$job"
missing=$(for i in $(seq $count); do [ -s "shards/$i-of-$count.csv" ] || echo "$i"; done | paste -sd,)
echo "missing after the first array: ${missing:-none}"
if [ -n "$missing" ]; then
    again=$(sbatch --parsable --array="$missing" "$script" "${arguments[@]}")
    wait_for "$again"
fi
"$program" sweep --merge shards/*.csv --out merged.csv
cmp whole.csv merged.csv
echo "slurm: $count shards, one killed and submitted anew: the same $(wc -c < merged.csv) bytes as one run"
