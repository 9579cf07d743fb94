#!/usr/bin/env bash
# tests/hardware/vm/run-vm.sh [OPTION]... SCRIPT [FILE]...
#
# Runs SCRIPT as root in a throw-away Debian machine: QEMU without KVM, Debian's own kernel, a file system in memory made on the spot. So a
# test has SocketCAN, GPIO lines, a USB gadget and real CAN controllers' drivers wherever it runs. Each FILE (program, script, data) lies in
# /usr/local/bin there, with its shared libraries. prepare-vm.sh, which this calls, fetches what is needed the first time.
#
#   -e NAME=VALUE     an environment variable for SCRIPT
#   -k FOLDER         kernel modules of your own: FOLDER has a Kbuild; they are built against the guest's kernel and lie where modprobe
#                     finds them
#   -l "MODULE ..."   kernel modules to load before SCRIPT
#   -o FOLDER         is /out in the guest
#   -q "ARGUMENT ..." for QEMU, such as its CAN controllers
#   -m MB             memory (256)
#   -r                a restart of the machine is no end: SCRIPT begins again
#   -t SECONDS        limit (120)
#
# Exit status: SCRIPT's (above 45 reads 45), 124 when the limit was reached, 125 when the machine itself failed.
set -Eeuo pipefail
die() { echo "run-vm: $*" >&2; exit 125; }
trap 'die "line $LINENO failed"' ERR

here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
memory_MB=256 limit_s=120 out='' own_modules='' load='can can-raw can-isotp can-dev vcan configfs' variables=() qemu_arguments=() reboot=-no-reboot
while getopts e:k:l:m:o:q:rt: option; do
  case $option in
    e) variables+=("$OPTARG") ;;
    k) own_modules=$(readlink -f "$OPTARG") ;;
    l) load+=" $OPTARG" ;;
    m) memory_MB=$OPTARG ;;
    o) mkdir -p "$OPTARG"; out=$(readlink -f "$OPTARG") ;;
    q) read -ra more <<<"$OPTARG"; qemu_arguments+=("${more[@]}") ;;
    r) reboot= ;;
    t) limit_s=$OPTARG ;;
    *) exit 125 ;;
  esac
