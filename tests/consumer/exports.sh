#!/usr/bin/env bash
# tests/consumer/exports.sh BUILD: installs everything of that build into a temporary prefix and compares what each shared object
# exports with what the installed headers declare, both ways: a name that stands in no header is nobody's to use, and a class or
# function that a header marks has to be there.
set -euo pipefail
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
for component in kit tools libraries; do cmake --install "$build" --component $component --prefix "$folder" >/dev/null; done

# words FILE..: the identifiers in them, comments left out.
words()
{
    cat "$@" | sed 's,//.*,,' | grep -oE '[A-Za-z_][A-Za-z_0-9]*' | sort -u
}
# names FILE: names that it exports, without arguments: "osgMidair::HapticScene::update".
names()
{
    nm -DC --defined-only "$1" | sed -E 's/^[0-9a-f]* +[A-Za-z] +//; s/@.*//; s/ \[clone .*//
        s/^(vtable|VTT|typeinfo|typeinfo name|guard variable|reference temporary #[0-9]+) for //; s/^(non-)?virtual thunk to //
        s/\(.*//; s/operator[^A-Za-z_]*$/operator/; s/\[abi:[^]]*\]//g' | sort -u
}

words "$folder"/include/osgMidair/* >"$folder/words"
echo midairDrawPicture >"$folder/picture-words" # samples/solve/Picture.h, which says that it is all
grep -q midairDrawPicture "$folder/share/osgMidair/samples/solve/Picture.h" || fail "Picture.h isn't installed"
looked=0
while read -r library; do
    known=$folder/words
    case $(basename "$library") in
    midair-picture.so) known=$folder/picture-words ;;
    osgdb_*) known=/dev/null ;;
    esac
    names "$library" >"$folder/names"
    # Each part of a name has to be a word of the headers.
    awk 'FILENAME == ARGV[1] { known[$0] = 1; next }
         { name = $0; gsub(/<.*>/, "", name); parts = split(name, part, "::"); bad = parts == 0
           for (i = 1; i <= parts; ++i) { sub(/^~/, "", part[i]); if (!(part[i] in known)) bad = 1 }
           if (bad) print }' "$known" "$folder/names" >"$folder/others"
    [ ! -s "$folder/others" ] || fail "$(basename "$library") exports what stands in no installed header:"$'\n'"$(cat "$folder/others")"
    echo "$(basename "$library"): $(wc -l <"$folder/names") names, all of installed headers"
    looked=$((looked + 1))
done < <(find "$folder" -name '*.so*' -type f)
[ $looked -eq 6 ] || fail "$looked shared objects are installed, 6 were looked for"

# Whatever a header marks. A class that is inline as a whole leaves nothing to export: not even its type is in the library.
library=$(readlink -f "$(find "$folder" -name libosgMidair.so)")
names "$library" >"$folder/names"
nm -C --defined-only "$library" >"$folder/defined"
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
