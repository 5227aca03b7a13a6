#!/bin/bash
# A Slurm of one node on this machine, for benches/sweeps/slurm.py: no systemd, as root, in a folder of its own.
#
#     apt-get install slurm-wlm munge && benches/sweeps/slurm.sh FOLDER CPUS    # stops with: ... FOLDER stop
set -euo pipefail
folder=$(realpath -m "$1")
if [ "${2:-}" = stop ]; then
    for service in slurmctld slurmd munged; do
        if [ -s "$folder/$service.pid" ]; then kill "$(cat "$folder/$service.pid")" || true; fi
    done
    exit 0
fi
mkdir -p "$folder"/{spool,state}
chmod 755 "$folder"
host=$(hostname -s)
install -d -o munge -g munge -m 755 "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=128 count=1 status=none
chown munge: "$folder/munge/key"
chmod 400 "$folder/munge/key"
cat > "$folder/slurm.conf" <<END
ClusterName=loopback
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ReturnToService=2
KillWait=2
JobRequeue=1
MpiDefault=none
SchedulerParameters=batch_sched_delay=0,sched_interval=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF="$folder/slurm.conf"
runuser -u munge -- munged --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/munged.pid" --log-file="$folder/munge/munged.log" --seed-file="$folder/munge/seed"
ln -sf munge/munged.pid "$folder/munged.pid"
slurmctld
slurmd
for _ in $(seq 60); do
    if sinfo -h -o %t 2> /dev/null | grep -q -e idle -e mix; then
        echo "export SLURM_CONF=$SLURM_CONF"
        exit 0
    fi
    sleep 0.5
done
echo "the node did not come up: $folder/slurmd.log" >&2
exit 1
