#!/usr/bin/env bash
# tests/vm/avx512.sh [AVX2] [AVX-512]: the tests of the kernels on a processor with these instructions, without arguments on both,
# emulated by Bochs, and how many instructions an update takes there. Five to six minutes each.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
. samples/packages.sh
. tests/vm/guest.sh
declare -A processors=([AVX2]=corei7_haswell_4770 [AVX-512]=corei7_skylake_x)
[ $# -gt 0 ] || set -- AVX2 AVX-512
for isa in "$@"; do
    [ -n "${processors[$isa]:-}" ] || { echo "tests/vm/avx512.sh: unknown '$isa'; known are AVX2, AVX-512" >&2; exit 2; }
done
midair_install bochs bochsbios vgabios bochs-term busybox-static cpio binutils isolinux syslinux-common xorriso
midair_build build midair_haptics_tests # as it is configured, by default with tests
midair_build build midair-bench
work=build/vm/avx512 root=build/vm/avx512/root
guest_kernel
guest_root $root build/bin/midair_haptics_tests build/bin/midair-bench
cp -r haptics/array/arrays $root/arrays
cat > $root/init << 'INIT'
#!/bin/busybox sh
/bin/busybox mount -t proc proc /proc
/bin/busybox mount -t sysfs sys /sys
/bin/busybox mount -t devtmpfs dev /dev
exec > /dev/ttyS0 2>&1
export OSG_MIDAIR_ARRAYS=/arrays
echo "clock $(/bin/busybox cat /sys/devices/system/clocksource/clocksource0/current_clocksource)"
for n in 25 50 100 200 400; do
    radius=0.03
    [ $n -le 100 ] || radius=0.06
    /bin/midair-bench --case sphere --n $n --radius $radius --mode update --repeats 5 --no-surface --csv /tmp/csv
    echo "cell $(/bin/busybox tail -n 1 /tmp/csv)"
done
/bin/midair_haptics_tests --gtest_color=no --gtest_filter="PropagationMatrix.*:With/*:PressureField.*:PhaseObjective.*:GaussNewton.*:EverySolver.P*Levels*:EverySolver.S*" &&
    echo "VM TEST PASSED on $(/bin/busybox sed -n 's/^model name.*: //p' /proc/cpuinfo)"
/bin/busybox sleep 1 # the console's last lines
/bin/busybox poweroff -f
INIT
chmod +x $root/init
iso=$work/iso
rm -rf $iso
mkdir -p $iso/isolinux
guest_pack $root > $iso/initrd
cp "$kernel" $iso/vmlinuz
cp /usr/lib/ISOLINUX/isolinux.bin /usr/lib/syslinux/modules/bios/ldlinux.c32 $iso/isolinux/
# The time stamp counter of Bochs counts instructions. The kernel is told that 1e9 of its ticks are a second, so that a
# millisecond of the guest is a million instructions. Seeing the size of XSAVEC's area that Bochs tells, it would use no AVX.
cat > $iso/isolinux/isolinux.cfg << 'BOOT'
default linux
label linux
kernel /vmlinuz
initrd /initrd
append console=ttyS0 quiet panic=-1 mitigations=off clearcpuid=xsavec,xsaves tsc=reliable tsc_early_khz=1000000
BOOT
xorriso -as mkisofs -quiet -o $work/boot.iso -b isolinux/isolinux.bin -c isolinux/boot.cat \
    -no-emul-boot -boot-load-size 4 -boot-info-table $iso > $work/xorriso.txt 2>&1
printf 'c\nq\n' > $work/start # Debian's Bochs waits in its debugger
failed=0
for isa in "$@"; do
    log=$work/$isa.txt
    rm -f "$log"
    cat > $work/bochsrc << BOCHS
cpu: model=${processors[$isa]}, ips=100000000
clock: sync=none
megs: 512
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=$work/boot.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=$log
plugin_ctrl: speaker=0
display_library: term
log: $work/$isa.bochs.txt
BOCHS
    rm -f $work/screen.txt
    TERM=xterm timeout "${MIDAIR_VM_SECONDS:-1200}" bochs -q -f $work/bochsrc -rc $work/start < /dev/null > $work/screen.txt 2>&1 &
    machine=$!
    # The emulator draws the machine's screen on a terminal of its own, and stands still once that is full and nobody reads.
    while kill -0 $machine 2> /dev/null && ! grep -q 'connected to screen' $work/screen.txt 2> /dev/null; do sleep 0.2; done
    screen=$(sed -n 's/^Bochs connected to screen "\(.*\)"$/\1/p' $work/screen.txt)
    [ -z "$screen" ] || cat "$screen" > /dev/null 2>&1 &
    wait $machine || true
    touch "$log"
    sed -i 's/\r//' "$log"
    for line in 'clock tsc' "$isa, 1 cells" 'VM TEST PASSED'; do
        grep -m 1 -F "$line" "$log" && continue
        echo "tests/vm: no '$line' from ${processors[$isa]}; the machine's console is in $log" >&2
        failed=1
    done
done
echo "isa, points, million instructions of an update, of its matrix; as many times fewer than with $1"
for isa in "$@"; do sed -n 's/^cell //p' "$work/$isa.txt"; done | awk -F, '
    { if (!($2 in cpu)) { cpu[$2] = $14; matrix[$2] = $15 }
      printf "%-8s %4d %8.2f %8.2f %8.2f %8.2f\n", $7, $2, $14, $15, cpu[$2] / $14, matrix[$2] / $15 }'
exit $failed
