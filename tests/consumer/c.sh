#!/usr/bin/env bash
# tests/consumer/c.sh BUILD: installs the C interface of that build alone into a temporary prefix, moves the prefix, and builds a
# program in C99 against it, by pkg-config and by CMake; then runs it from there.
set -euo pipefail
build=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
unset LD_LIBRARY_PATH OSG_MIDAIR_ARRAYS
cmake --install "$build" --component c --prefix "$folder/first" >/dev/null
mv "$folder/first" "$folder/moved"
prefix=$folder/moved
library=$(find "$prefix" -name 'libmidair.so')
libraries=$(dirname "$library")
readelf -d "$library" | grep -q 'SONAME.*libmidair\.so\.[0-9]*\.[0-9]' || fail "the SONAME has no version"
! ldd "$library" | grep -iE 'libosg|libOpenThreads|not found' || fail "libmidair links a scene graph, or what isn't there"
# What C finds is what has the public version; the rest is C++ of this very version.
inC()
{
    nm -D --with-symbol-versions --defined-only "$library" | sed -n 's/^[0-9a-f]* T \([^@]*\)@@MIDAIR_0\.1$/\1/p'
}
others=$(inC | grep -v '^midair_' || true)
[ -z "$others" ] || fail "libmidair exports to C $others"
# Each function of the headers, and no other.
sed 's,//.*,,' "$prefix"/include/midair/*.h | tr '\n' ' ' | grep -oE 'MIDAIR_API [^;(]*\(' | grep -oE 'midair_[a-z_]+\(' |
    tr -d '(' | sort -u >"$folder/declared"
inC | sort -u >"$folder/exported"
diff "$folder/declared" "$folder/exported" || fail "the headers and the library differ"
[ "$(wc -l <"$folder/declared")" -ge 50 ] || fail "only $(wc -l <"$folder/declared") functions are declared"

export PKG_CONFIG_PATH=$libraries/pkgconfig
flags=$(pkg-config --cflags --libs midair) || fail "pkg-config doesn't know midair"
# shellcheck disable=SC2086 # several flags
gcc -std=c99 -D_POSIX_C_SOURCE=199309L -Wall -Wextra -Wpedantic -Werror "$here/c/main.c" $flags -Wl,-rpath,"$libraries" \
    -o "$folder/by-pkg-config" || fail "pkg-config's flags don't build the program"
cmake -G Ninja -S "$here/c" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 &&
    cmake --build "$folder/build" >"$folder/log" 2>&1 || fail "$(cat "$folder/log")"
awk '/^```c$/ { block = 1; next } /^```/ { block = 0 } block' "$here/../../samples/guides/C.md" >"$folder/program.c"
# shellcheck disable=SC2086
gcc -std=c99 -Wall -Wextra -Wpedantic -Werror "$folder/program.c" $flags -Wl,-rpath,"$libraries" -o "$folder/of-the-document" ||
    fail "the program of C.md isn't built"
for program in "$folder/of-the-document" "$folder/by-pkg-config" "$folder/build/c-consumer"; do
    "$program" || fail "$program failed"
done
echo "$(wc -l <"$folder/declared") functions, all of the headers"
