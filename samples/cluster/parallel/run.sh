#!/usr/bin/env bash
# run.sh HOSTS SHARDS OUT PROGRAM ARGUMENT..: runs midair-bake or midair-sweep (PROGRAM with its arguments, without --shard and
# --out) with GNU parallel on HOSTS, one process per core, then merges the parts into OUT. HOSTS as for parallel's --sshlogin:
# ":" is this machine, "4/:,8/user@host" means 4 processes here and 8 there. All hosts need PROGRAM and a shared folder with the
# same path.
#     samples/cluster/parallel/run.sh :,user@desk 32 star.midair build/bin/midair-bake star.osgt --frames 0:10000 --fps 60
# A process that is killed or loses its host is retried up to 5 times (MIDAIR_RETRIES) on any host and continues its part. So does
# this command when it is repeated.
set -euo pipefail
[ $# -ge 5 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
hosts=$1 shards=$2 out=$3 program=$4
shift 4
parts=$out.parts
mkdir -p "$parts"
parts=$(cd "$parts" && pwd)
# All hosts use the same instruction set, because different ones change the last digits of fields.
export OSG_MIDAIR_SIMD=${OSG_MIDAIR_SIMD:-avx2}
command=$(printf '%q ' env "OSG_MIDAIR_SIMD=$OSG_MIDAIR_SIMD" "$program" "$@" --quiet)
# Exit code 1: all frames are silent or rows could not be solved; this was reported, and the part is complete.
seq "$shards" | parallel --will-cite --sshlogin "$hosts" --workdir "$PWD" --retries "${MIDAIR_RETRIES:-5}" --line-buffer --tag \
    --joblog "$parts/joblog" \
    "$command --shard {}/$shards --out $(printf '%q' "$parts")/{}.part; s=\$?; [ \$s -le 1 ] || exit \$s"
files=()
for ((task = 1; task <= shards; ++task)); do files+=("$parts/$task.part"); done
"$program" --merge "${files[@]}" --out "$out"
