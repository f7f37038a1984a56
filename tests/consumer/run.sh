#!/usr/bin/env bash
# tests/consumer/run.sh BUILD [RUNTIME]: installs the kit of that build into a temporary folder, builds an application against
# it, and runs it; then the stock osgconv with what was installed. A kit built with a sanitizer needs its RUNTIME loaded first.
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
preload=${2:+LD_PRELOAD=$2}
cmake --install "$build" --component kit --prefix "$folder/usr" >/dev/null
cmake -G Ninja -S "$here" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/usr" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$folder/build" >/dev/null
env $preload "$folder/build/consumer"
if command -v osgconv >/dev/null; then
    plugins=$(dirname "$(find "$folder/usr" -name 'osgdb_haptic.so')")
    env $preload OSG_LIBRARY_PATH="$(dirname "$plugins")" osgconv --format haptic | grep 'size=<metres>' >/dev/null # all of it is read: no broken pipe
    echo "osgconv finds the installed plugins"
fi
