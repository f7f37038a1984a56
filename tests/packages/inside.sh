#!/usr/bin/env bash
# Runs as root in the clean Debian of tests/packages/run.sh: /packages has the packages, /tests what they are tested with.
# shellcheck disable=SC2016 # visitor's shell expands
set -euo pipefail
cd /
fail()
{
    echo "FAILED: $*" >&2
    exit 1
}
# visitor COMMAND: runs a line of the shell as a user who has just come: no variable is set, no folder but the own.
visitor()
{
    su - visitor -c "$1"
}
# install PACKAGE..: from Debian, with what they depend on and no more.
install()
{
    apt-get install -y -qq --no-install-recommends "$@" >/tmp/apt.log 2>&1 || fail "apt-get install $*: $(cat /tmp/apt.log)"
}
# packaged NAME..: the files of packages of ours with these names, whatever their versions.
packaged()
{
    local name
    # shellcheck disable=SC2086 # a pattern
    for name in "$@"; do ls /packages/${name}_*.deb || fail "there is no package $name"; done
}
# depended FILE..: what these packages need of Debian's.
depended()
{
    local own file
    own=$(for file in /packages/*.deb; do dpkg-deb -f "$file" Package; done | paste -sd'|')
    for file in "$@"; do dpkg-deb -f "$file" Depends; done | tr ',' '\n' | sed 's/^ *//' | grep -vE "^(($own)( |$)|$)" | sort -u | paste -sd,
}
# listed FILE: all that is on the disk and isn't a cache or a log, with the contents of what is configured.
listed()
{
    find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /run -o -path /tmp -o -path /home -o -path /packages -o -path /tests \
        -o -path /var/cache -o -path /var/log -o -path '/var/lib/dpkg/*-old' -o -path /var/lib/apt -o -path '/usr/lib/python3*/__pycache__' \) \
        -prune -o -printf '%y %p\n' | sort >"$1"
    dpkg-query -W -f '${Package} ${db:Status-Status}\n' >>"$1"
    find /etc -type f ! -name ld.so.cache -exec sha256sum {} + | sort >>"$1"
}

apt-get update -qq
id visitor >/dev/null 2>&1 || useradd --create-home --shell /bin/bash visitor
# Nothing of a compiler yet: what a program lacks when it runs is missing here.
install xvfb xauth openscenegraph udev systemd procps
mapfile -t running < <(packaged osgmidair-data 'libosgmidair[0-9.]*' 'libmidair[0-9.]*' python3-midair osgmidair-tools)
apt-get satisfy -y -qq --no-install-recommends "$(depended "${running[@]}")" >/tmp/apt.log 2>&1 || fail "$(cat /tmp/apt.log)"
listed /tmp/before
dpkg -i "${running[@]}" >/tmp/dpkg.log 2>&1 || fail "dpkg -i: $(cat /tmp/dpkg.log)"
echo "== installed: $(basename -a "${running[@]}" | paste -sd' ')"

cp /tests/packages/watch.py /tests/packages/solve.py /home/visitor
scenes=/usr/share/osgMidair/samples/scenes
visitor 'env' | grep -E 'OSG|LD_|MIDAIR' && fail "a variable is set"
visitor "python3 watch.py --within $((5 * MIDAIR_TIME_FACTOR)) --maps libosgMidair.so --png demo.png midair-demo" || fail "midair-demo shows no moving field"
visitor "python3 watch.py --still --within $((60 * MIDAIR_TIME_FACTOR)) --maps libosgMidair.so --png osgviewer.png osgviewer --window 60 60 1200 800 $scenes/star-overlays.osgt" ||
    fail "osgviewer shows no field"
visitor "osgconv $scenes/star.osgt copy.osgt >/dev/null && grep -q osgMidair::HapticScene copy.osgt" || fail "osgconv doesn't copy a scene"
visitor "midair-solve /usr/share/osgMidair/samples/models/star.obj --size 0.08 --out solved >/dev/null" || fail "midair-solve"
for file in summary.json drive.csv field.png; do [ -s /home/visitor/solved/$file ] || fail "midair-solve writes no $file"; done
visitor "midair-check $scenes/star.osgt >/dev/null" || fail "midair-check doesn't find the star felt: $?"
visitor "midair-device circle --device sim: --array board --seconds 0.2 >/dev/null" || fail "midair-device plays nothing"
visitor "python3 solve.py" || fail "Python doesn't solve"

