#!/usr/bin/env bash
# tests/arm64/run.sh [TARGET..]: builds haptics, devices, the bridge, the kit and the C interface for arm64 with Debian's cross compiler,
# warnings as errors, in a clean Debian 12 of its own, and runs the tests of haptics, devices and the C interface there under qemu (of
# TARGETS alone where they are named: a program of tests runs, all else is only built). Says nothing of speed. Needs root; this machine stays as it is.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
. tests/packages/root.sh
[ "$(id -u)" = 0 ] || { echo "tests/arm64/run.sh makes a root of its own, which only root can" >&2; exit 1; }
midair_install git "${midair_root_packages[@]}"
[ $# -gt 0 ] || set -- midair_haptics_tests midair_device_tests midair_engine_bridge_c_tests osgMidair osgdb_serializers_osgmidair osgdb_haptic osgdb_gltf osgdb_glb midair
kept=$PWD/build-packages/root root=$PWD/build-arm64/root
mkdir -p "$kept"
root_clean "$kept/clean.tar"

if [ "$(cat "$root/ready" 2>/dev/null)" != "${midair_arm64_packages[*]}" ]; then
    rm -rf "$root"
    mkdir -p "$root"
    tar -C "$root" -xf "$kept/clean.tar"
    # shellcheck disable=SC2016 # expanded inside
    root_run "$root" "$kept/archives" bash -euc '
        dpkg --add-architecture arm64
        apt-get update -qq
        apt-get install -y -qq --no-install-recommends "$@" >/dev/null
        echo "$*" >/ready' install "${midair_arm64_packages[@]}"
fi
# The sources as they are here, changes that are not committed included.
rm -rf "$root/src"
mkdir "$root/src"
git ls-files -z --cached --others --exclude-standard | tar -c --null --files-from - | tar -x -C "$root/src"

# shellcheck disable=SC2016
root_run "$root" "$kept/archives" bash -euc '
    export CCACHE_DIR=/ccache
    cmake -S /src -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_TOOLCHAIN_FILE=/src/tests/arm64/toolchain.cmake -DMIDAIR_TESTS=ON \
        -DMIDAIR_WERROR=ON >/build.log || { cat /build.log >&2; exit 1; }
    ninja -C /build --quiet "$@"
    emulator=$(command -v qemu-aarch64-static)
    export MIDAIR_TEST_EMULATOR=$emulator
    for target in "$@"; do
        case $target in
        *_tests)
            echo "== $target"
            shards=$(nproc) running=() status=0
            for ((i = 0; i < shards; ++i)); do
                GTEST_TOTAL_SHARDS=$shards GTEST_SHARD_INDEX=$i "$emulator" "/build/bin/$target" --gtest_brief=1 &
                running+=($!)
            done
            for one in "${running[@]}"; do wait "$one" || status=1; done
            [ $status = 0 ] || exit $status
            ;;
        esac
    done' build "$@"
echo "arm64: built, and tested under qemu: $*"
