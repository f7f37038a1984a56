#!/usr/bin/env bash
# tests/consumer/documents.sh BUILD: installs everything of that build into a temporary prefix. There each link of each document
# leads to something, and what documents tell somebody who has the prefix alone can be done.
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
for component in kit tools libraries c; do cmake --install "$build" --component $component --prefix "$folder/usr" >/dev/null; done

links=0
while read -r document; do
    while read -r target; do
        [ -e "$(dirname "$document")/$target" ] || fail "${document#"$folder/usr/"} links to $target, which isn't installed"
        links=$((links + 1))
    done < <(grep -oE '\]\([^)# ]+' "$document" | sed 's/^](//' | grep -v '^http' || true)
done < <(find "$folder/usr" -name '*.md')
[ $links -ge 30 ] || fail "only $links links were found"
echo "$links links of installed documents"

# The getting-started and the guide for C++, for somebody who has the prefix alone.
xvfb-run -a -s '-screen 0 640x480x24' "$here/../documents/blocks.py" --root "$here/../.." --prefix "$folder/usr" samples/guides/START.md \
    samples/guides/CPP.md samples/guides/C.md
