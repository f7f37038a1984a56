#!/usr/bin/env bash
# tests/consumer/prefix.sh BUILD: installs everything of that build into a temporary prefix, moves the prefix, and uses it from
# there: the tools, arrays beside them, a scene file without OSG_LIBRARY_PATH. Then it uninstalls. What is installed is stripped, if
# it is a release; the unit of systemd names the prefix that it was installed to; the reference is there where it was made.
set -euo pipefail
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
# The build folder keeps one list of what was installed, which is the user's again when this ends.
mkdir "$folder/lists" "$folder/kept"
find "$build" -maxdepth 1 -name 'install_manifest*.txt' -exec mv {} "$folder/kept" \;
reference=$build/doc/html
[ -e "$reference" ] || { mkdir -p "$reference.made" "$reference"; touch "$reference/index.html"; } # as if it had been made
trap '[ ! -d "$reference.made" ] || rm -r "$reference" "$reference.made"
    rm -f "$build"/install_manifest*.txt; find "$folder/kept" -type f -exec mv {} "$build" \;; rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
unset OSG_LIBRARY_PATH LD_LIBRARY_PATH OSG_MIDAIR_ARRAYS
export HOME="$folder/home"
mkdir -p "$HOME"

for component in c kit libraries tools; do cmake --install "$build" --component $component --prefix "$folder/first" >/dev/null; done
mv "$build"/install_manifest*.txt "$folder/lists"
[ -s "$folder/first/share/doc/osgMidair/html/index.html" ] || [ -d "$reference.made" ] || fail "the reference that was made isn't installed"
[ -e "$folder/first/share/doc/osgMidair/html/index.html" ] || fail "no reference is installed"

# The unit names the prefix, not that of the build; a package's the one that it will have.
unit=lib/systemd/system/midair-installation@.service
named() { grep -q "^ExecStart=$2/bin/midair-%i " "$1/$unit" && grep -q "^Documentation=file:$2/share/doc/" "$1/$unit" || fail "the unit names $(grep ^ExecStart "$1/$unit")"; }
named "$folder/first" "$folder/first"
DESTDIR=$folder/staged cmake --install "$build" --component tools --prefix /opt/midair >/dev/null
named "$folder/staged/opt/midair" /opt/midair
! grep -rq '@MIDAIR' "$folder/first/$unit" || fail "the unit has names without values"
rm -f "$build"/install_manifest*.txt

# A release is installed without symbols, unless they are asked for.
symbols() { readelf -SW "$1" | grep -q ' \.symtab '; }
if grep -qE '^CMAKE_BUILD_TYPE:[A-Z]*=(Release|MinSizeRel)$' "$build/CMakeCache.txt" && ! grep -qE '^MIDAIR_SANITIZE:[A-Z]*=.' "$build/CMakeCache.txt"; then
    looked=0
    while read -r file; do
        ! symbols "$file" || fail "${file#"$folder/first/"} isn't stripped"
        looked=$((looked + 1))
    done < <(find "$folder/first" -type f \( -name '*.so*' -o -path '*/bin/*' \))
    [ $looked -ge 15 ] || fail "only $looked libraries and programs are installed"
    cmake -DCMAKE_INSTALL_DO_STRIP=OFF -DCMAKE_INSTALL_PREFIX="$folder/whole" -DCMAKE_INSTALL_COMPONENT=c -P "$build/cmake_install.cmake" >/dev/null
    symbols "$(readlink -f "$(find "$folder/whole" -name libmidair.so)")" || fail "symbols that were asked for aren't installed"
    rm -f "$build"/install_manifest*.txt
    echo "$looked libraries and programs are stripped: $(du -sh "$folder/first" | cut -f1) in all"
fi

mv "$folder/first" "$folder/moved"
prefix=$folder/moved
library=$(readlink -f "$(find "$prefix" -name libosgMidair.so)")

grep -q 'SONAME.*libosgMidair\.so\.[0-9]' <<<"$(readelf -d "$library")" || fail "the SONAME has no version"

