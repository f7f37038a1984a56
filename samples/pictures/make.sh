#!/usr/bin/env bash
# samples/pictures/make.sh [PART..]: makes the pictures of README.md and of the guides anew, from a build in build/ (samples/run.sh and
# ninja -C build midair_samples make one). Parts: demo, start (of the tutorial), features (of the samples), scattering, installations, paper,
# tuning, monitor; all of them unless some are named. Needs imagemagick, xvfb, xdotool and fonts-dejavu-core; monitor needs a browser, by the
# packages of tests/run.sh --browser. imagemagick writes fields with 192 colours: no difference to be seen (PSNR over 45 dB) at a
# third of the size. The views hold more hues than that and are dithered. concepts.svg is drawn by hand.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$out"' EXIT
small() # FROM NAME
{
    convert "$1" -dither None -colors 192 -define png:compression-level=9 "PNG8:samples/pictures/$2.png"
}

# An X display without a screen, for windows and for the pictures of samples.
display()
{
    [ -z "$server" ] || return 0
    Xvfb -displayfd 3 -screen 0 1920x1080x24 -nolisten tcp 3>"$out/display" 2>/dev/null &
    server=$!
    until [ -s "$out/display" ]; do sleep 0.1; done
    DISPLAY=:$(cat "$out/display")
    export DISPLAY
}
# window FILE GEOMETRY SECONDS INPUT COMMAND..: takes a picture of a part of the display, 3 s after INPUT, the words of an xdotool command
# (or none), which follows SECONDS after a program's first frame.
window()
{
    "${@:5}" >"$out/window.log" 2>&1 &
    local program=$! colours=1 tries=60
    until [ "$colours" -gt 3 ] || [ $((tries--)) = 0 ]; do
        sleep 1
        import -window root -crop "$2" +repage "$out/window.ppm"
        colours=$(convert "$out/window.ppm" -format %k info:)
    done
    sleep "$3"
    # shellcheck disable=SC2086 # several words
    [ -z "$4" ] || xdotool $4
    sleep 3
    import -window root -crop "$2" +repage "$1"
    kill $program
    wait $program 2>/dev/null || true
}
# terminal FILE COLUMNS SIZE COMMAND: what a command line prints, dark on light.
terminal()
{
    local text
    text=$(printf '$ %s\n' "$4"; cd "$out"; bash -c "$4" 2>&1 || true)
    text=$(sed "s|$PWD/||g; s|$out/||g" <<<"$text" | fold -s -w "$2" | sed 's/[\\%]/&&/g')
    # A letter is 0.6 wide and a line 1.2 high, as to its size.
    convert -size "$(($2 * $3 * 61 / 100 + 2 * $3))x$(($(wc -l <<<"$text") * $3 * 118 / 100 + 2 * $3))" 'xc:#f7f7f4' -fill '#20242a' \
        -font DejaVu-Sans-Mono -pointsize "$3" -gravity northwest -annotate "+$3+$3" "$text" "$1"
}

part_demo()
{
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
}

