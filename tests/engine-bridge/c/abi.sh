#!/usr/bin/env bash
# tests/engine-bridge/c/abi.sh LIBRARY [--write]: compares the functions and types of libmidair.so with the description in
# engine-bridge/c/midair.abi, or writes it anew. What was added is no fault of a version, what was changed or taken away is.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
interface=$here/../../../engine-bridge/c
library=$(readlink -f "$1")
for tool in abidw abidiff; do
    command -v $tool >/dev/null || { echo "$tool isn't installed (abigail-tools): the ABI is not checked"; exit 77; }
done
now=$(mktemp)
trap 'rm -f "$now" "$now.changed" "$now.cpp"' EXIT
# C++ has a version node of its own, and no promise.
printf '[suppress_function]\nsymbol_name_not_regexp = ^midair_\ndrop = yes\n[suppress_variable]\nsymbol_name_not_regexp = ^midair_\ndrop = yes\n' >"$now.cpp"
# Of the types those of the three headers alone, without the machine's paths.
abidw --suppressions "$now.cpp" --headers-dir "$interface" --drop-private-types --exported-interfaces-only --no-corpus-path --no-comp-dir-path \
    --short-locs --type-id-style hash --no-show-locs "$library" >"$now"
functions=$(grep -c '<function-decl name=.midair_' "$now")
[ "$functions" -ge 50 ] || { echo "only $functions functions are described: is the library built without -g?" >&2; exit 1; }
if [ "${2:---check}" = --write ]; then
    cp "$now" "$interface/midair.abi"
    echo "$functions functions are described in midair.abi"
    exit 0
fi
[ "$(uname -m)" = x86_64 ] || { echo "midair.abi describes the library for x86_64, this is $(uname -m): the ABI is not checked"; exit 77; }
# What is not as described is found: a function that is gone, a struct that has grown.
differs()
{
    sed "$1" "$interface/midair.abi" >"$now.changed"
    ! cmp -s "$interface/midair.abi" "$now.changed" || { echo "midair.abi has no place for $1" >&2; exit 1; }
    ! abidiff --no-added-syms "$now.changed" "$now" >/dev/null || { echo "abidiff overlooks $1" >&2; exit 1; }
}
differs "s/midair_cancel/midair_revoke/g"
differs "/name='midair_device_state' size-in-bits/s/size-in-bits='[0-9]*'/size-in-bits='64'/"
code=0
abidiff --no-added-syms "$interface/midair.abi" "$now" || code=$?
[ $code -eq 0 ] || { echo "the ABI has changed (abidiff: $code): programs that are built against this version wouldn't run" >&2; exit 1; }
echo "$functions functions, as described in midair.abi"
