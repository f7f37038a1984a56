#!/usr/bin/env bash
# tests/samples/features/run.sh FOLDER SAMPLES [PRELOADED]: runs the programs of samples/features, which were built into FOLDER, two at
# a time and without a display, and compares what they print with expected.txt. SAMPLES: the folder of samples, for the model. Fails
# too if one of them isn't built, or isn't expected.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=$(cd "$1" && pwd) samples=$(cd "$2" && pwd) preload=${3:+LD_PRELOAD=$3}
if [ "${4:-}" ]; then # one of them, by the number of its line
    # shellcheck source=/dev/null
    mapfile -t lines < <(tail -n "+$4" "$here/expected.txt" | awk 'NR > 1 && /^@?[0-9]+-[-a-z]+:/ { exit } { print }')
    name=${lines[0]%%:*} arguments=${lines[0]#*:}
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    cd "$folder"
    arguments=${arguments/MODEL/$samples/models/star.obj} arguments=${arguments/OUT/$folder/out}
    window=()
    [ "${name#@}" = "$name" ] || window=(env OSG_RUN_FRAME_COUNT=300 OSG_RUN_MAX_FRAME_RATE=150 OSG_WINDOW='0 0 320 240' xvfb-run -a -s '-screen 0 640x480x24')
    name=${name#@}
    code=0
    # shellcheck disable=SC2086 # several arguments
    "${window[@]}" env $preload timeout 120 "$bin/$name" $arguments >"$folder/printed" 2>"$folder/errors" || code=$?
    for pattern in "${lines[@]:1}"; do
        grep -qE -e "$pattern" "$folder/printed" || { code="$code, and no line matches: $pattern"; break; }
    done
    [ "$code" = 0 ] || { echo "$name FAILED: $code"; cat "$folder/printed" "$folder/errors"; exit 1; } >&2
    echo "$name"
    exit
fi
for source in "$samples"/features/[0-9]*; do
    name=$(basename "${source%.*}")
    grep -qE "^@?$name:" "$here/expected.txt" || { echo "what $name prints isn't expected" >&2; exit 1; }
done
grep -nE '^@?[0-9]+-[-a-z]+:' "$here/expected.txt" | cut -d: -f1 |
    xargs -P 2 -I LINE "$0" "$bin" "$samples" "${3:-}" LINE
