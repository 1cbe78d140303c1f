#!/usr/bin/env bash
# Starts a Slurm cluster of this machine alone, to try the scripts of this folder.
#
# usage: scripts/slurm/test_cluster.sh start DIR | stop DIR
#
# Needs slurmctld, slurmd, munged (Debian: apt-get install slurm-wlm munge) and root. Everything is kept in DIR; commands of Slurm find the
# cluster with SLURM_CONF=DIR/slurm.conf. It has two CPUs, whatever the machine has.
set -euo pipefail

fail() {
    printf 'test_cluster: %s\n' "$*" >&2
    exit 2
}

case "$#:${1-}" in
    1:-h | 1:--help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;;
    2:start | 2:stop) ;;
    *) fail "unknown arguments '$*'; usage: scripts/slurm/test_cluster.sh start DIR | stop DIR" ;;
esac
mkdir -p "$2"
dir=$(cd "$2" && pwd)
readonly dir
export SLURM_CONF=$dir/slurm.conf PATH=$PATH:/usr/sbin:/sbin

# Ends what was started, by the numbers of the processes in DIR.
stop() {
    local name pid
    for name in slurmd slurmctld munged; do
        [[ -s $dir/$name.pid ]] || continue
        pid=$(<"$dir/$name.pid")
        kill "$pid" 2>/dev/null || true
        for _ in {1..50}; do
            kill -0 "$pid" 2>/dev/null || break
            sleep 0.1
        done
        kill -9 "$pid" 2>/dev/null || true
        rm -f "$dir/$name.pid"
    done
}

if [[ $1 = stop ]]; then
    stop
    exit 0
fi

for program in slurmctld slurmd munged sinfo; do
    command -v "$program" >/dev/null || fail "$program is missing; on Debian: apt-get install slurm-wlm munge"
done
[[ $(id -u) -eq 0 ]] || fail "root is needed to start slurmd"
host=$(hostname -s)
# Ports that other clusters of this machine do not have: from the number of this process.
port=$((20000 + $$ % 20000))
mkdir -p "$dir"/{state,spool}
chmod 0755 "$dir"
(umask 077 && head -c 128 /dev/urandom >"$dir/munge.key")
cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CryptoType=crypto/munge
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SwitchType=switch/none
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,bf_interval=1
JobAcctGatherType=jobacct_gather/none
ReturnToService=2
MinJobAge=300
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
END

trap 'tail -n 5 "$dir"/*.log >&2; stop' ERR
munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" \
    --log-file="$dir/munged.log" --seed-file="$dir/munge.seed"
slurmctld -f "$SLURM_CONF"
# As many CPUs as slurm.conf says, not as there are.
slurmd -f "$SLURM_CONF" -N "$host"
for _ in {1..100}; do
    state=$(sinfo -h -o %T 2>/dev/null || true)
    [[ $state != idle ]] || break
    sleep 0.2
done
[[ $state = idle ]] || {
    tail -n 5 "$dir"/slurm*.log >&2
    stop
    fail "the node did not come up, its state is '${state:-unknown}'"
}
echo "ready: SLURM_CONF=$SLURM_CONF"
