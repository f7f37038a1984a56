#!/usr/bin/env bash
# A task of the job array that submit.sh makes: shard.sh SHARDS PARTS PROGRAM ARGUMENT..
set -uo pipefail
shards=$1 parts=$2 program=$3
shift 3
task=$SLURM_ARRAY_TASK_ID
"$program" "$@" --shard "$task/$shards" --out "$parts/$task.part"
status=$?
# 1: all is silent, or rows could not be solved; it was told, and the part is whole.
[ $status -gt 1 ] || exit 0
# Ended by a signal (a node without memory, an impatient administrator): again, with what is done. Slurm itself does that only when
# a node fails or a job is preempted.
if [ $status -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt "${MIDAIR_RETRIES:-5}" ]; then
    echo "shard $task/$shards was ended by signal $((status - 128)); queued again"
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$task"
    sleep 60 # until Slurm ends this run
fi
exit $status
