#!/usr/bin/env bash
# samples/pictures/make.sh: makes the README's pictures anew, from a build in build/ (samples/run.sh makes one).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
demo="build/bin/midair-demo --headless --frames 60 --width 960 --height 640"
$demo --out "$out/surface" >/dev/null
$demo --out "$out/vertices" --sampling vertices >/dev/null
cp "$out/surface/star_3.png" samples/pictures/star.png
cp "$out/vertices/star_5.png" samples/pictures/star-vertices.png
ls -l samples/pictures/*.png
