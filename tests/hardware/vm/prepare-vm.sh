#!/usr/bin/env bash
# tests/hardware/vm/prepare-vm.sh: fetches and builds what every virtual machine of tests/hardware/vm starts from, once, and prints the folder where it lies.
#
# In it: kernel/ (Debian's kernel image and modules, unpacked, with the drivers that Debian leaves out built beside them), tools/ (what
# the guest runs: busybox, can-utils, gpiod, ip, kmod), headers/ (to build modules: `make -C headers/build M=...`), vmlinux, and release.
# Nothing is installed on this machine. Two that start at once wait for each other. THIMBLE_VM_CACHE moves the folder.
set -Eeuo pipefail
die() { echo "prepare-vm: $*" >&2; exit 1; }
trap 'die "line $LINENO failed"' ERR

[ "$(uname -m)" = x86_64 ] || die "the virtual machine is made on x86-64 only, this is $(uname -m)"
cache=${THIMBLE_VM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/thimble/vm}
place=$cache/$(sha256sum <"${BASH_SOURCE[0]}" | cut -c1-12)  # another version of this script has another folder
mkdir -p "$place"
exec 9>"$cache/lock"
flock --timeout 900 9 || die "another prepare-vm has held $cache/lock for 15 minutes"
if [ -e "$place/ready" ]; then echo "$place"; exit; fi
rm -rf "${place:?}"/*

# unpack FOLDER PACKAGE...: downloads Debian packages and extracts them below the folder.
unpack() {
  local folder=$1 downloads deb
  shift
  downloads=$(mktemp -d "$place/download.XXXX")
  if ! (cd "$downloads" && fetch "$@"); then
    if [ "$(id -u)" -eq 0 ]; then apt-get -o DPkg::Lock::Timeout=400 -qq update >&2 || true; fi  # stale lists name packages that are gone
    (cd "$downloads" && fetch "$@") || die "apt cannot download $*: check the network and Debian's sources, and run apt-get update"
  fi
  mkdir -p "$folder"
  for deb in "$downloads"/*.deb; do dpkg-deb -x "$deb" "$folder"; done
  rm -rf "$downloads"
}
fetch() { apt-get -qq -o APT::Sandbox::User=root -o Acquire::Retries=3 download "$@" >&2; }

newest() { apt-cache depends linux-image-amd64 | sed -n 's/.*Depends: linux-image-//p'; }
release=$(newest || true)
[ -n "$release" ] || die 'apt knows no linux-image-amd64: run apt-get update'
version=$(cut -d. -f1-2 <<<"$release")
modules=$place/kernel/lib/modules/$release

unpack "$place/tools" busybox-static can-utils gpiod iproute2 kmod libbpf1 libgpiod2 libmnl0
ln -s kmod "$place/tools/bin/depmod"
ln -s kmod "$place/tools/bin/modprobe"
unpack "$place/kernel" "linux-image-$release"

# The drivers that Debian's configuration leaves out, from its kernel's source against its headers.
common=$(apt-cache depends "linux-headers-$release" | sed -n 's/.*Depends: \(linux-headers-.*\)/\1/p')
unpack "$place/headers" "linux-headers-$release" "$common" "linux-kbuild-$version" "linux-source-$version"
tree=$place/headers/usr/src
sed -i "s#^include /usr/src/#include $tree/#" "$tree/linux-headers-$release/Makefile"
ln -s "usr/src/linux-headers-$release" "$place/headers/build"
extra=$place/extra
mkdir "$extra" "$place/source"
tar -xJf "$tree/linux-source-$version.tar.xz" -C "$place/source" --strip-components=1 \
  "linux-source-$version"/{drivers/gpio,drivers/counter,drivers/net/can/ctucanfd,kernel/irq}
cp "$place"/source/drivers/gpio/{gpio-sim.c,gpiolib.h} "$place"/source/kernel/irq/irq_sim.c \
  "$place"/source/drivers/counter/{counter-*.[ch],interrupt-cnt.c} "$place"/source/drivers/net/can/ctucanfd/*.[ch] "$extra"
rm -r "$place/source" "$tree/linux-source-$version.tar.xz"
# irq_to_desc() is not exported; generic_handle_irq_safe() does the same by way of the public interface.
sed -i 's/handle_simple_irq(irq_to_desc(irqnum))/generic_handle_irq_safe(irqnum)/' "$extra/irq_sim.c"
printf '\n#include <linux/module.h>\nMODULE_LICENSE("GPL");\n' >>"$extra/irq_sim.c"
cat >"$extra/Kbuild" <<'EOF'
obj-m := irq_sim.o gpio-sim.o counter.o interrupt-cnt.o ctucanfd.o ctucanfd_pci.o
counter-y := counter-core.o counter-sysfs.o counter-chrdev.o
ctucanfd-y := ctucanfd_base.o
EOF
make -s -C "$place/headers/build" M="$extra" modules >"$extra/build.log" 2>&1 || die "the kernel modules do not build: see $extra/build.log"
mkdir "$modules/extra"
for module in "$extra"/*.ko; do strip -g -o "$modules/extra/${module##*/}" "$module"; done
"$place/tools/bin/depmod" -b "$place/kernel" "$release"

# The kernel without its compression starts through PVH; under emulation that saves about 3 s a run.
offset=$(LC_ALL=C grep -aboP '\xfd7zXZ\x00' "$place/kernel/boot/vmlinuz-$release" | LC_ALL=C cut -d: -f1 | sed -n 1p)
xz -dc --single-stream < <(tail -c +$((offset + 1)) "$place/kernel/boot/vmlinuz-$release" || true) >"$place/vmlinux"

echo "$release" >"$place/release"
touch "$place/ready"
echo "$place"
