#!/usr/bin/env bash
# tests/engine-bridge/c/headers.sh FOLDER: each header of the C interface compiles alone, in C99 and in C++, every warning an error; of
# clang really every one.
set -euo pipefail
folder=$1
looked=0
for header in midair.h midair_play.h midair_extend.h; do
    for compiler in "gcc -std=c99 -x c" "gcc -std=c11 -x c" "g++ -std=c++11 -x c++" "g++ -std=c++17 -x c++" "clang -std=c99 -x c -Weverything" \
        "clang -std=c11 -x c -Weverything" "clang++ -std=c++17 -x c++ -Weverything"; do
        command -v "${compiler%% *}" >/dev/null || { echo "${compiler%% *} is missing" >&2; exit 1; }
        printf '#include "%s"\n#include "%s"\nint nothing(void);\n' $header $header |
            $compiler -fsyntax-only -Wall -Wextra -Wpedantic -Werror -I "$folder" - ||
            { echo "$compiler: $header doesn't compile alone" >&2; exit 1; }
        looked=$((looked + 1))
    done
done
echo "$looked compilations of three headers"
