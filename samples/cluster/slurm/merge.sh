#!/usr/bin/env bash
# The last job of submit.sh: merge.sh SHARDS PARTS PROGRAM OUT
set -euo pipefail
files=()
for ((task = 1; task <= $1; ++task)); do files+=("$2/$task.part"); done
"$3" --merge "${files[@]}" --out "$4"
