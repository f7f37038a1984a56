#!/usr/bin/env bash
# samples/pictures/make.sh: makes the README's pictures anew, from a build in build/ (samples/run.sh makes one). Needs
# imagemagick, which brings them under 300 kB with 256 colours.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
demo="build/bin/midair-demo --headless --frames 60"
$demo --out "$out/surface" >/dev/null
$demo --out "$out/vertices" --sampling vertices >/dev/null
convert "$out/surface/star_3.png" -colors 256 PNG8:samples/pictures/star.png
convert "$out/vertices/star_5.png" -colors 256 PNG8:samples/pictures/star-vertices.png
build/bin/midair-paper --out "$out/paper" >/dev/null
for name in paper_focus paper_line_gs paper_star_gs paper_star_sdp-bcd; do
    convert "$out/paper/$name.png" -colors 256 "PNG8:samples/pictures/$name.png"
done
ls -l samples/pictures/*.png
