#!/usr/bin/env bash
# tests/stages.sh STAGE: one of the checks that tests/run.sh names, without a time limit. MIDAIR_FILTER: only tests whose name
# matches; MIDAIR_WERROR=ON: compiler warnings are errors in the g++ build too.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. samples/packages.sh
jobs=$(nproc)
filter=${MIDAIR_FILTER:-.}
sources=('haptics/*.cpp' 'device/*.cpp' 'engine-bridge/*.cpp' 'plugin/*.cpp') # for clang-tidy

# run FOLDER [ctest option]..: the tests of one build, as many at a time as there are cores.
run()
{
    local folder=$1
    shift
    ctest --test-dir "$folder" -j "$jobs" --output-on-failure --no-tests=error -R "$filter" "$@"
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

# tidy FILE..: clang-tidy with the project's configuration; every finding is an error.
tidy()
{
    [ $# -gt 0 ] || return 0
    midair_build build-tidy build.ninja -DMIDAIR_TESTS=ON -DCMAKE_UNITY_BUILD=OFF -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
    printf '%s\0' "$@" | xargs -0 -n 1 -P "$jobs" bash -c \
        'clang-tidy-14 -p build-tidy --quiet --warnings-as-errors="*" "$0" 2>/dev/null || { echo "clang-tidy: $0" >&2; exit 1; }'
    echo "clang-tidy found nothing in $# files"
}

stage_tidy_all()
{
    mapfile -t files < <(git ls-files "${sources[@]}")
    tidy "${files[@]}"
}

# What differs from the last release's tag, or without a tag everything; where that is more than fits, the newest commit's files
# and part of the rest, the next part with the next commit.
stage_tidy()
{
    local tag atMost=30 file
    local -a candidates left=()
    local -A chosen=()
    if tag=$(git describe --tags --abbrev=0 2>/dev/null); then
        echo "clang-tidy on what differs from $tag"
        mapfile -t candidates < <(git diff --name-only --diff-filter=d "$tag" -- "${sources[@]}")
    else
        mapfile -t candidates < <(git ls-files "${sources[@]}")
    fi
    if [ ${#candidates[@]} -gt $atMost ]; then
        # A clone of depth 1 knows no number of commits: then the commit's hash is the number.
        local number=$((16#$(git rev-parse --short=7 HEAD))) parts=$(((${#candidates[@]} + 14) / 15)) i
        [ "$(git rev-parse --is-shallow-repository)" = true ] || number=$(git rev-list --count HEAD)
        echo "of ${#candidates[@]} files the newest commit's and part $((number % parts + 1)) of $parts"
        while read -r file; do
            if [ ${#chosen[@]} -lt $atMost ]; then chosen[$file]=1; else left+=("$file"); fi
        done < <(git diff --name-only --diff-filter=d HEAD~1 -- "${sources[@]}" 2>/dev/null)
        for ((i = number % parts; i < ${#candidates[@]}; i += parts)); do chosen[${candidates[i]}]=1; done
        for i in "${!left[@]}"; do [ -z "${chosen[${left[i]}]:-}" ] || unset "left[i]"; done
        [ ${#left[@]} -eq 0 ] || echo "NOT LOOKED AT are ${#left[@]} files of the newest commit, beyond $atMost: ${left[*]}" >&2
    else
        for file in "${candidates[@]}"; do chosen[$file]=1; done
    fi
    tidy "${!chosen[@]}"
}

# With its own code in the way, g++ warns of what isn't so (std::regex "may be used uninitialized"): warnings are the other builds'.
# Tests that link the kit and its parts have each global twice, as the same definition: the address sanitizer counts these too.
export ASAN_OPTIONS=detect_odr_violation=0
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
