#!/usr/bin/env bash
# usage: tests/fuzz/run.sh [SECONDS [TARGET]..]   fuzzes what reads bytes from outside with libFuzzer (needs clang), each target
# for so long (60), one after the other; without TARGETs all that have a corpus. New inputs go into build-fuzz/corpus/TARGET;
# what finds a fault stays in build-fuzz/found as TARGET-crash-*, TARGET-timeout-*, TARGET-oom-* or TARGET-leak-*.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
seconds=${1:-60}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- $(cd tests/fuzz/corpus && echo *)
command -v clang++ > /dev/null || { echo "tests/fuzz: clang++ is missing (apt install clang): skipped"; exit 0; }
midair_build build-fuzz midair_fuzz -DMIDAIR_FUZZ=ON -DCMAKE_CXX_COMPILER=clang++
mkdir -p build-fuzz/found
# More runs a second, as readers allocate much: without the stack of each allocation, which a replay of what was found
# shows, with a short quarantine, and without libFuzzer's schedule by rare features.
export ASAN_OPTIONS=malloc_context_size=0:quarantine_size_mb=1:thread_local_quarantine_size_kb=64${ASAN_OPTIONS:+:$ASAN_OPTIONS}
export LSAN_OPTIONS=print_suppressions=0:suppressions=$PWD/tests/sanitizers/leaks.txt
failed=()
for name in "$@"; do
    mkdir -p "build-fuzz/corpus/$name"
    echo "fuzzing $name for $seconds s"
    "build-fuzz/bin/fuzz_$name" -max_total_time="$seconds" -max_len=4096 -entropic=0 -timeout=20 -rss_limit_mb=1024 -verbosity=0 \
        -print_final_stats=1 -artifact_prefix="build-fuzz/found/$name-" \
        "build-fuzz/corpus/$name" "tests/fuzz/corpus/$name" || failed+=("$name")
done
[ ${#failed[@]} -eq 0 ] || { echo "tests/fuzz: faults found by ${failed[*]}: see build-fuzz/found" >&2; exit 1; }