# An array beside the moved library that is nowhere else, for the kit and for a program that has the field linked in.
shared=$prefix/share/osgMidair
sed 's/"name": *"[^"]*"/"name": "moved"/' "$(find "$shared/arrays" -name '*.json' | sort | head -1)" >"$shared/arrays/moved.json"
"$prefix/bin/midair-solve" --array moved --sampling vertices "$shared/samples/models/star.obj" --out "$folder/solved" >"$folder/log" 2>&1 ||
    fail "midair-solve: $(cat "$folder/log")"
[ -s "$folder/solved/summary.json" ] || fail "midair-solve wrote no summary"
grep -q 'array.*moved' "$folder/solved/summary.json" || fail "midair-solve took another array: $(head -20 "$folder/solved/summary.json")"
for tool in midair-calibrate midair-check midair-demo midair-device midair-tune; do
    "$prefix/bin/$tool" --help >/dev/null || fail "$tool doesn't start from $prefix"
done

# The libraries are found where they are now.
cmake -G Ninja -S "$(dirname "$0")/without-scene" -B "$folder/libraries" -DCMAKE_PREFIX_PATH="$prefix" \
    -DMIDAIR_SAMPLES="$shared/samples" >"$folder/log" 2>&1 ||
    fail "the libraries aren't found in the moved prefix: $(cat "$folder/log")"

# components REFUSED OPTIONAL SAID: CMake refuses the components REFUSED and says SAID; OPTIONAL ones do no harm.
components()
{
    local line code
    mkdir -p "$folder/nosuch"
    for line in "REQUIRED COMPONENTS $1" "REQUIRED COMPONENTS $2"; do
        printf 'cmake_minimum_required(VERSION 3.16)\nproject(nosuch LANGUAGES CXX)\nfind_package(osgMidair %s)\n' "$line" >"$folder/nosuch/CMakeLists.txt"
        rm -rf "$folder/nosuch-build"
        code=0
        cmake -G Ninja -S "$folder/nosuch" -B "$folder/nosuch-build" -DCMAKE_PREFIX_PATH="$prefix" >"$folder/log" 2>&1 || code=$?
        case $line in
        *OPTIONAL*) [ $code -eq 0 ] || fail "an optional component ($2): $(cat "$folder/log")" ;;
        *) [ $code -ne 0 ] && tr -s ' \n' ' ' <"$folder/log" | grep -q "$3" ||
            fail "what is wrong with the components $1 isn't named: $(cat "$folder/log")" ;;
        esac
    done
}

# A component that isn't there is named; an optional one does no harm. So is one that another needs, if its file isn't there.
components 'midair nosuch' 'midair OPTIONAL_COMPONENTS nosuch' 'no component "nosuch"; there are kit, midair, tools, c'
needed=$(find "$prefix" -name osgMidair-midair.cmake)
mv "$needed" "$needed.away"
components tools 'c OPTIONAL_COMPONENTS tools' 'installed without its component "midair", which "tools" needs'
mv "$needed.away" "$needed"

# A scene file is read by the kit's serializers, found beside the library that the program has linked.
cmake -G Ninja -S "$(dirname "$0")" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$folder/build" --target reader >/dev/null
"$folder/build/reader" "$shared/samples/scenes/star.osgt" moved || fail "the scene file isn't read from the moved prefix"

for file in CMakeLists.txt features/01-first-touch.cpp features/Frames.h features/24-c.c demo/midair-demo.cpp tools/solve/midair-solve.cpp; do
    [ -f "$shared/samples/$file" ] || fail "the sample $file isn't installed"
done

# Uninstalling leaves nothing behind.
mv "$prefix" "$folder/first"
rm "$folder/first/share/osgMidair/arrays/moved.json"
sed "s|@CMAKE_BINARY_DIR@|$folder/lists|" "$(dirname "$0")/../../plugin/uninstall.cmake.in" >"$folder/uninstall.cmake"
for list in "$folder"/lists/install_manifest*.txt; do [ -s "$list" ] || fail "no list of what was installed"; done
cmake -P "$folder/uninstall.cmake" >/dev/null
[ ! -e "$folder/first" ] || fail "uninstalling left $(find "$folder/first" | head)"
echo "uninstalled"
