#!/usr/bin/env bash
# usage: tests/fuzz/run.sh [SECONDS]   fuzzes the protocol's and the recording's readers with libFuzzer (needs clang), each for so
# long (60). New inputs go into build/fuzz/; what finds a fault stays there as crash-*.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-60}
command -v clang++ > /dev/null || { echo "tests/fuzz: clang++ is missing (apt install clang): skipped"; exit 0; }
mkdir -p build/fuzz
for target in Protocol Recording; do
    name=${target,,}
    clang++ -std=c++17 -g -O1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -I. \
        "tests/fuzz/Fuzz$target.cpp" tests/fuzz/FuzzTargets.cpp \
        device/Protocol.cpp device/VirtualFirmware.cpp device/Recording.cpp device/Crc32c.cpp -o "build/fuzz/fuzz_$name"
    mkdir -p "build/fuzz/$name"
    "build/fuzz/fuzz_$name" -max_total_time="$seconds" -max_len=4096 -artifact_prefix=build/fuzz/ -print_final_stats=1 \
        "build/fuzz/$name" "tests/fuzz/corpus/$name"
done
