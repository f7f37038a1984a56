#!/usr/bin/env bash
# samples/run.sh [MODEL or SCENE] [options]: installs missing packages, builds, and shows an object in the array with its field.
# Without arguments it shows the paper's star. --help lists the options.
set -euo pipefail
caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
. samples/packages.sh
midair_install "${midair_packages[@]}"
midair_build build midair_run
cd "$caller"
out=()
case " $* " in
    *" --out"* | *" --help "* | *" -h "*) ;;
    *) out=(--out "$root/build/out") ;;
esac
exec "$root/build/bin/midair-demo" "$@" "${out[@]}"
