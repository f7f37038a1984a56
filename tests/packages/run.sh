#!/usr/bin/env bash
# tests/packages/run.sh [FOLDER]: installs the Debian packages in FOLDER, or those that samples/debian/build.sh makes now, into a clean
# Debian 12 of its own, uses them there as somebody does who has nothing else, and removes them. Needs root; this machine stays as it is.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
. tests/packages/root.sh
[ "$(id -u)" = 0 ] || { echo "tests/packages/run.sh makes a root of its own, which only root can" >&2; exit 1; }
midair_install "${midair_root_packages[@]}"
packages=${1:-}
if [ -z "$packages" ]; then
    samples/debian/build.sh
    packages=build-packages/packages
fi
kept=$PWD/build-packages/root # of Debian alone: what other runs take over
mkdir -p "$kept"
root_clean "$kept/clean.tar"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
tar -C "$folder" -xf "$kept/clean.tar"
mkdir "$folder/packages" "$folder/tests"
cp "$packages"/*.deb "$folder/packages"
cp -r tests/consumer tests/packages samples/debian "$folder/tests"
status=0
root_run "$folder" "$kept/archives" bash /tests/packages/inside.sh || status=$?
# What was on the screen, for people.
mkdir -p build-packages/screens
cp "$folder"/home/visitor/*.png build-packages/screens 2>/dev/null || true
[ $status = 0 ] || exit $status
echo "pictures of the screen: build-packages/screens"
