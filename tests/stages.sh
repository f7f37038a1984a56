#!/usr/bin/env bash
# tests/stages.sh STAGE: one of the checks that tests/run.sh names, without a time limit. MIDAIR_FILTER: only tests whose name
# matches; MIDAIR_WERROR=ON: compiler warnings are errors in the g++ build too.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. samples/packages.sh
jobs=$(nproc)
tests_at_once=$((2 * jobs)) # most wait for an array, not for a processor
filter=${MIDAIR_FILTER:-.}
tidied=493334c3c2dc0fde1e46ab80afa09b148462c1da # clang-tidy looks at what differs from this commit

# run FOLDER [ctest option]..: the tests of one build.
run()
{
    local folder=$1
    shift
    ctest --test-dir "$folder" -j "$tests_at_once" --output-on-failure --no-tests=error -R "$filter" "$@"
}

stage_format()
{
    git ls-files -z '*.h' '*.cpp' '*/include/*' | xargs -0 -r clang-format-14 --dry-run --Werror
}

stage_tests()
{
    midair_build build all -DMIDAIR_TESTS=ON -DMIDAIR_WERROR="${MIDAIR_WERROR:-OFF}"
    run build
}

# All libraries and programs, and the tests of what computes and of the devices.
stage_clang()
{
    midair_build build-clang "midair_samples midair_quick_tests" -DMIDAIR_TESTS=ON -DMIDAIR_WERROR=ON \
        -DCMAKE_CXX_COMPILER=clang++
    run build-clang -L '^(haptics|device|device-usb)(.threads)?$'
}

# The reference of all installed headers; Doxygen fails on any warning, and on what of the kit has no comment.
stage_docs()
{
    midair_build build-docs doc -DMIDAIR_TESTS=OFF
}

# tidy BASE: clang-tidy on what differs from the commit BASE; "": on everything.
tidy()
{
    midair_build build-tidy build.ninja -DMIDAIR_TESTS=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
    tests/tidy.py build-tidy "$1"
}

stage_tidy_all()
{
    tidy ""
}

# What differs from the commit that is named above.
stage_tidy()
{
    if git cat-file -e "$tidied^{commit}" 2>/dev/null; then
        tidy "$tidied"
    else
        echo "clang-tidy LOOKED AT NOTHING: this clone lacks the commit $tidied, with which it compares; --sanitize looks at everything"
    fi
}

# With its own code in the way, g++ warns of what isn't so (std::regex "may be used uninitialized"): warnings are the other builds'.
sanitized=(-DMIDAIR_TESTS=ON -DMIDAIR_WERROR=OFF)

# What computes, and what talks to arrays: the suites that take minutes under the sanitizers, building included.
stage_quick_sanitize()
{
    midair_build build-asan midair_quick_tests "${sanitized[@]}" -DMIDAIR_SANITIZE=address,undefined
    run build-asan -L '^(haptics|device|device-usb)(.threads)?$' --timeout 300
}

stage_sanitize_address()
{
    midair_build build-asan all "${sanitized[@]}" -DMIDAIR_SANITIZE=address,undefined
    run build-asan
}

stage_sanitize_threads()
{
    midair_build build-tsan midair_thread_tests "${sanitized[@]}" -DMIDAIR_SANITIZE=thread
    run build-tsan -L threads
}

# The solvers by themselves, under deadlines: the C++ library isn't compiled with this sanitizer, so no test that needs more of it is.
stage_sanitize_memory()
{
    mkdir -p build-msan
    cmake -S tests/memory -B build-msan -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_COMPILER_LAUNCHER=ccache \
        >build-msan/configure.log 2>&1 || { cat build-msan/configure.log >&2; exit 1; }
    ninja -C build-msan --quiet
    build-msan/midair-memory-check
}

stage=stage_${1:?which stage?}
declare -F "${stage//-/_}" >/dev/null || { echo "tests/stages.sh: unknown stage '$1'" >&2; exit 2; }
"${stage//-/_}"
