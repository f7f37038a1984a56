#!/usr/bin/env bash
# submit.sh SHARDS OUT PROGRAM ARGUMENT..: runs midair-bake or midair-sweep (PROGRAM with its arguments, but for --shard and --out)
# as a Slurm job array of SHARDS tasks, one core each, and after them a job that merges their parts to OUT. Prints the number of
# the merging job. Needs a folder of OUT, and a PROGRAM and files that it reads, which all nodes see under the same names.
#     samples/cluster/slurm/submit.sh 100 star.midair build/bin/midair-bake star.osgt --frames 0:100000 --fps 60
# A task that is killed is queued again and goes on with what it has. Options for sbatch (partition, time, account) come by
# Slurm's own variables, SBATCH_PARTITION and the like. MIDAIR_RETRIES: how often a task is queued again, 5.
set -euo pipefail
[ $# -ge 4 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
shards=$1 out=$2 program=$3
shift 3
parts=$out.parts
mkdir -p "$parts"
# Processors may differ from node to node, and the last digits of fields with them: one instruction set for all.
export OSG_MIDAIR_SIMD=${OSG_MIDAIR_SIMD:-avx2}
array=$(sbatch --parsable --job-name=midair --array="1-$shards" --cpus-per-task=1 --requeue --open-mode=append \
    --output="$parts/%a.log" "$here/shard.sh" "$shards" "$parts" "$program" "$@")
sbatch --parsable --job-name=midair-merge --dependency="afterok:$array" --kill-on-invalid-dep=yes --cpus-per-task=1 --requeue \
    --output="$parts/merge.log" "$here/merge.sh" "$shards" "$parts" "$program" "$out"
