#!/usr/bin/env bash
# tests/consumer/packages.sh BUILD: makes the Debian packages of that build, unpacks them into a folder and runs Python's ten lines
# with what is in there.
set -euo pipefail
build=$(cd "$1" && pwd)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
cpack --config "$build/CPackConfig.cmake" -B "$folder/packages" >"$folder/log" 2>&1 || fail "$(cat "$folder/log")"
shopt -s nullglob
library=("$folder"/packages/libmidair_*.deb) python=("$folder"/packages/python3-midair_*.deb)
[ ${#library[@]} = 1 ] && [ ${#python[@]} = 1 ] || fail "there are $(ls "$folder/packages")"
dpkg-deb -f "${library[0]}" Depends | grep -q 'libc6' || fail "libmidair depends on: $(dpkg-deb -f "${library[0]}" Depends)"
dpkg-deb -f "${library[0]}" Depends | grep -qi 'openscenegraph' && fail "libmidair depends on a scene graph"
dpkg-deb -f "${python[0]}" Depends | grep -q 'libmidair (= ' || fail "python3-midair doesn't depend on libmidair"
for package in "${library[0]}" "${python[0]}"; do dpkg-deb -x "$package" "$folder/root"; done
cd "$folder"
env -u OSG_MIDAIR_ARRAYS -u LD_LIBRARY_PATH PYTHONPATH="$folder/root/usr/lib/python3/dist-packages" /usr/bin/python3 - "$root" <<'PYTHON' ||
import sys
import midair

scene = midair.Scene("octagon")
scene.add_file(sys.argv[1] + "/samples/models/star.obj", size=0.08)
field = scene.solve()
assert field.figures["level_Pa"] > 1000.0, field.figures
print("python3-midair, unpacked:", midair.__file__, field.figures["level_Pa"])
PYTHON
    fail "the unpacked module doesn't solve"
