#!/usr/bin/env bash
# tests/consumer/headers.sh BUILD: installs the kit of that build into a temporary folder and compiles each of its headers alone,
# with g++ and clang++, every warning an error. What a header needs and doesn't include itself is missing here.
set -euo pipefail
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cmake --install "$build" --component kit --prefix "$folder/usr" >/dev/null

# compileAlone COMPILER HEADER: included twice, which its guard has to bear.
compileAlone()
{
    printf '#include <osgMidair/%s>\n#include <osgMidair/%s>\n' "$2" "$2" |
        "$1" -x c++ -std=c++17 -fsyntax-only -Wall -Wextra -Wpedantic -Werror -I "$folder/usr/include" - ||
        { echo "$1: <osgMidair/$2> doesn't compile alone" >&2; return 1; }
}
export -f compileAlone
export folder

headers=$(ls "$folder/usr/include/osgMidair")
count=$(wc -w <<<"$headers")
[ "$count" -ge 20 ] || { echo "only $count headers are installed: $headers" >&2; exit 1; }
for compiler in g++ clang++; do
    command -v "$compiler" >/dev/null || { echo "$compiler is missing: its headers' test can't run" >&2; exit 1; }
    xargs -n 1 -P "$(nproc)" bash -c 'compileAlone "$0" "$1"' "$compiler" <<<"$headers"
    echo "$count headers compile alone with $compiler"
done
