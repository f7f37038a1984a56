#!/usr/bin/env bash
# run.sh HOSTS SHARDS OUT PROGRAM ARGUMENT..: runs midair-bake or midair-sweep (PROGRAM with its arguments, but for --shard and
# --out) by GNU parallel on HOSTS, as many processes as each has cores, then merges the parts to OUT. HOSTS as for parallel's
# --sshlogin: ":" is this machine, "4/:,8/user@host" 4 processes here and 8 there. Needs a folder that all hosts see under the
# same name, and PROGRAM on each.
#     samples/cluster/parallel/run.sh :,user@desk 32 star.midair build/bin/midair-bake star.osgt --frames 0:10000 --fps 60
# A process that is ended, or whose host is gone, is tried again up to 5 times (MIDAIR_RETRIES), on any host, and goes on with what
# is done; so does this command, when it is called again.
set -euo pipefail
[ $# -ge 5 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
hosts=$1 shards=$2 out=$3 program=$4
shift 4
parts=$out.parts
mkdir -p "$parts"
parts=$(cd "$parts" && pwd)
# Processors may differ from host to host, and the last digits of fields with them: one instruction set for all.
export OSG_MIDAIR_SIMD=${OSG_MIDAIR_SIMD:-avx2}
command=$(printf '%q ' env "OSG_MIDAIR_SIMD=$OSG_MIDAIR_SIMD" "$program" "$@" --quiet)
# 1: all is silent, or rows could not be solved; it was told, and the part is whole.
seq "$shards" | parallel --will-cite --sshlogin "$hosts" --workdir "$PWD" --retries "${MIDAIR_RETRIES:-5}" --line-buffer --tag \
    --joblog "$parts/joblog" \
    "$command --shard {}/$shards --out $(printf '%q' "$parts")/{}.part; s=\$?; [ \$s -le 1 ] || exit \$s"
files=()
for ((task = 1; task <= shards; ++task)); do files+=("$parts/$task.part"); done
"$program" --merge "${files[@]}" --out "$out"
