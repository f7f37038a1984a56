#!/usr/bin/env bash
# tests/consumer/packages.sh BUILD: makes the Debian packages of that build, which is of no system: that has to be allowed. Then looks into
# them and runs Python's ten lines with what is unpacked. tests/packages/run.sh installs those that are for a system.
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
! cpack --config "$build/CPackConfig.cmake" -B "$folder/refused" >"$folder/log" 2>&1 || fail "packages are made of a build that looks into its sources"
grep -q 'samples/debian/build.sh makes it' <(tr -s ' \n' ' ' <"$folder/log") || fail "cpack doesn't say how packages are made: $(cat "$folder/log")"
[ -z "$(find "$folder/refused" -name '*.deb')" ] || fail "cpack refuses, and makes packages"
cpack --config "$build/CPackConfig.cmake" -B "$folder/packages" -D CPACK_MIDAIR_ANY_BUILD=ON >"$folder/log" 2>&1 || fail "$(cat "$folder/log")"
made=$(cd "$folder/packages" && ls ./*.deb | sed 's,^\./,,; s,_.*,,' | paste -sd' ')
[ "$made" = "libmidair-dev libmidair0.1 libosgmidair-dev libosgmidair0.1 osgmidair-data osgmidair-doc osgmidair-samples osgmidair-tools python3-midair" ] ||
    fail "there are $made"
# needs PACKAGE EXPRESSION: the package depends on that.
needs()
{
    dpkg-deb -f "$folder/packages/$1"_*.deb Depends | grep -q "$2" || fail "$1 doesn't depend on $2, but on $(dpkg-deb -f "$folder/packages/$1"_*.deb Depends)"
}
needs libmidair0.1 'libc6'
needs libmidair0.1 'osgmidair-data (= '
needs libosgmidair0.1 'libopenscenegraph'
needs osgmidair-tools 'libosgmidair0.1 (= '
needs python3-midair 'libmidair0.1 (= '
! dpkg-deb -f "$folder"/packages/libmidair0.1_*.deb Depends | grep -qi 'openscenegraph' || fail "libmidair depends on a scene graph"
for package in "$folder"/packages/*.deb; do dpkg-deb -x "$package" "$folder/root"; done
grep -q '^ExecStart=/usr/bin/midair-%i ' "$folder"/root/usr/lib/systemd/system/midair-installation@.service || fail "the unit names another prefix than that of packages"
for program in "$folder"/root/usr/bin/*; do
    name=$(basename "$program")
    zcat "$folder/root/usr/share/man/man1/$name.1.gz" | grep -A 1 '^\.SH NAME' | grep -q "^$name .*- [a-z]* " || fail "$name has no man page with a line of its own"
done
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