# The rule: systemd's own reader finds it and nothing wrong in it, but does in a broken one.
rule=70-osgmidair.rules
said=$(udevadm test /sys/devices/virtual/net/lo 2>&1 || true)
grep -q "Reading rules file: .*/$rule" <<<"$said" || fail "udev doesn't read $rule: $said"
! grep "$rule:" <<<"$said" || fail "udev finds fault with $rule"
sed 's/ATTR{idVendor}/NOSUCH{idVendor}/' "$(dpkg -L osgmidair-tools | grep "$rule")" >/etc/udev/rules.d/71-broken.rules
said=$(udevadm test /sys/devices/virtual/net/lo 2>&1 || true)
rm /etc/udev/rules.d/71-broken.rules
grep -q '71-broken.rules:' <<<"$said" || fail "udev finds no fault with a broken rule either: the test above says nothing"
echo "== udev reads $rule, and finds nothing wrong in it"
units=0
mkdir -p /tmp/units
while read -r unit; do
    # A template is looked at as one of its units.
    sed 's/%i/toybox/g' "$unit" >"/tmp/units/$(basename "${unit/@./@toybox.}")"
    systemd-analyze verify "/tmp/units/$(basename "${unit/@./@toybox.}")" || fail "systemd finds fault with $unit"
    units=$((units + 1))
done < <(dpkg -L osgmidair-tools | grep '/systemd/.*\.service$' || true)
[ $units -gt 0 ] || fail "no unit of systemd is installed"
echo "== systemd finds nothing wrong in $units units"
man -w midair-demo >/dev/null 2>&1 || [ -s /usr/share/man/man1/midair-demo.1.gz ] || fail "midair-demo has no man page"

dpkg --purge "$(dpkg-deb -f "${running[0]}" Package)" >/dev/null 2>&1 && fail "the data can be removed below the libraries"
# purged FILE..: removes these packages and compares what is there with what was before.
purged()
{
    local file
    for file in "$@"; do dpkg-deb -f "$file" Package; done | xargs dpkg --purge >/tmp/dpkg.log 2>&1 || fail "$(cat /tmp/dpkg.log)"
    listed /tmp/after
    diff /tmp/before /tmp/after || fail "removing left or took something, see above"
    echo "== removed without a rest: $(wc -l </tmp/before) lines of files and settings are as before"
}
purged "${running[@]}"

# Programs that are built against the packages.
mapfile -t all < <(ls /packages/*.deb)
install g++ cmake make pkg-config
apt-get satisfy -y -qq --no-install-recommends "$(depended "${all[@]}")" libcli11-dev libbullet-dev >/tmp/apt.log 2>&1 || fail "$(cat /tmp/apt.log)"
listed /tmp/before
dpkg -i "${all[@]}" >/tmp/dpkg.log 2>&1 || fail "dpkg -i: $(cat /tmp/dpkg.log)"
cp -r /tests/consumer /home/visitor
visitor "cmake -S consumer -B built -DCMAKE_BUILD_TYPE=Release >log 2>&1 && cmake --build built --target consumer reader >log 2>&1 &&
         built/consumer && built/reader $scenes/star.osgt octagon" || fail "a consumer by find_package: $(tail -40 /home/visitor/log)"
echo "== C++ by find_package"
visitor 'g++ -std=c++17 -Wall -Wextra -Werror consumer/main.cpp $(pkg-config --cflags --libs osgMidair) -o by-pkg-config && ./by-pkg-config' ||
    fail "a consumer by pkg-config"
echo "== C++ by pkg-config"
visitor 'gcc -std=c99 -D_POSIX_C_SOURCE=199309L -Wall -Wextra -Werror consumer/c/main.c $(pkg-config --cflags --libs midair) -o c && ./c' ||
    fail "a consumer in C"
echo "== C by pkg-config"
visitor "cmake -S consumer/without-scene -B alone -DCMAKE_BUILD_TYPE=Release -DMIDAIR_SAMPLES=/usr/share/osgMidair/samples >log 2>&1 &&
         cmake --build alone >log 2>&1 && alone/without-scene >log" || fail "the static libraries: $(tail -40 /home/visitor/log)"
echo "== static libraries"
purged "${all[@]}"
