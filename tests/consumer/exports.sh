#!/usr/bin/env bash
# tests/consumer/exports.sh BUILD: installs everything of that build into a temporary prefix and looks at what each shared object
# exports: names of its own, none of others' libraries; what an installed header marks has to be there. What a process has once
# (registries, claims, grants) lies in one library alone.
set -euo pipefail
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
for component in c kit tools; do # with the symbols that a release is installed without
    cmake -DCMAKE_INSTALL_DO_STRIP=OFF -DCMAKE_INSTALL_PREFIX="$folder" -DCMAKE_INSTALL_COMPONENT=$component -P "$build/cmake_install.cmake" >/dev/null
done

# names FILE: names that it exports, without arguments: "osgMidair::HapticScene::update".
names()
{
    nm -DC --defined-only "$1" | sed -E 's/^[0-9a-f]* +[A-Za-z] +//; s/@.*//; s/ \[clone .*//
        s/^(vtable|VTT|typeinfo|typeinfo name|guard variable|reference temporary #[0-9]+) for //; s/^(non-)?virtual thunk to //
        s/\(.*//; s/operator[^A-Za-z_]*$/operator/; s/\[abi:[^]]*\]//g' | sort -u
}

looked=0
while read -r library; do
    names "$library" >"$folder/names"
    case $(basename "$library") in
    libmidair.so*) own='^((bool )?midair::|midair_|MIDAIR_)' ;;
    libosgMidair.so*) own='^(bool )?(osgMidair|midair)::' ;;
    midair-picture.so) own='^midairDrawPicture$' ;; # samples/tools/solve/Picture.h
    *) own='^$' ;;
    esac
    ! grep -vE "$own" "$folder/names" >"$folder/others" ||
        fail "$(basename "$library") exports what isn't its own:"$'\n'"$(head -20 "$folder/others")"
    echo "$(basename "$library"): $(wc -l <"$folder/names") names, all its own"
    looked=$((looked + 1))
done < <(find "$folder" -name '*.so*' -type f)
[ $looked -eq 7 ] || fail "$looked shared objects are installed, 7 were looked for"

# data FILE: variables that it has, also hidden ones: not functions, nor tables of types, which are the same everywhere.
data()
{
    nm -C --defined-only "$1" | grep -E '^[0-9a-f]+ [bBdDuV] ' | cut -d' ' -f3- | sed 's/^guard variable for //' | grep -E '^midair::' |
        grep -vE '::\(anonymous namespace\)::|::(k[A-Z][A-Za-z]*|none|steadyClock\(\)::clock)$' | sort -u # nor constants, nor what has no state
}
kit=$(readlink -f "$(find "$folder" -name libosgMidair.so)")
midair=$(readlink -f "$(find "$folder" -name libmidair.so)")
data "$midair" >"$folder/of-midair"
[ "$(wc -l <"$folder/of-midair")" -ge 10 ] || fail "libmidair has no variables: nm tells nothing"
while read -r file; do
    ! data "$file" | comm -12 "$folder/of-midair" - >"$folder/twice" || true
    [ ! -s "$folder/twice" ] || fail "libmidair and $(basename "$file") have both:"$'\n'"$(cat "$folder/twice")"
done < <(echo "$kit"; find "$folder/bin" -type f)
echo "no variable of libmidair's is in the kit or in a program, too"

# Whatever a header marks. A class that is inline as a whole leaves nothing to export: not even its type is in the library.
names "$kit" >"$folder/names"
nm -C --defined-only "$kit" >"$folder/defined"
marked=0
while read -r name; do
    marked=$((marked + 1))
    if grep -qE "^osgMidair::(.*::)?$name(::|$)" "$folder/names"; then continue; fi
    case $name in
    [A-Z]*) grep -q " typeinfo for osgMidair::$name$" "$folder/defined" || continue ;;
    esac
    fail "$name is marked in an installed header, and isn't exported"
done < <(cat "$folder"/include/osgMidair/* | tr '\n' ' ' |
         grep -oE '(class|struct) OSGMIDAIR_EXPORT \w+|OSGMIDAIR_EXPORT (const |static )*[a-z][^(;{]*\(' |
         sed -E 's/ *\($//; s/.*[^A-Za-z0-9_=]([A-Za-z0-9_]+(==)?)$/\1/; s/operator==/operator/' | sort -u)
[ $marked -ge 40 ] || fail "only $marked marks were found"
echo "$marked classes and functions are marked, all exported"