# The tutorial's steps: samples/guides/START.md.
part_start()
{
    display
    export SAMPLES="$PWD/samples" PATH="$PWD/build/bin:$PATH" OSG_LIBRARY_PATH="$PWD/build/lib"
    local root=$PWD to=$PWD/samples/pictures/start viewer=(osgviewer --window 0 0 960 600) name
    mkdir -p "$to"
    step() { terminal "$out/step-$1.png" 100 15 "$2"; }
    step 0 'ls "$SAMPLES"'
    step 1 'midair-check "$SAMPLES"/models/star.obj'
    printf 'pressure = 4000 Pa\nsampling = edges\nmaxPressure = 5000\n' >"$out/touch.haptic"
    step 2 'midair-check "$SAMPLES"/models/star.obj --device touch.haptic'
    (cd "$out" && osgconv -O "size=0.08 pressure=4000 Pa touchEvents=true" "$SAMPLES"/models/star.obj.haptic mine.osgt >/dev/null)
    step 3 'midair-check mine.osgt'
    cd "$SAMPLES/models"
    local above="mousemove 480 240 mousedown 1 sleep 0.5 mousemove 480 290 sleep 0.5 mousemove 480 340 sleep 1 mouseup 1 sleep 1"
    window "$out/step-3-panel.png" 960x600+0+0 5 "$above key F7 sleep 5" "${viewer[@]}" panel.gltf.haptic
    cd "$out"
    window "$out/step-4.png" 960x600+0+0 5 "mousemove 480 300 key F7 sleep 5" "${viewer[@]}" mine.osgt
    OSG_MIDAIR_HANDS=mouse: window "$out/step-4-hand.png" 960x600+0+0 5 \
        "mousemove 480 300 sleep 1 key F6 sleep 0.5 mousemove 560 257 sleep 1 mousemove 561 257 sleep 2" "${viewer[@]}" mine.osgt
    OSG_MIDAIR_DEVICE=usb: OSG_MIDAIR_MAX_AMPLITUDE=0.2 OSG_MIDAIR_EAR_LIMIT=100 window "$out/step-5.png" 960x600+0+0 5 "mousemove 480 300 key F7 sleep 5" "${viewer[@]}" mine.osgt
    cd "$root"
    for name in 0 1 2 3 3-panel 4 4-hand 5; do
        convert "$out/step-$name.png" -dither None -colors 192 -define png:compression-level=9 "PNG8:$to/$name.png"
    done
}

# The pictures in the table of samples, samples/guides/CPP.md, 320 x 240.
thumbnail() # FILE NUMBER
{
    convert "$1" -resize 320x240 -background '#0d0f14' -gravity center -extent 320x240 -dither None -colors 128 \
        -define png:compression-level=9 "PNG8:samples/pictures/samples/$2.png"
}
# scene NUMBER SECONDS OVERLAYS [argument..]: the scene of a sample at that time, which it draws itself: samples/features/Picture.h.
scene()
{
    (cd "$out" && MIDAIR_PICTURE="$out/scene-$1.png,$2,$3" "$features"/"$1"-* "${@:4}" >/dev/null)
    thumbnail "$out/scene-$1.png" "$1"
}
# prints NUMBER [argument..]: what a sample prints, where a scene says nothing.
prints()
{
    local program
    program=$(basename "$features"/"$1"-*)
    PATH=$features:$PATH terminal "$out/prints-$1.png" 43 12 "$program ${*:2}"
    convert "$out/prints-$1.png" -crop 320x240+0+0 +repage -dither None -colors 16 "PNG8:samples/pictures/samples/$1.png"
}
part_features()
{
    display
    export OSG_LIBRARY_PATH="$PWD/build/lib"
    local features=$PWD/build/bin/features star=$PWD/samples/models/star.obj
    mkdir -p samples/pictures/samples
    OSG_WINDOW="0 0 960 720" window "$out/01.png" 960x720+0+0 5 "" "$features/01-first-touch" "$star"
    thumbnail "$out/01.png" 01
    scene 02 100 points,slice "$star"
    scene 03 100 points,slice,array
    scene 04 100 points,slice
    scene 05 100 points,slice
    prints 06
    (cd "$out" && "$features/07-reading-the-field" "$out/slice.png" >/dev/null)
    thumbnail "$out/slice.png" 07
    OSG_WINDOW="0 0 960 720" window "$out/08.png" 960x720+0+0 10 "" "$features/08-overlays"
    thumbnail "$out/08.png" 08
    scene 09 0.4 points,hands
    scene 10 0.55 points,hands
    scene 11 0.9 hands,contacts
    prints 12
    scene 13 1.8 points,hands
    scene 14 0.8 points,hands
    prints 15
    scene 16 0.5 points,ears
    scene 17 0.8 points,slice,array "$out/touch.midair"
    prints 18
    scene 19 100 points,slice,array "$out/desk.json"
    prints 20
    scene 21 100 points,slice
    scene 22 0.6 points,hands
    prints 23
    prints 24 "$star"
    PYTHONPATH=build/lib/python /usr/bin/python3 samples/python/star.py --out "$out/star" >/dev/null
    thumbnail "$out/star/star.png" 25
    window "$out/26.png" 800x600+60+60 5 "" "$features/26-headset"
    thumbnail "$out/26.png" 26
    scene 28 0.25 hands,contacts
    thumbnail samples/pictures/mirror.png 27 # what an eye sees of such a display: the part installations
}

