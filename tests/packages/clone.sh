#!/usr/bin/env bash
# tests/packages/clone.sh: clones this tree's newest commit into a clean Debian 12 and runs ./samples/run.sh there, as somebody does who has
# just found it: the moving field has to be on a screen (Xvfb) within 5 minutes, without the time that Debian's packages take to come.
# Needs root; this machine stays as it is.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
. tests/packages/root.sh
[ "$(id -u)" = 0 ] || { echo "tests/packages/clone.sh makes a root of its own, which only root can" >&2; exit 1; }
midair_install git "${midair_root_packages[@]}"
kept=$PWD/build-packages/root
mkdir -p "$kept" build-packages/screens
root_clean "$kept/clean.tar"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
tar -C "$folder" -xf "$kept/clean.tar"
git clone -q --no-hardlinks . "$folder/osgMidair"
cp tests/packages/watch.py "$folder"
status=0
# shellcheck disable=SC2016 # expanded inside
root_run "$folder" "$kept/archives" bash -euc '
    apt-get update -qq
    apt-get install -y -qq --no-install-recommends xvfb python3 python3-numpy >/dev/null 2>&1 # to look at the screen
    begin=$SECONDS
    . /osgMidair/samples/packages.sh
    midair_install "${midair_packages[@]}" 2>/dev/null
    echo "packages of Debian: $((SECONDS - begin)) s, of which downloads and disk decide"
    mkdir /work
    cd /work
    python3 /watch.py --within $((300 * MIDAIR_TIME_FACTOR)) --png screen.png /osgMidair/samples/run.sh' || status=$?
cp "$folder/work/screen.png" build-packages/screens/clone.png 2>/dev/null || true
exit $status