done
shift $((OPTIND - 1))
[ $# -ge 1 ] || die 'no script given'
command -v qemu-system-x86_64 >/dev/null || die 'qemu-system-x86_64 is missing: install qemu-system-x86'
script=$1
shift

# What the guest's modprobe finds, with all that these depend on.
available="$load can-gw slcan kvaser_pci ctucanfd_pci irq_sim gpio-sim counter interrupt-cnt dummy_hcd cdc-acm u_serial usb_f_acm
  libcomposite g_serial sch_tbf spidev softdog i6300esb virtio_pci 9pnet_virtio 9p"

base=$("$here/prepare-vm.sh") || exit 125
release=$(cat "$base/release")
tools=$base/tools
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
modules=lib/modules/$release
mkdir -p "$root"/{bin,dev,etc,lib64,out,proc,run,sbin,sys,tmp,usr/local/bin,usr/lib/vm,"$modules"}

for module in $available; do
  "$tools/bin/modprobe" -d "$base/kernel" -S "$release" --show-depends "$module" || die "the kernel has no module $module"
done | awk '$1 == "insmod" {print $2}' | sort -u | xargs cp -t "$root/$modules"
if [ -n "$own_modules" ]; then
  own=$base/own/$(cat "$own_modules"/* | sha256sum | cut -c1-12)  # built once
  exec 9>"$base/own.lock"
  flock --timeout 300 9 || die "another run-vm has built $own_modules for 5 minutes"
  if [ ! -e "$own" ]; then
    rm -rf "$own.new"
    mkdir -p "$base/own"
    cp -r "$own_modules" "$own.new"
    make -s -C "$base/headers/build" M="$own.new" KBUILD_EXTRA_SYMBOLS="$base/extra/Module.symvers" modules >&2 || die "the modules of $own_modules do not build"
    mv "$own.new" "$own"
  fi
  exec 9>&-
  cp "$own"/*.ko "$root/$modules"
fi
cp "$base/kernel/$modules"/modules.{order,builtin,builtin.modinfo} "$root/$modules"
"$tools/bin/depmod" -b "$root" "$release"

cp "$tools/bin/busybox" "$root/bin"
ln -s /bin/busybox "$root/sbin/modprobe"
cp -L /bin/dash "$root/bin/sh"  # busybox's shell would prefer its own ip to the real one
programs=("$tools"/usr/bin/{can,isotp,gpio,slcan}* "$tools/bin/ip" "$tools/sbin/tc" "$@")
cp -L "${programs[@]}" "$root/usr/local/bin"
cp "$script" "$root/script"
chmod +x "$root/script"
{ LD_LIBRARY_PATH=$tools/usr/lib/x86_64-linux-gnu ldd /bin/dash "${programs[@]}" 2>/dev/null || true; } >"$work/ldd"
! grep 'not found' "$work/ldd" >&2 || die 'a shared library is missing'
grep -oE '/[^ ]+\.so[^ ]*' "$work/ldd" | sort -u | xargs cp -L -t "$root/usr/lib/vm"
cp -L /lib64/ld-linux-x86-64.so.2 "$root/lib64"

exports='' mount_out='' share=()
for variable in "${variables[@]}"; do exports+="export ${variable%%=*}='${variable#*=}'"$'\n'; done
if [ -n "$out" ]; then
  mount_out='modprobe -a virtio_pci 9pnet_virtio 9p && mount -t 9p -o trans=virtio,version=9p2000.L,msize=131072 out /out'
  share=(-virtfs "local,path=$out,mount_tag=out,security_model=none")
fi
cat >"$root/init" <<EOF
#!/bin/busybox sh
export PATH=/usr/local/bin:/bin:/sbin LD_LIBRARY_PATH=/usr/lib/vm HOME=/ TERM=linux
/bin/busybox --install -s /bin
mount -t proc none /proc; mount -t sysfs none /sys; mount -t devtmpfs none /dev; mount -t tmpfs none /tmp; mount -t tmpfs none /run
mount -t debugfs none /sys/kernel/debug
for m in $load; do modprobe \$m || echo "run-vm: modprobe \$m failed"; done
mount -t configfs none /sys/kernel/config
$mount_out
$exports
echo "run-vm: up \$(cut -d' ' -f1 /proc/uptime) s, \$(uname -r)"
/script; code=\$?; [ \$code -le 45 ] || code=45
cd /; sync; umount /out 2>/dev/null
echo "run-vm: exit \$code at \$(cut -d' ' -f1 /proc/uptime) s"
printf "\\\\\$(printf %03o \$((code + 16)))" | dd of=/dev/port bs=1 seek=244 count=1 2>/dev/null
EOF
chmod +x "$root/init"
# Not compressed: the guest would take 1 s of emulation to unpack it.
(cd "$root" && find . | cpio -o -H newc --quiet) >"$work/initramfs"

code=0
timeout "$limit_s" qemu-system-x86_64 -accel tcg -cpu max -m "$memory_MB" -nodefaults -no-user-config -display none $reboot \
  -serial stdio -device isa-debug-exit,iobase=0xf4,iosize=1 "${share[@]}" "${qemu_arguments[@]}" \
  -kernel "$base/vmlinux" -initrd "$work/initramfs" -append 'console=ttyS0 quiet panic=-1 no_timer_check' </dev/null || code=$?
# isa-debug-exit makes 2n + 1 of the byte n; the 16 added above keep clear of QEMU's own 0 and 1.
if [ "$code" -eq 124 ]; then echo "run-vm: not done after $limit_s s" >&2; exit 124; fi
if [ "$code" -ge 33 ] && [ "$code" -le 123 ]; then exit $(((code - 1) / 2 - 16)); fi
die "QEMU ended with $code and no result from the guest"
