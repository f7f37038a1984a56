#!/usr/bin/env bash
# samples/debian/build.sh [FOLDER]: makes the Debian packages of this tree, for the Debian that it runs on, into FOLDER
# (build-packages/packages), and lets lintian judge them: whatever it finds is an error. What is missing to build is installed.
set -euo pipefail
caller=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
tree=$PWD
. samples/packages.sh
folder=$(cd "$caller" && realpath -m "${1:-$tree/build-packages/packages}")
midair_install "${midair_packages[@]}" "${midair_packaging_packages[@]}"
midair_build build-packages "midair_samples midair midair_python" \
    -DCMAKE_INSTALL_PREFIX=/usr -DMIDAIR_PACKAGED=ON -DMIDAIR_TESTS=OFF -DMIDAIR_WERROR="${MIDAIR_WERROR:-OFF}"
rm -f "$folder"/*midair*.deb
cpack --config build-packages/CPackConfig.cmake -B "$folder" >build-packages/cpack.log 2>&1 ||
    { cat build-packages/cpack.log >&2; exit 1; }
rm -rf "$folder/_CPack_Packages"
# A first upload to Debian itself would close a wish for it; this is none.
lintian --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs "$folder"/*.deb
ls -l "$folder"/*.deb
echo "packages of $(dpkg-deb -f "$folder"/osgmidair-data_*.deb Version), which lintian accepts: $folder"
