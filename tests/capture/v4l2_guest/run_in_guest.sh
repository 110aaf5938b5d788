#!/usr/bin/env bash
# Runs a command in a virtual machine that has V4L2 cameras: Debian's kernel with its test driver vivid, under qemu.
#   run_in_guest.sh KERNEL_ROOT OUT COMMAND…
# KERNEL_ROOT holds boot/vmlinuz-* and lib/modules/*, as Debian's linux-image package unpacks. The guest sees this
# machine's files read-only, OUT writable under the same name, and a /tmp of its own. Ends with the command's exit status.
# With GUEST_COMMAND_IS_INIT=1 the command is process 1, and it writes OUT/guest.status and turns the machine off itself.
set -euo pipefail
kernel_root=$1 out=$(realpath "$2")
shift 2
modules=$(basename "$(ls -d "$kernel_root"/lib/modules/* | tail -1)")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

mkdir -p "$work/root"/{bin,dev,proc,sys,host,modules}
cp "$(command -v busybox)" "$work/root/bin/busybox"
[ -f "$kernel_root/lib/modules/$modules/modules.dep.bin" ] || depmod -b "$kernel_root" "$modules"
for module in virtio_pci 9pnet_virtio 9p vivid veth; do
  modprobe -d "$kernel_root" -S "$modules" --show-depends "$module"
done | awk '$1 == "insmod" && !seen[$2]++ { print $2 }' > "$work/list"
while read -r file; do
  cp "$file" "$work/root/modules/"
  basename "$file"
done < "$work/list" > "$work/root/modules/order"

{
  [ -z "${GUEST_COMMAND_IS_INIT:-}" ] || printf 'exec '
  printf '%q ' "$@"
} > "$work/command"
cp "$work/command" "$work/root/command"
[ -z "${GUEST_COMMAND_IS_INIT:-}" ] || touch "$work/root/command_is_init"
echo "$out" > "$work/root/out_path"
cat > "$work/root/init" <<'INIT'
#!/bin/busybox sh
/bin/busybox mkdir -p /sbin /usr/bin
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
for module in $(cat /modules/order); do
  case $module in
    # Two cameras, and one with a video output; no multiplanar formats; no radio, touch or metadata devices.
    vivid.ko*) insmod "/modules/$module" n_devs=3 node_types=0x1,0x1,0x101 multiplanar=1,1,1 ;;
    *) insmod "/modules/$module" ;;
  esac || echo "guest: $module does not load"
done
mount -t 9p -o trans=virtio,version=9p2000.L,ro,msize=262144,cache=loose host /host || poweroff -f
mount -t tmpfs tmp /host/tmp
mount --bind /dev /host/dev
mount --bind /proc /host/proc
mount --bind /sys /host/sys
mkdir -p "/host$(cat /out_path)"
mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144 out "/host$(cat /out_path)"
cp /command /host/tmp/command
ip link set lo up 2>/dev/null
[ ! -f /command_is_init ] || exec chroot /host /bin/bash /tmp/command > /dev/console 2>&1
chroot /host /bin/bash /tmp/command > /dev/console 2>&1
echo $? > "/host$(cat /out_path)/guest.status"
sync
poweroff -f
INIT
chmod +x "$work/root/init"
(cd "$work/root" && find . | cpio -o -H newc 2>/dev/null | gzip -1) > "$work/initramfs"

rm -f "$out/guest.status"
qemu-system-x86_64 -m 512 -smp 1 -nographic -no-reboot -nic none \
  -kernel "$(ls "$kernel_root"/boot/vmlinuz-* | tail -1)" -initrd "$work/initramfs" \
  -append "console=ttyS0 quiet panic=-1" \
  -virtfs local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap \
  -virtfs "local,path=$out,mount_tag=out,security_model=none,multidevs=remap" < /dev/null
[ -f "$out/guest.status" ] || { echo "the guest did not come to its end" >&2; exit 70; }
exit "$(cat "$out/guest.status")"
