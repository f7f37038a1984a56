#!/usr/bin/env bash
# tests/vm/run.sh: the USB path on the kernel's own USB stack, in a virtual machine (Debian's kernel, vhci-hcd, a USB/IP server in
# user space). Needs no KVM. Fetches Debian's kernel package into build/vm once; about a quarter of a minute a run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
midair_install qemu-system-x86 busybox-static cpio
midair_build build midair_vm_test # as it is configured, by default with tests
work=build/vm
mkdir -p $work/kernel
if ! ls $work/kernel/boot/vmlinuz-* > /dev/null 2>&1; then
    package=$(apt-cache depends linux-image-amd64 | awk '/Depends: linux-image/ {print $2; exit}')
    echo "fetching Debian's kernel, $package"
    (cd $work && apt-get download -q -o APT::Sandbox::User=root "$package" && dpkg-deb -x "$package"_*.deb kernel && rm "$package"_*.deb)
fi
root=$work/root
rm -rf $root
mkdir -p $root/{bin,dev,proc,sys,run,modules}
cp "$(command -v busybox)" $root/bin/busybox
for module in usb-common usbcore usbip-core vhci-hcd; do
    cp "$(find $work/kernel/lib/modules -name "$module.ko")" $root/modules/
done
cp build/bin/midair_vm_test $root/bin/
for library in $(ldd build/bin/midair_vm_test | grep -o '/[^ ]*'); do
    mkdir -p "$root$(dirname "$library")"
    cp -L "$library" "$root$library"
done
cat > $root/init << 'INIT'
#!/bin/busybox sh
/bin/busybox mount -t proc proc /proc
/bin/busybox mount -t sysfs sys /sys
/bin/busybox mount -t devtmpfs dev /dev
for module in usb-common usbcore usbip-core vhci-hcd; do /bin/busybox insmod /modules/$module.ko; done
/bin/midair_vm_test
/bin/busybox poweroff -f
INIT
chmod +x $root/init
(cd $root && find . | cpio -o -H newc --quiet | gzip -1) > $work/initrd.gz
timeout "${MIDAIR_VM_SECONDS:-300}" qemu-system-x86_64 -accel tcg -m 512 -nographic -no-reboot -nic none \
    -kernel "$(ls $work/kernel/boot/vmlinuz-*)" -initrd $work/initrd.gz \
    -append "console=ttyS0 quiet panic=-1" < /dev/null | tr -d '\r' | tee $work/log.txt | grep --line-buffered '^VM' || true
grep -q '^VM TEST PASSED' $work/log.txt || { echo "tests/vm: failed; the machine's console is in $work/log.txt" >&2; exit 1; }
