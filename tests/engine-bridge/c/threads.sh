#!/usr/bin/env bash
# tests/engine-bridge/c/threads.sh FOLDER DOCUMENT: each function of the headers stands once in the document's table of threads, and no other does.
set -euo pipefail
folder=$1
declared=$(grep -h -v '^ *//' "$folder"/midair*.h | grep -A1 'MIDAIR_API' | grep -oE 'midair_[a-z_0-9]+\(' | tr -d '(' | sort)
told=$(sed -n '/^| function | from | waits for |/,/^$/p' "$2" | cut -d"|" -f2 | grep -oE 'midair_[a-z_0-9]+' | sort)
[ "$(wc -l <<<"$declared")" -ge 50 ] || { echo "no functions were found in $folder" >&2; exit 1; }
diff <(echo "$declared") <(echo "$told") >&2 ||
    { echo "< is in the headers and not in the table of threads, > the other way round" >&2; exit 1; }
echo "$(wc -l <<<"$declared") functions"
