#!/usr/bin/env bash
# tests/consumer/run.sh BUILD [RUNTIME]: installs that build into temporary prefixes and uses it from there: an application with
# the kit, one with the kit and the libraries, one with the libraries alone, and all samples, which are built as they are
# installed, every warning an error, and run without a window; then the stock osgconv with what was installed. A kit built with a
# sanitizer needs its RUNTIME loaded first; its libraries would need the sanitizer in all that links them, so then only what
# stands on the kit is built.
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
preload=${2:+LD_PRELOAD=$2}
fail()
{
    echo "$*" >&2
    exit 1
}
# runs PROGRAM ARGUMENT..: it has to end with 0; what it prints is kept under its name.
runs()
{
    env $preload "$@" >"$folder/$(basename "$1").txt" 2>&1 || { cat "$folder/$(basename "$1").txt" >&2; fail "$* failed"; }
    echo "$(basename "$1") runs"
}
# built SOURCE FOLDER OPTION.. [-- TARGET..]: configures and builds a project outside the tree. The compiler's cache, where there is
# one, knows what was built in another temporary folder.
launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
export CCACHE_BASEDIR=$folder CCACHE_NOHASHDIR=1
built()
{
    local source=$1 to=$2 options=() targets=()
    shift 2
    while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
    [ $# -le 1 ] || targets=(--target "${@:2}")
    cmake -G Ninja -S "$source" -B "$to" -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" "${options[@]}" >"$folder/log" 2>&1 &&
        cmake --build "$to" "${targets[@]}" >"$folder/log" 2>&1 || { cat "$folder/log" >&2; fail "$source isn't built"; }
}

for component in kit c; do cmake --install "$build" --component $component --prefix "$folder/usr" >/dev/null; done
samples=$folder/usr/share/osgMidair/samples
if [ -z "$preload" ]; then
    cmake --install "$build" --component libraries --prefix "$folder/usr" >/dev/null
    built "$here" "$folder/build" -DCMAKE_PREFIX_PATH="$folder/usr" -DWITH_LIBRARIES=ON -- consumer both
    runs "$folder/build/both" "$folder/owned.hfr"
    # The libraries alone, where neither the kit nor its scene graph is installed.
    for component in c libraries; do cmake --install "$build" --component $component --prefix "$folder/alone" >/dev/null; done
    built "$here/without-scene" "$folder/without-scene" -DCMAKE_PREFIX_PATH="$folder/alone" -DMIDAIR_SAMPLES="$samples"
    runs "$folder/without-scene/without-scene"
    ! ldd "$folder/without-scene/without-scene" | grep -i 'libosg\|libOpenThreads' || fail "the libraries link a scene graph"
    # A program's files are compiled as one and with less optimisation, which takes a third of the time.
    built "$samples" "$folder/samples" -DCMAKE_PREFIX_PATH="$folder/usr" '-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror' \
        '-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG' -DCMAKE_UNITY_BUILD=ON
else
    built "$here" "$folder/build" -DCMAKE_PREFIX_PATH="$folder/usr" -DMIDAIR_SAMPLES="$samples"
    for sample in 13-rigid-bodies 20-own-device; do runs "$folder/build/$sample"; done
fi
runs "$folder/build/consumer"

# Each sample once.
if [ -z "$preload" ]; then
    bin=$folder/samples
    "$here/../samples/features/run.sh" "$bin/features" "$samples"
    runs "$bin/midair-demo" --headless --frames 6 --sampling vertices --width 240 --height 160 --out "$folder/demo"
    grep -q '"points": 11' "$folder/demo/report.json" || fail "midair-demo: $(cat "$folder/demo/report.json")"
    runs "$bin/midair-paper" --starts 0 --out "$folder/paper"
    runs "$bin/midair-device" circle --device sim: --array board --seconds 0.2
    seq 1 12 | awk '{ x = sin($1); y = cos(2.3 * $1); z = sin(4.1 * $1 + 1); print x, y, z, x + 1, y, z }' >"$folder/pairs"
    runs "$bin/midair-calibrate" "$folder/pairs" --unit m
    # The same figures as the tree's own program, but for how long it took.
    for program in "$bin" "$build/bin"; do
        runs "$program/midair-solve" "$samples/models/star.obj" --size 0.08 --sampling vertices --out "$folder/solved"
        sed '/_ms"/d' "$folder/solved/summary.json" >"$folder/$(basename "$program").json"
        cat "$folder/solved/drive.csv" >>"$folder/$(basename "$program").json"
        [ -s "$folder/solved/field.png" ] || fail "$program/midair-solve draws no picture"
    done
    cmp "$folder/samples.json" "$folder/bin.json" || fail "midair-solve of the prefix and of the tree differ"
    echo "midair-solve of the prefix and of the tree: the same figures and drives"
fi
if command -v osgconv >/dev/null; then
    plugins=$(dirname "$(find "$folder/usr" -name 'osgdb_haptic.so')")
    env $preload OSG_LIBRARY_PATH="$(dirname "$plugins")" osgconv --format haptic | grep 'size=<metres>' >/dev/null # all of it is read: no broken pipe
    echo "osgconv finds the installed plugins"
fi
