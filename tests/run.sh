#!/usr/bin/env bash
# tests/run.sh [STAGE].. [--long] [--vm] [--avx512] [--cluster] [--browser] [--packages] [--arm64] [--filter REGEX]: installs what is
# missing, then runs these checks, one after the other; each says how long it took and fails when it takes longer than its limit.
# Without a STAGE: --tests.
#   --tests           builds with g++ into build/ and runs all tests
#   --format          clang-format
#   --clang           builds libraries and programs with clang++ and runs the tests of what computes and of devices
#   --tidy            clang-tidy on all that differs from the commit that tests/stages.sh names, tests and samples too
#   --docs            the reference of all installed headers by Doxygen, without a warning
#   --quick-sanitize  the suites of what computes and of the devices under the address and undefined-behaviour sanitizers
#   --sanitize        all tests under these two, what has threads under the thread sanitizer, the solvers by themselves under the
#                     memory sanitizer, clang-tidy on everything: hours
#   --long            the tests with those that take many minutes (stress, soak), and a minute of fuzzing for each target
#   --vm              also the USB path on the kernel's own stack, in a virtual machine
#   --avx512          also the kernels on emulated processors with AVX2 and AVX-512
#   --cluster         also bakes and sweeps on a Slurm of this machine and by GNU parallel, with tasks that are killed; needs root
#   --browser         also the operator's page in a real browser, on a telephone's size too
#   --packages        also makes the Debian packages and uses them, and a clone of the newest commit, in a clean Debian; needs root
#   --arm64           also builds for arm64 in such a Debian and runs tests under qemu; needs root
#   --filter REGEX    only tests whose name matches
# MIDAIR_WERROR=ON makes compiler warnings errors in --tests too. MIDAIR_TIME_FACTOR=3 triples all limits, which are for two
# cores and an empty compiler cache. MIDAIR_END (seconds since 1970): nothing runs for longer than until then.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. samples/packages.sh
stages=() long=0 vm=0 avx512=0 cluster=0 browser=0 packages=0 arm64=0
while [ $# -gt 0 ]; do
    case $1 in
        --tests | --format | --clang | --tidy | --docs | --quick-sanitize) stages+=("${1#--}") ;;
        --sanitize) stages+=(sanitize-address sanitize-threads sanitize-memory tidy-all) ;;
        --long) long=1 ;;
        --vm) vm=1 ;;
        --avx512) avx512=1 ;;
        --cluster) cluster=1 ;;
        --browser) browser=1 ;;
        --packages) packages=1 ;;
        --arm64) arm64=1 ;;
        --filter) export MIDAIR_FILTER=${2:?--filter needs a regular expression}; shift ;;
        -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"; exit 0 ;;
        *) echo "tests/run.sh: unknown option '$1'; --help lists them" >&2; exit 2 ;;
    esac
    shift
done
[ ${#stages[@]} -gt 0 ] || stages=(tests)
midair_install git "${midair_packages[@]}" "${midair_test_packages[@]}"
[[ " ${stages[*]} " != *" docs "* ]] || midair_install "${midair_docs_packages[@]}"
[ $cluster = 0 ] || midair_install "${midair_cluster_packages[@]}"
[ $browser = 0 ] || midair_install "${midair_browser_packages[@]}"
export MIDAIR_LONG_TESTS=$long

# minutes STAGE: its limit.
minutes()
{
    case $1 in
        format | docs) echo 3 ;;
        tests) echo $((long ? 240 : 50)) ;;
        clang) echo 25 ;;
        tidy) echo 30 ;;
        quick-sanitize) echo 30 ;;
        sanitize-address) echo 60 ;;
        sanitize-threads) echo 25 ;;
        sanitize-memory) echo 10 ;;
        tidy-all) echo 90 ;;
        cluster | browser) echo 15 ;;
        packages) echo 45 ;;
        clone) echo 20 ;;
        *) echo 240 ;;
    esac
}

# What each of the checks printed, for the summary at the end.
logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT

# repeated NAME: what went wrong in a check that failed: the output of each test that did, or else the last lines of all.
repeated()
{
    echo "== $1: what went wrong"
    awk '/^ *(Start +[0-9]+:|[0-9]+\/[0-9]+ Test )/ { failing = /\*\*\*/ && !/\*\*\*Skipped|\(Disabled\)/; lines = 0 }
         /^[0-9]+% tests passed/ { failing = 1; lines = 0 }
         failing && ++lines <= 40' "$logs/$1" >"$logs/failures"
    if [ -s "$logs/failures" ]; then tail -n 150 "$logs/failures"; else tail -n 40 "$logs/$1"; fi
}

# timed NAME COMMAND..: runs it for at most its minutes; what has begun is ended with it.
timed()
{
    local name=$1 begin=$SECONDS status=0 limit_s left_s
    shift
    limit_s=$(($(minutes "$name") * 60 * ${MIDAIR_TIME_FACTOR:-1}))
    left_s=$((${MIDAIR_END:-$(($(date +%s) + limit_s))} - $(date +%s)))
    [ $left_s -ge $limit_s ] || limit_s=$left_s
    if [ $limit_s -le 0 ]; then
        echo "== $name: FAILED: NOT RUN, since no time is left" >&2
        return 124
    fi
    echo "== $name: begins; at most $((limit_s / 60)) min"
    timeout --kill-after=30 "$limit_s" "$@" > >(tee "$logs/$name") 2>&1 &
    child=$!
    trap 'kill "$child" 2>/dev/null || true; exit 130' INT TERM
    wait "$child" || status=$?
    trap - INT TERM
    case $status in
        0) echo "== $name: passed in $((SECONDS - begin)) s" ;;
        124 | 137) echo "== $name: FAILED: not done after $((SECONDS - begin)) s, ended" >&2 ;;
        *) echo "== $name: FAILED after $((SECONDS - begin)) s" >&2 ;;
    esac
    return "$status"
}

failed=()
for stage in "${stages[@]}"; do
    timed "$stage" tests/stages.sh "$stage" || failed+=("$stage")
done
[ $long = 0 ] || timed fuzz tests/fuzz/run.sh 60 || failed+=(fuzz)
[ $vm = 0 ] || timed vm tests/vm/run.sh || failed+=(vm)
[ $avx512 = 0 ] || timed avx512 tests/vm/avx512.sh || failed+=(avx512)
[ $cluster = 0 ] || timed cluster tests/cluster/run.sh build/bin || failed+=(cluster)
[ $browser = 0 ] || timed browser tests/samples/shared/monitor/browser.py build/bin || failed+=(browser)
[ $packages = 0 ] || timed packages tests/packages/run.sh || failed+=(packages)
[ $packages = 0 ] || timed clone tests/packages/clone.sh || failed+=(clone)
[ $arm64 = 0 ] || timed arm64 tests/arm64/run.sh || failed+=(arm64)
[ ${#failed[@]} -eq 0 ] || {
    for stage in "${failed[@]}"; do [ ! -f "$logs/$stage" ] || repeated "$stage"; done
    echo "tests/run.sh: failed: ${failed[*]}"
    exit 1
} >&2
