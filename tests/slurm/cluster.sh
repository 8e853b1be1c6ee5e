#!/usr/bin/env bash
# A private Slurm cluster on this machine, all of whose files are in one folder.
#   cluster.sh up DIR NODES CPUS   start it; use it with: export SLURM_CONF=DIR/slurm.conf
#   cluster.sh controller DIR      stop its controller, and start it again
#   cluster.sh down DIR            stop it
# It wants slurmctld, slurmd, slurm-client and munge (Debian's packages), and root, as whom several slurmd may share a machine.
set -euo pipefail
verb=$1 folder=$(realpath -m "$2")

# Stop a daemon. It has a minute to write down its state: what is killed before forgets which tasks run.
stop() {
    local pid
    [ -f "$1" ] || return 0
    pid=$(cat "$1")
    kill "$pid" 2>/dev/null || return 0
    for _ in $(seq 600); do
        kill -0 "$pid" 2>/dev/null || return 0
        sleep 0.1
    done
    kill -9 "$pid" 2>/dev/null || true
}

configure() {
    local nodes=$1 cpus=$2 host i
    host=$(hostname -s)
    cat <<CONF
ClusterName=scree
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=17917
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/run/munge.sock,cred_expire=5
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/run/slurmctld.pid
SlurmdPidFile=$folder/run/slurmd-%n.pid
SlurmctldLogFile=$folder/log/slurmctld.log
SlurmdLogFile=$folder/log/slurmd-%n.log
MpiDefault=none
SwitchType=switch/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=2,batch_sched_delay=0,sched_min_interval=0
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmdParameters=config_overrides
ReturnToService=2
SlurmctldTimeout=30
SlurmdTimeout=30
KillWait=2
MinJobAge=300
MaxArraySize=1001
JobRequeue=1
CONF
    for i in $(seq "$nodes"); do
        echo "NodeName=node$i NodeHostname=$host NodeAddr=127.0.0.1 Port=$((17920 + i)) CPUs=$cpus RealMemory=4000 State=UNKNOWN"
    done
    echo "PartitionName=main Nodes=node[1-$nodes] Default=YES MaxTime=INFINITE State=UP"
}

case $verb in
up)
    nodes=$3 cpus=$4
    mkdir -p "$folder"/{state,spool,log,run,munge}
    chmod 755 "$folder" "$folder/run"
    chmod 700 "$folder/munge"
    [ -f "$folder/munge/key" ] || head -c 128 /dev/urandom >"$folder/munge/key"
    chmod 600 "$folder/munge/key"
    munged --key-file="$folder/munge/key" --socket="$folder/run/munge.sock" --pid-file="$folder/run/munged.pid" \
        --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" --num-threads=2
    configure "$nodes" "$cpus" >"$folder/slurm.conf"
    export SLURM_CONF=$folder/slurm.conf
    slurmctld -f "$SLURM_CONF"
    for i in $(seq "$nodes"); do slurmd -f "$SLURM_CONF" -N "node$i"; done
    for _ in $(seq 200); do
        if [ "$(sinfo -h -N -o %T 2>/dev/null | grep -c '^idle$' || true)" = "$nodes" ]; then
            exit 0
        fi
        sleep 0.1
    done
    echo "the cluster did not come up" >&2
    tail -n 5 "$folder"/log/*.log >&2
    exit 1
    ;;
controller)
    export SLURM_CONF=$folder/slurm.conf
    stop "$folder/run/slurmctld.pid"
    slurmctld -f "$SLURM_CONF"
    ;;
down)
    for pid in "$folder"/run/slurmd-*.pid "$folder/run/slurmctld.pid" "$folder/run/munged.pid"; do stop "$pid"; done
    ;;
*)
    echo "expected up, controller or down" >&2
    exit 2
    ;;
esac
