# Sourced by the scripts beside it: what a virtual machine's guest is made of.

# Fetches Debian's kernel package into build/vm/kernel once; its path is then in kernel.
guest_kernel()
{
    local folder=build/vm/kernel package
    mkdir -p $folder
    if ! ls $folder/boot/vmlinuz-* > /dev/null 2>&1; then
        package=$(apt-cache depends linux-image-amd64 | awk '/Depends: linux-image/ {print $2; exit}')
        echo "fetching Debian's kernel, $package"
        (cd build/vm && apt-get download -q -o APT::Sandbox::User=root "$package" && dpkg-deb -x "$package"_*.deb kernel && rm "$package"_*.deb)
    fi
    kernel=$(ls $folder/boot/vmlinuz-*)
}

# guest_root ROOT PROGRAM..: a new root folder with busybox, the programs, and the libraries that they need.
guest_root()
{
    local root=$1 program library
    shift
    rm -rf "$root"
    mkdir -p "$root"/{bin,dev,proc,sys,run,tmp}
    cp "$(command -v busybox)" "$root/bin/busybox"
    for program in "$@"; do
        strip -o "$root/bin/$(basename "$program")" "$program"
        for library in $(ldd "$program" | grep -o '/[^ ]*'); do
            mkdir -p "$root$(dirname "$library")"
            cp -L "$library" "$root$library"
        done
    done
}

# guest_pack ROOT: the root folder as an initial ramdisk, to the standard output.
guest_pack()
{
    (cd "$1" && find . | cpio -o -H newc --quiet)
}
