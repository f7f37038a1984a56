#!/usr/bin/env bash
# submit.sh SHARDS OUT PROGRAM ARGUMENT..: runs midair-bake or midair-sweep (PROGRAM with its arguments, without --shard and --out)
# as a Slurm job array of SHARDS tasks, one core each, then a job that merges their parts into OUT. Prints the number of the
# merging job. All nodes need the same paths for OUT's folder, PROGRAM and its input files.
#     samples/cluster/slurm/submit.sh 100 star.midair build/bin/midair-bake star.osgt --frames 0:100000 --fps 60
# A killed task is requeued and continues its part, up to 5 times (MIDAIR_RETRIES). Set options for sbatch (partition, time,
# account) with Slurm's own variables, such as SBATCH_PARTITION.
set -euo pipefail
[ $# -ge 4 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
shards=$1 out=$2 program=$3
shift 3
parts=$out.parts
mkdir -p "$parts"
# All nodes use the same instruction set, because different ones change the last digits of fields.
export OSG_MIDAIR_SIMD=${OSG_MIDAIR_SIMD:-avx2}
array=$(sbatch --parsable --job-name=midair --array="1-$shards" --cpus-per-task=1 --requeue --open-mode=append \
    --output="$parts/%a.log" "$here/shard.sh" "$shards" "$parts" "$program" "$@")
sbatch --parsable --job-name=midair-merge --dependency="afterok:$array" --kill-on-invalid-dep=yes --cpus-per-task=1 --requeue \
    --output="$parts/merge.log" "$here/merge.sh" "$shards" "$parts" "$program" "$out"