# What stands in a field: samples/guides/ARRAYS.md.
part_scattering()
{
    {
        echo x_m,y_m,z_m,nx,ny,nz,target
        printf '%s,0,0.15,0,0,-1,1\n' -0.024 -0.012 0 0.012 0.024
    } >"$out/line.csv"
    echo '{"reflectors": [{"position_m": [0, 0, 0.19], "normal": [0, 0, -1], "along": [1, 0, 0], "size_m": [0.06, 0.06], "accuracy_mm": 0.1}]}' \
        >"$out/plate.json"
    python3 - >"$out/ball.obj" <<'PYTHON'
from math import cos, pi, sin
rings, sides = 16, 32
for i in range(1, rings):
    for j in range(sides):
        a, b = pi * i / rings, 2 * pi * j / sides
        print("v", 0.01 * sin(a) * cos(b) + 0.006, 0.01 * sin(a) * sin(b), 0.175 + 0.01 * cos(a))
print("v 0.006 0 0.185\nv 0.006 0 0.165")
top, bottom = (rings - 1) * sides + 1, (rings - 1) * sides + 2
for j in range(sides):
    k = (j + 1) % sides
    print("f", top, j + 1, k + 1)
    print("f", bottom, (rings - 2) * sides + k + 1, (rings - 2) * sides + j + 1)
    for i in range(rings - 2):
        a, b, c, d = i * sides + j + 1, i * sides + k + 1, (i + 1) * sides + j + 1, (i + 1) * sides + k + 1
        print("f", a, c, d, "\nf", a, d, b)
PYTHON
    scattered() # NAME [option..]
    {
        build/bin/midair-solve --array board --points-file "$out/line.csv" --out "$out/$1" "${@:2}" >/dev/null
        small "$out/$1/field.png" "$1"
    }
    scattered scattering-free
    scattered scattering-plate --scatterer reflectors --reflectors "$out/plate.json"
    scattered scattering-ball --scatterer "$out/ball.obj"
    scattered scattering-hand --scatterer hand --scatterer-at 0 0 0.153
}

# installation NAME FRAMES [option]..: the last frame of a run, with the program's own visitor.
installation()
{
    "build/bin/midair-$1" --headless --frames "$2" --pictures 1 --out "$out/$1" "${@:3}" >/dev/null
    convert "$out/$1/$1_1.png" -dither None -colors 256 "PNG8:samples/pictures/$1.png"
}
part_installations()
{
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
}

part_paper()
{
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
}

part_tuning()
{
    tune="build/bin/midair-tune"
    $tune plan --array board --mic 0.004 0.002 0.15 --mic 0.05 -0.01 0.17 --out "$out/plan.csv" >/dev/null
    $tune rehearse --plan "$out/plan.csv" --array board --seed 4 --dead 0.02 >"$out/lines"
    $tune run --plan "$out/plan.csv" --array board --device sim: --settle 0 --integrate 0 --all-places --quiet --readings "$out/lines" \
        --out "$out/readings.csv"
    $tune fit --plan "$out/plan.csv" --array board --readings "$out/readings.csv" --out "$out/tuning.json" --picture samples/pictures/tuning.svg >/dev/null
}

part_monitor()
{
    tests/samples/shared/monitor/browser.py build/bin --pictures "$out"
    convert "$out/monitor.png" -colors 256 PNG8:samples/pictures/monitor.png
}

[ $# -gt 0 ] || set -- demo start features scattering installations paper tuning monitor
for part in "$@"; do "part_$part"; done
ls -l samples/pictures/*.png samples/pictures/*.svg samples/pictures/*/*.png
