# Sourced by samples/run.sh and tests/run.sh: what the project needs from Debian 12, and how it is installed and built.

midair_packages=(
    g++ cmake ninja-build ccache pkg-config
    libopenscenegraph-dev openscenegraph  # scene graph, osgviewer, osgconv
    libeigen3-dev                         # linear algebra
    libbullet-dev                         # hands, rigid bodies
    libtinyobjloader-dev                  # OBJ files
    libopenxr-dev                         # hands of OpenXR runtimes; its headers
    liboscpack-dev                        # hands by OSC
    libapriltag-dev                       # tags that cameras see
    libtinygltf-dev                       # glTF models
    libusb-1.0-0-dev libftdi1-dev         # arrays over USB and FTDI chips
    zlib1g-dev libexpat1-dev              # arrays from Ultraino's simulator
    libcpp-httplib-dev                    # the operator's page
    libwebsocketpp-dev libasio-dev        # the AdapTics Designer as a client
    nlohmann-json3-dev libcli11-dev libfmt-dev libspdlog-dev
    libegl-dev libgl1-mesa-dri            # off-screen pictures
    fonts-dejavu-core                     # their text
    python3-matplotlib                    # plots
)
midair_test_packages=(
    libgtest-dev
    umockdev libumockdev-dev              # emulated USB devices
    libopenxr-loader1                     # loads the tests' own OpenXR runtime
    xvfb xauth                            # osgviewer in the tests
    locales                               # a locale with a decimal comma
    psmisc procps                         # killall and pkill, which a guard has to survive
    clang-format-14
    clang                                 # the second compiler; libFuzzer
    clang-tidy-14
    valgrind                              # memory that was not set
    abigail-tools                         # the ABI of libmidair
    pybind11-dev python3-dev python3-numpy # import midair
    help2man dpkg-dev                     # Debian packages
)
# For tests/run.sh --docs and `ninja doc` alone.
midair_docs_packages=(
    doxygen                               # the reference of all headers
)
# For samples/debian/build.sh alone.
midair_packaging_packages=(
    pybind11-dev python3-dev              # import midair
    help2man dpkg-dev                     # man pages; what binaries depend on
    lintian                               # Debian's policy
)
# For tests/run.sh --packages: roots of a Debian of their own.
midair_root_packages=(mmdebstrap)
# For tests/run.sh --arm64, in such a root.
midair_arm64_packages=(
    g++-aarch64-linux-gnu qemu-user-static # the cross compiler; runs what it made
    cmake ninja-build ccache pkg-config
    locales procps psmisc                 # what tests need that would be skipped
    python3-matplotlib                    # plots; it runs as it is
    libeigen3-dev nlohmann-json3-dev libcli11-dev libasio-dev
    {libopenscenegraph,libbullet,libtinyobjloader,libopenxr,liboscpack,libapriltag,libtinygltf,libcpp-httplib,libwebsocketpp,libusb-1.0-0,libftdi1,libexpat1,libfmt,libspdlog,libegl,libgtest}-dev:arm64
    zlib1g-dev:arm64
)
# For tests/run.sh --cluster alone.
midair_cluster_packages=(
    slurm-wlm munge                       # a real job queue
    parallel                              # GNU parallel
)
# For tests/run.sh --browser alone.
midair_browser_packages=(
    chromium chromium-driver python3-selenium # the operator's page
)

# Installs those of its arguments that are missing; says so first. Without root or sudo: prints the line to type and stops.
midair_install()
{
    local missing=() package
    for package in "$@"; do
        [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
    done
    [ ${#missing[@]} -gt 0 ] || return 0
    local asRoot=""
    if [ "$(id -u)" -ne 0 ]; then
        if command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
            asRoot="sudo"
        else
            echo "osgMidair needs packages that only root can install. Type this, then run again:" >&2
            echo "    apt-get update && apt-get install -y --no-install-recommends ${missing[*]}" >&2
            exit 1
        fi
    fi
    echo "osgMidair installs from Debian: ${missing[*]}"
    $asRoot env DEBIAN_FRONTEND=noninteractive apt-get update -qq
    $asRoot env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# midair_build FOLDER "TARGET.." [cmake option]..: configures (the first time, or when options are given that differ from
# the last ones) and builds Release.
midair_build()
{
    local folder=$1 target=$2
    shift 2
    mkdir -p "$folder"
    if [ ! -f "$folder/build.ninja" ] || { [ $# -gt 0 ] && [ "$(cat "$folder/options" 2>/dev/null)" != "$*" ]; }; then
        cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" >"$folder/configure.log" 2>&1 ||
            { cat "$folder/configure.log" >&2; exit 1; }
        echo "$*" >"$folder/options"
    fi
    # Paths below the checkout are relative for the compiler's cache, so that it serves other checkouts of the same sources, too.
    # shellcheck disable=SC2086 # several targets
    # Precompiled headers of tests are part of what it compares.
    CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros ninja -C "$folder" --quiet $target
}
