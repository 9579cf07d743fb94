#!/usr/bin/env bash
# tests/hardware/cortex/zynqmp/prepare-linux.sh: fetches Debian's arm64 kernel and builds the driver of the Zynq's CAN controller for it, which Debian
# leaves out, once; prints the folder where it lies.
#
# In it: Image (the kernel), modules/ (what the guest loads, in the order of modules/order), busybox. Nothing is installed on this machine,
# and its package lists stay as they are. Two that start at once wait for each other. THIMBLE_VM_CACHE moves the folder.
set -Eeuo pipefail
die() { echo "prepare-linux: $*" >&2; exit 1; }
trap 'die "line $LINENO failed"' ERR

cache=${THIMBLE_VM_CACHE:-${XDG_CACHE_HOME:-$HOME/.cache}/thimble/vm}
place=$cache/zynqmp-$(sha256sum <"${BASH_SOURCE[0]}" | cut -c1-12)  # another version of this script has another folder
mkdir -p "$place"
exec 9>"$cache/lock-zynqmp"
flock --timeout 900 9 || die "another prepare-linux has held $cache/lock-zynqmp for 15 minutes"
if [ -e "$place/ready" ]; then echo "$place"; exit; fi
rm -rf "${place:?}"/*

# Package lists of arm64 beside the machine's own.
lists=$place/lists
mkdir -p "$lists/lists/partial" "$lists/cache/archives/partial" "$place/download"
touch "$lists/status"
apt=(-qq -o APT::Sandbox::User=root -o Acquire::Retries=3 -o Dir::State="$lists" -o Dir::State::status="$lists/status" -o Dir::Cache="$lists/cache"
  -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o APT::Architectures::=amd64)
apt-get "${apt[@]}" update >&2 || die 'apt cannot read the package lists of arm64: check the network and the sources of Debian'
release=$(apt-cache "${apt[@]}" depends linux-image-arm64:arm64 | sed -n 's/.*Depends: linux-image-\([^:]*\).*/\1/p' | head -1)
[ -n "$release" ] || die 'apt knows no linux-image-arm64'
version=$(cut -d. -f1-2 <<<"$release")
common=${release%-arm64}-common
(cd "$place/download" && apt-get "${apt[@]}" download "linux-image-$release:arm64" busybox-static:arm64 "linux-headers-$release:arm64" \
  "linux-headers-$common" "linux-kbuild-$version:amd64" "linux-source-$version" >&2) || die 'apt cannot download the kernel'
for package in "$place"/download/*.deb; do dpkg-deb -x "$package" "$place/tree"; done
rm -r "$place/download" "$lists"

tree=$place/tree
cp "$tree/bin/busybox" "$place/busybox"
gzip -dc "$tree/boot/vmlinuz-$release" >"$place/Image" 2>/dev/null || cp "$tree/boot/vmlinuz-$release" "$place/Image"

mkdir "$place/driver"
tar -xJf "$tree/usr/src/linux-source-$version.tar.xz" -C "$place/driver" --strip-components=4 \
  "linux-source-$version/drivers/net/can/xilinx_can.c"
echo 'obj-m := xilinx_can.o' >"$place/driver/Kbuild"
headers=$tree/usr/src/linux-headers-$release
sed -i "s#^include /usr/src/#include $tree/usr/src/#" "$headers/Makefile"
# The headers' links lead to /usr/lib.
find "$tree/usr/src" -type l -lname '*linux-kbuild*' | while read -r link; do
  ln -sfn "$tree/usr/lib/linux-kbuild-$version/$(basename "$(readlink "$link")")" "$link"
done
make -s -C "$headers" ARCH=arm64 CROSS_COMPILE=aarch64-linux-gnu- M="$place/driver" modules >"$place/driver/build.log" 2>&1 ||
  die "xilinx_can does not build: see $place/driver/build.log"

mkdir "$place/modules"
for module in can/can can/can-raw drivers/net/can/dev/can-dev; do
  file=$(find "$tree/lib/modules/$release" -path "*$module.ko")
  cp "$file" "$place/modules"
done
cp "$place/driver/xilinx_can.ko" "$place/modules"
aarch64-linux-gnu-strip -g "$place"/modules/*.ko
rm -r "$tree" "$place/driver"
touch "$place/ready"
echo "$place"
