#!/usr/bin/env bash
# A task of submit.sh's job array: shard.sh SHARDS PARTS PROGRAM ARGUMENT..
set -uo pipefail
shards=$1 parts=$2 program=$3
shift 3
task=$SLURM_ARRAY_TASK_ID
"$program" "$@" --shard "$task/$shards" --out "$parts/$task.part"
status=$?
# Exit code 1: all frames are silent or rows could not be solved; this was reported, and the part is complete.
[ $status -gt 1 ] || exit 0
# Killed by a signal (out of memory, an administrator): requeue; the part is continued. Slurm itself requeues only if a node fails
# or a job is preempted.
if [ $status -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "${MIDAIR_RETRIES:-5}" ]; then
    echo "shard $task/$shards was ended by signal $((status - 128)); queued again"
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$task"
    sleep 60 # until Slurm ends this run
fi
exit $status
