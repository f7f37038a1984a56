#!/usr/bin/env bash
# samples/pictures/make.sh: makes the pictures of README.md and of the guides anew, from a build in build/ (samples/run.sh makes one). Needs
# imagemagick, which writes fields with 192 colours: no difference to be seen (PSNR over 45 dB) at a third of the size. The
# views hold more hues than that and are dithered. concepts.svg is drawn by hand.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
small() # FROM NAME
{
    convert "$1" -dither None -colors 192 -define png:compression-level=9 "PNG8:samples/pictures/$2.png"
}
demo="build/bin/midair-demo --headless --frames 60"
$demo --out "$out/surface" --overlays points,slice,array,workspace,figures >/dev/null
build/bin/midair-demo --headless --frames 108 --hands samples/hands/star.csv --render contact --zoom 1.8 --out "$out/contacts" \
    --overlays points,figures,hands,contacts >/dev/null
cp "$out/contacts/star_5.png" samples/pictures/contacts.png
build/bin/midair-demo --headless --frames 40 --still --overlays ears,figures --out "$out/ears" >/dev/null
cp "$out/ears/star_6.png" samples/pictures/ears.png
convert "$out/surface/star_3.png" -colors 256 PNG8:samples/pictures/star.png
# touch.gif: the last picture of runs that are longer by three frames each, while the recorded finger touches the star; then backwards.
for frames in $(seq 52 3 112); do
    build/bin/midair-demo --headless --frames "$frames" --hands samples/hands/star.csv --render contact --zoom 2.6 --width 640 --height 400 \
        --overlays points,slice,hands,contacts --out "$out/touch" >/dev/null
    mv "$out/touch/star_6.png" "$out/touch/frame_$(printf %03d "$frames").png"
done
convert -delay 8 "$out"/touch/frame_*.png -crop 440x360+110+40 +repage \( -clone 0--1 -reverse \) -loop 0 -dither None -colors 96 \
    -layers optimize samples/pictures/touch.gif
# installation NAME FRAMES [option]..: the last frame of a run, with the program's own visitor.
installation()
{
    "build/bin/midair-$1" --headless --frames "$2" --pictures 1 --out "$out/$1" "${@:3}" >/dev/null
    convert "$out/$1/$1_1.png" -dither None -colors 256 "PNG8:samples/pictures/$1.png"
}
installation toybox 90
installation piano 150
installation gallery 150 --seconds 1.5
installation water 60
installation desk 60
for name in mirror plate; do
    installation $name 90 --display sim:samples/displays/$name.display.json
    python3 samples/displays/draw.py samples/displays/$name.display.json --board 150 --out samples/pictures/$name.svg
done
installation paper-scenes 60 --scene 3 --hands none
build/bin/midair-paper --out "$out/paper" >/dev/null
for name in paper_focus paper_line_gs paper_star_gs paper_star_sdp-bcd; do
    small "$out/paper/$name.png" "$name"
done
for name in figure3 figure4 figure6 figure7; do
    small "$out/paper/paper_$name.png" "paper/$name"
done
# Sessions of simulated participants, each with a threshold of its own.
participant=1
for threshold in 17.9 11 14 16 18 20 23 27; do
    build/bin/midair-jnd --headless --minutes 5 --pictures 0 --participant P0$participant --simulate --threshold $threshold --spread 5 \
        --seed $participant --reference 0 --between 0 --line 0.05 --rest 0 --results "$out/P0$participant.csv" --out "$out/jnd" >/dev/null
    participant=$((participant + 1))
done
small "$out/P01.png" paper/jnd_session
build/bin/midair-jnd plot "$out"/P0?.csv --out "$out/group.png" >/dev/null
small "$out/group.png" paper/jnd_group
tune="build/bin/midair-tune"
$tune plan --array board --mic 0.004 0.002 0.15 --mic 0.05 -0.01 0.17 --out "$out/plan.csv" >/dev/null
$tune rehearse --plan "$out/plan.csv" --array board --seed 4 --dead 0.02 >"$out/lines"
$tune run --plan "$out/plan.csv" --array board --device sim: --settle 0 --integrate 0 --all-places --quiet --readings "$out/lines" \
    --out "$out/readings.csv"
$tune fit --plan "$out/plan.csv" --array board --readings "$out/readings.csv" --out "$out/tuning.json" --picture samples/pictures/tuning.svg >/dev/null
# Needs a browser: the packages of tests/run.sh --browser.
tests/samples/shared/monitor/browser.py build/bin --pictures "$out"
convert "$out/monitor.png" -colors 256 PNG8:samples/pictures/monitor.png
ls -l samples/pictures/*.png samples/pictures/*.svg
