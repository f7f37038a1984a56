#!/usr/bin/env bash
# tests/cluster/run.sh BIN: bakes and sweeps on a Slurm of one machine (a controller and a node's daemon of their own, in a folder
# of their own) and by GNU parallel, with a task that is killed, and compares with the bytes of one process. BIN: folder of the
# built programs. Needs root, as Slurm's daemons do; tests/run.sh --cluster installs what it takes.
set -euo pipefail
bin=$(cd "$1" && pwd)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ "$(id -u)" = 0 ] || { echo "tests/cluster/run.sh: Slurm's daemons need root" >&2; exit 1; }
work=$(mktemp -d "${TMPDIR:-/tmp}/midair-cluster-XXXXXX")
export SLURM_CONF=$work/slurm.conf
export OSG_MIDAIR_SIMD=plain # as every processor has it
munge=""
finish()
{
    local daemons=("$munge") pid
    for name in slurmd slurmctld; do [ ! -s "$work/$name.pid" ] || daemons+=("$(cat "$work/$name.pid")"); done
    for pid in "${daemons[@]}"; do [ -z "$pid" ] || kill "$pid" 2>/dev/null || true; done
    # They write into the folder until they have ended, which is soon.
    for ((i = 0; i < 50; ++i)); do
        for pid in "${daemons[@]}"; do
            [ -z "$pid" ] || [ ! -r "/proc/$pid/status" ] || grep -q "^State:.Z" "/proc/$pid/status" || { sleep 0.2; continue 2; }
        done
        break
    done
    [ "${1:-1}" = 0 ] || tail -n 30 "$work"/*.log "$work"/*/*.log 2>/dev/null || true
    rm -rf "$work" || true
}
trap 'finish $?' EXIT

echo "== a Slurm of one machine"
if ! munge -n >/dev/null 2>&1; then
    mkdir -p /run/munge
    chown munge:munge /run/munge
    runuser -u munge -- munged
    munge=$(cat /run/munge/munged.pid)
fi
name=$(hostname)
cat >"$SLURM_CONF" <<CONF
ClusterName=midair
SlurmctldHost=$name(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=cred_expire=5
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmUser=root
SelectType=select/cons_tres
ReturnToService=2
SchedulerParameters=sched_interval=2
NodeName=$name NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
mkdir -p "$work/state" "$work/spool"
slurmctld -f "$SLURM_CONF"
slurmd -f "$SLURM_CONF"
for ((i = 0; i < 60; ++i)); do
    [ "$(sinfo -h -o %T 2>/dev/null)" != idle ] || break
    sleep 0.5
done
sinfo -h -o "%D node, %c cores, %T"

# The same, small: a shard takes some seconds, so that there is something to kill.
frames=0:400
bake=("$bin/midair-bake" "$root/samples/scenes/animation.osgt" --frames "$frames" --fps 60 --chunk 5)
echo "== one process"
"${bake[@]}" --out "$work/one.midair" --quiet

# until SECONDS TEXT COMMAND..: waits until the command succeeds.
until_true()
{
    local limit=$1 what=$2
    shift 2
    for ((i = 0; i < limit * 20; ++i)); do
        if "$@" >/dev/null 2>&1; then return 0; fi
        sleep 0.05
    done
    echo "tests/cluster/run.sh: not within $limit s: $what" >&2
    exit 1
}
size_above() { [ "$(stat -c %s "$1")" -gt "$2" ]; }
pid_of_part() { fuser "$1" 2>/dev/null | tr -d ' '; }
ended() { [ -z "$(squeue -h -j "$1" -o %i 2>/dev/null)" ]; }

echo "== a job array of four tasks, of which the second is killed"
cd "$work"
job=$("$root/samples/cluster/slurm/submit.sh" 4 "$work/slurm.midair" "${bake[@]}")
part=$work/slurm.midair.parts/2.part
until_true 120 "task 2 has begun" size_above "$part" 4000
victim=$(pid_of_part "$part")
kill -9 "$victim"
echo "killed process $victim at $(stat -c %s "$part") bytes"
until_true 300 "the merging job has ended" ended "$job"
grep -h "queued again" "$work"/slurm.midair.parts/2.log
grep -h "chunks; continuing" "$work"/slurm.midair.parts/2.log
cmp "$work/one.midair" "$work/slurm.midair"
echo "the same bytes as one process: $(stat -c %s "$work/slurm.midair") bytes"

echo "== GNU parallel, of which one process is killed"
"$root/samples/cluster/parallel/run.sh" 2/: 4 "$work/parallel.midair" "${bake[@]}" &
run=$!
part=$work/parallel.midair.parts/1.part
until_true 120 "shard 1 has begun" size_above "$part" 4000
victim=$(pid_of_part "$part")
kill -9 "$victim"
echo "killed process $victim"
wait "$run"
cmp "$work/one.midair" "$work/parallel.midair"
echo "the same bytes as one process"

echo "== a sweep on Slurm"
cat >"$work/table.json" <<'JSON'
{"common": {"array": "board", "model": "MODEL", "size": "0.04", "max-points": 20, "position": "0 0 0.15"},
 "cross": {"solver": ["gauss-newton", "gs"], "temperature": [10, 15, 20, 25, 30], "rmsTolerance": [1e-3, 1e-2], "loudness": [1, 0.5]}}
JSON
sed -i "s|MODEL|$root/samples/models/star.obj|" "$work/table.json"
"$bin/midair-sweep" "$work/table.json" --out "$work/one.csv" --quiet
job=$("$root/samples/cluster/slurm/submit.sh" 2 "$work/slurm.csv" "$bin/midair-sweep" "$work/table.json" --quiet)
until_true 300 "the sweep's merging job has ended" ended "$job"
cmp "$work/one.csv" "$work/slurm.csv"
echo "the same bytes as one process: $(wc -l <"$work/slurm.csv") lines"
finish 0
trap - EXIT
