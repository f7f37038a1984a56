#!/usr/bin/env bash
# tests/run.sh [--long] [--sanitize] [--vm] [--avx512] [--filter REGEX]: installs what is missing, builds, and runs the tests.
#   --long       also those that take many minutes (stress, soak), and a minute of fuzzing for each target
#   --sanitize   the tests once more under the address and undefined-behaviour sanitizers, and under the thread sanitizer
#   --vm         also the USB path on the kernel's own stack, in a virtual machine
#   --avx512     also the kernels on emulated processors with AVX2 and AVX-512
#   --filter R   only tests whose name matches R
# MIDAIR_WERROR=ON makes compiler warnings errors.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. samples/packages.sh
long=0 sanitize=0 vm=0 avx512=0 filter=.
while [ $# -gt 0 ]; do
    case $1 in
        --long) long=1 ;;
        --sanitize) sanitize=1 ;;
        --vm) vm=1 ;;
        --avx512) avx512=1 ;;
        --filter) filter=${2:?--filter needs a regular expression}; shift ;;
        -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
        *) echo "tests/run.sh: unknown option '$1'; --help lists them" >&2; exit 2 ;;
    esac
    shift
done
midair_install "${midair_packages[@]}" "${midair_test_packages[@]}"
export MIDAIR_LONG_TESTS=$long
werror=-DMIDAIR_WERROR=${MIDAIR_WERROR:-OFF}

# run FOLDER: all tests of one build, two at a time or as many as there are cores.
run()
{
    ctest --test-dir "$1" -j "$(nproc)" --output-on-failure --no-tests=error -R "$filter"
}

midair_build build all -DMIDAIR_TESTS=ON "$werror"
run build
if [ $sanitize = 1 ]; then
    midair_build build-asan all -DMIDAIR_TESTS=ON "$werror" -DMIDAIR_SANITIZE=address,undefined
    run build-asan
    midair_build build-tsan all -DMIDAIR_TESTS=ON "$werror" -DMIDAIR_SANITIZE=thread
    run build-tsan
fi
if [ $long = 1 ]; then
    tests/fuzz/run.sh 60
fi
if [ $vm = 1 ]; then
    tests/vm/run.sh
fi
if [ $avx512 = 1 ]; then
    tests/vm/avx512.sh
fi
