#!/usr/bin/env bash
# tests/samples/installations/service.sh UNIT BIN: the systemd unit of the installations. It is verified, and then a systemd of its own,
# in namespaces of its own, runs it: the program is ended by signals, stopped, and seen to come back; after three crashes it is muted; it
# ends as it is asked to. The real run needs root and namespaces, and says so where they aren't.
set -euo pipefail
unit=$1 bin=$2
fail()
{
    echo "FAILED: $*" >&2
    [ -z "${folder:-}" ] || tail -n 20 "$folder"/*.log >&2 || true
    exit 1
}
command -v systemd-analyze >/dev/null || { echo "SKIPPED: there is no systemd"; exit 0; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
chmod 755 "$folder"
# The unit as it is installed, but for the programs' folder.
sed "s#@MIDAIR_PROGRAMS@#$bin#; s#@MIDAIR_DOCUMENTS@#/usr/share/doc/osgMidair#" "$unit" >"$folder/midair-installation@.service"
for name in toybox piano gallery water desk mirror plate paper-scenes; do
    systemd-analyze verify "$folder/midair-installation@$name.service" || fail "the unit of $name"
done
! systemd-analyze verify "$folder/midair-installation@nowhere.service" 2>/dev/null || fail "an installation that isn't there passed"
echo "verified for 6 installations"

if [ "${1:-}" ] && [ "$(id -u)" -ne 0 ] || ! unshare --pid --fork --mount --mount-proc --cgroup true 2>/dev/null ||
    [ ! -x /lib/systemd/systemd ]; then
    echo "the real run is SKIPPED: it needs root, namespaces and systemd"
    exit 0
fi
export folder
cat >"$folder/inside.sh" <<'INSIDE'
set -e
mount --make-rprivate /
mount -t tmpfs tmpfs /run
mkdir -p /run/systemd/system /run/lock /run/installation
mount -t tmpfs tmpfs /etc/systemd/system
cp "$folder"/midair-installation@.service /etc/systemd/system/
mkdir /etc/systemd/system/midair-installation@desk.service.d
# Without a display, as root, and with less patience than in an exhibition. Devices aren't shut out: not every container lets that be.
cat >/etc/systemd/system/midair-installation@desk.service.d/test.conf <<CONF
[Unit]
DefaultDependencies=no
[Service]
User=root
SupplementaryGroups=
DevicePolicy=auto
DeviceAllow=
ProtectSystem=no
StateDirectory=
Environment=STATE_DIRECTORY=/run/installation
Environment="MIDAIR_ARGUMENTS=--headless --minutes 30 --pictures 0 --device null: --out /run/installation"
WatchdogSec=6
RestartSec=0.2
CONF
cat >/etc/systemd/system/test.target <<CONF
[Unit]
DefaultDependencies=no
AllowIsolate=yes
Wants=midair-installation@desk.service
CONF
export container=lxc
exec /lib/systemd/systemd --system --unit=test.target --log-target=console --show-status=no
INSIDE
unshare --pid --fork --kill-child --mount --mount-proc --cgroup bash "$folder/inside.sh" >"$folder/systemd.log" 2>&1 </dev/null &
helper=$!
first=
for _ in $(seq 100); do
    first=$(pgrep -P "$helper" | head -n 1) || true
    [ -z "$first" ] || break
    sleep 0.1
done
[ -n "$first" ] || fail "no systemd began"
trap 'kill -KILL "$first" "$helper" 2>/dev/null; wait 2>/dev/null; rm -rf "$folder"' EXIT
in_there() { nsenter --target "$first" --pid --mount "$@"; }
show() { in_there systemctl show --value --property="$1" midair-installation@desk.service 2>/dev/null || true; }
# running OLD: waits until the service is active with another process than OLD, and prints it.
running()
{
    local main
    for _ in $(seq 600); do
        main=$(show MainPID)
        if [ "$(show ActiveState)" = active ] && [ "${main:-0}" != 0 ] && [ "$main" != "$1" ]; then
            echo "$main"
            return 0
        fi
        sleep 0.1
    done
    return 1
}
state() { in_there cat /run/installation/desk.json; }

main=$(running 0) || fail "it never said that it is ready: $(show StatusText)"
echo "ready as process $main: $(show StatusText)"
for signal in SEGV KILL STOP; do
    in_there kill -$signal "$main"
    next=$(running "$main") || fail "it didn't come back after $signal"
    echo "after SIG$signal process $main came back as $next; restarts: $(show NRestarts); $(state)"
    main=$next
done
[ "$(show NRestarts)" -ge 3 ] || fail "systemd counts $(show NRestarts) restarts"
case $(state) in
    *'"muted":true'*) echo "after three crashes it is muted" ;;
    *) fail "after three crashes it isn't muted: $(state)" ;;
esac
for _ in $(seq 100); do
    case $(show StatusText) in *muted*) break ;; esac
    sleep 0.1
done
case $(show StatusText) in *muted*) ;; *) fail "its status isn't muted: $(show StatusText)" ;; esac
in_there systemctl kill --signal=USR2 midair-installation@desk.service
for _ in $(seq 200); do
    case $(state) in *'"muted":false'*) break ;; esac
    sleep 0.1
done
case $(state) in *'"muted":false'*) echo "SIGUSR2 lets it play" ;; *) fail "SIGUSR2 did nothing: $(state)" ;; esac
in_there systemctl stop midair-installation@desk.service
case $(state) in
    *'"running":false'*) echo "stopped: $(state)" ;;
    *) fail "it didn't end as it was asked to: $(state)" ;;
esac
