#!/usr/bin/env bash
# tests/vm/run.sh: the USB path on the kernel's own USB stack, in a virtual machine (Debian's kernel, vhci-hcd, a USB/IP server in
# user space). Needs no KVM. Fetches Debian's kernel package into build/vm once; about a quarter of a minute a run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
. tests/vm/guest.sh
midair_install qemu-system-x86 busybox-static cpio
midair_build build midair_vm_test # as it is configured, by default with tests
work=build/vm root=build/vm/root
guest_kernel
guest_root $root build/bin/midair_vm_test
mkdir $root/modules
for module in usb-common usbcore usbip-core vhci-hcd; do
    cp "$(find build/vm/kernel/lib/modules -name "$module.ko")" $root/modules/
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
guest_pack $root | gzip -1 > $work/initrd.gz
timeout "${MIDAIR_VM_SECONDS:-300}" qemu-system-x86_64 -accel tcg -m 512 -nographic -no-reboot -nic none \
    -kernel "$kernel" -initrd $work/initrd.gz \
    -append "console=ttyS0 quiet panic=-1" < /dev/null | tr -d '\r' | tee $work/log.txt | grep --line-buffered '^VM' || true
grep -q '^VM TEST PASSED' $work/log.txt || { echo "tests/vm: failed; the machine's console is in $work/log.txt" >&2; exit 1; }
