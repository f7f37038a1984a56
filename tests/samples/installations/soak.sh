#!/usr/bin/env bash
# tests/samples/installations/soak.sh BIN [MINUTES [NAME..]]: runs installations (all) headless for MINUTES (30), all at once and in real
# time, and mutes each for some seconds now and then by a signal. It fails where memory grows, a message comes twice a second, a field is
# lost, or something sounds that must be silent. Without MINUTES it is for tests/run.sh --long, and else SKIPPED.
set -euo pipefail
bin=$1
if [ $# -lt 2 ] && [ "${MIDAIR_LONG_TESTS:-0}" != 1 ]; then
    echo "SKIPPED: half an hour, for tests/run.sh --long"
    exit 0
fi
minutes=${2:-30}
shift $(($# < 2 ? $# : 2))
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(toybox piano gallery water desk mirror plate paper-scenes jnd)
folder=$(mktemp -d)
# A participant who takes longer than any soak.
declare -A own=([jnd]="--participant P01 --simulate --times 100 --results $folder/jnd.csv")
programs=()
trap 'kill "${programs[@]}" 2>/dev/null || true; rm -rf "$folder"' EXIT
for name in "${names[@]}"; do
    # shellcheck disable=SC2086 # words
    "$bin/midair-$name" --headless --minutes "$minutes" --pictures 0 --linger 1 --out "$folder/$name" ${own[$name]:-} >"$folder/$name.log" 2>&1 &
    programs+=($!)
done
# A mute of four seconds in every forty.
end=$((SECONDS + $(awk "BEGIN { print int($minutes * 60) }")))
while [ $SECONDS -lt $end ]; do
    sleep 18
    kill -USR1 "${programs[@]}" 2>/dev/null || break
    sleep 4
    kill -USR2 "${programs[@]}" 2>/dev/null || break
    sleep 18
done
status=0
for i in "${!names[@]}"; do
    wait "${programs[$i]}" || { echo "midair-${names[$i]} ended with an error" >&2; status=1; }
done
for name in "${names[@]}"; do
    cat "$folder/$name.log"
    python3 - "$folder/$name" "$minutes" <<'CHECK' || status=1
import json, sys
folder, minutes = sys.argv[1], float(sys.argv[2])
report = json.load(open(folder + "/report.json"))
wrong = []
def expect(what, is_right):
    if not is_right:
        wrong.append(what)
memory, silence, fields = report["memory_MB"], report["silence"], report["fields"]
expect(f"it ran for {report['seconds']:.0f} s", report["seconds"] > 0.95 * 60 * minutes)
# Two megabytes are what allocators of the solver's threads come and go with.
expect(f"memory grew from {memory['settled']:.1f} to {memory['end']:.1f} MB", memory["end"] < memory["settled"] + 2 + 0.1 * minutes)
expect(f"messages came too often: {report['tooOften']}", not report["tooOften"])
lines = open(folder + ".log").read().count("\n")
# A participant is told of each trial that a mute has spoilt.
expect(f"it printed {lines} lines", lines < 40 + 2 * minutes)
expect(f"it played while it was muted: {silence}", silence["playedMuted"] == 0 and silence["framesMuted"] > 60)
# Its scenes are there for somebody who looks; lines of the experiment are felt without a tracker.
isVisited = report["installation"] not in ("paper-scenes", "jnd")
expect(f"it played while nobody was there: {silence}", silence["playedAlone"] == 0 and (silence["framesAlone"] > 60 or not isVisited))
expect(f"fields went wrong: {fields}", fields["lost"] + fields["refused"] + fields["faults"] == 0)
expect("nothing was touched", report["touches"] > 0 or not isVisited)
expect("nothing was played", fields["played"] > 0)
for each in wrong:
    print(f"FAILED: {report['installation']}: {each}")
sys.exit(1 if wrong else 0)
CHECK
done
[ $status = 0 ] && echo "quiet for $minutes minutes: ${names[*]}"
exit $status
