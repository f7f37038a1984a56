#!/usr/bin/env bash
# tests/consumer/documents.sh BUILD: installs everything of that build into a temporary prefix. There each link of each document
# leads to something, and the tutorial's commands do what it says, for somebody who has the prefix alone.
set -euo pipefail
build=$(cd "$1" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
fail()
{
    echo "$*" >&2
    exit 1
}
for component in kit tools libraries; do cmake --install "$build" --component $component --prefix "$folder/usr" >/dev/null; done

links=0
while read -r document; do
    while read -r target; do
        [ -e "$(dirname "$document")/$target" ] || fail "${document#"$folder/usr/"} links to $target, which isn't installed"
        links=$((links + 1))
    done < <(grep -oE '\]\([^)# ]+' "$document" | sed 's/^](//' | grep -v '^http' || true)
done < <(find "$folder/usr" -name '*.md')
[ $links -ge 30 ] || fail "only $links links were found"
echo "$links links of installed documents"

tutorial=$(find "$folder/usr/share/doc" -name TUTORIAL.md)
# What the first block sets, with this prefix for the one that it names.
awk '/^```sh/ { block = 1; next } /^```/ { exit } block' "$tutorial" | sed "s|^PREFIX=.*|PREFIX=$folder/usr|" >"$folder/settings"
grep -q "^PREFIX=$folder/usr" "$folder/settings" || fail "the tutorial's first block doesn't set PREFIX"
mkdir "$folder/home" "$folder/work"
# What needs a display, or hardware, is left to people.
commands=0
while read -r line; do
    (cd "$folder/work" && env -i PATH=/usr/bin:/bin HOME="$folder/home" bash -c ". $folder/settings; $line" >"$folder/log" 2>&1) ||
        fail "$line: $(cat "$folder/log")"
    commands=$((commands + 1))
done < <(grep '^    ' "$tutorial" | sed 's/^    //' | grep -v osgviewer)
[ $commands -ge 6 ] || fail "only $commands commands were run"
[ -s "$folder/work/mine.osgt" ] || fail "there is no mine.osgt"
echo "$commands commands of the tutorial"
