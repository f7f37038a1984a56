# shellcheck shell=bash
# Sourced: roots of a clean Debian 12, in which commands run without touching this machine. Needs root.

# root_clean FILE: makes FILE, a tar of a minimal Debian 12, from where this machine gets its own packages; once.
root_clean()
{
    local file=$1 sources=bookworm each
    [ ! -s "$file" ] || return 0
    for each in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do [ ! -s $each ] || sources=$each; done
    mmdebstrap --quiet --format=tar --variant=minbase bookworm "$file.part" "$sources"
    mv "$file.part" "$file"
}

# root_run FOLDER ARCHIVES COMMAND..: runs a command as root in the root FOLDER, in namespaces of its own, which take its mounts and
# whatever it leaves running with them. ARCHIVES keeps downloaded packages for the next time.
root_run()
{
    local folder=$1 archives=$2
    shift 2
    mkdir -p "$archives/partial" "$folder/var/cache/apt/archives"
    cp -L /etc/resolv.conf "$folder/etc/resolv.conf"
    # shellcheck disable=SC2016 # expanded inside
    unshare --mount --pid --ipc --fork bash -euc '
        folder=$1 archives=$2
        shift 2
        mount --bind "$archives" "$folder/var/cache/apt/archives"
        mount -t proc proc "$folder/proc"
        mount -t sysfs -o ro sysfs "$folder/sys"
        mount -t tmpfs tmpfs "$folder/dev"
        mkdir "$folder/dev/shm" "$folder/dev/pts"
        chmod 1777 "$folder/dev/shm"
        mount -t devpts -o newinstance,ptmxmode=0666 devpts "$folder/dev/pts" # serial boards are rehearsed on pseudo terminals
        ln -s pts/ptmx "$folder/dev/ptmx"
        for device in null zero full random urandom tty; do
            touch "$folder/dev/$device"
            mount --bind /dev/$device "$folder/dev/$device"
        done
        ln -s /proc/self/fd "$folder/dev/fd"
        mount -t tmpfs tmpfs "$folder/run"
        exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
            MIDAIR_TIME_FACTOR="${MIDAIR_TIME_FACTOR:-1}" \
            chroot "$folder" "$@"' root_run "$folder" "$archives" "$@"
}
