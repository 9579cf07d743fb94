#!/usr/bin/env bash
# tests/hardware/vm/gpio_v2.sh FOLDER: gpio_v2.cpp with libgpiod 2 as Debian 12's backports have it, built in FOLDER and run in the virtual machine.
# The packages are unpacked there and linked statically; nothing is installed, and the system's apt sources stay as they are.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
top=$here/../../..
folder=$1
mkdir -p "$folder"/{parts,lists/partial,archives/partial,packages}
folder=$(readlink -f "$folder")
# Backports are where the system has its Debian 12 from.
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Release: bookworm' 'Component: main' | sed -n 1p)
[ -n "$mirror" ] || { echo 'the apt sources of this system have no Debian 12 (bookworm main)' >&2; exit 1; }
cat >"$folder/parts/backports.sources" <<EOF
Types: deb
URIs: $mirror
Suites: bookworm-backports
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
EOF
cat >"$folder/apt.conf" <<EOF
Dir::Etc::SourceList "/dev/null";
Dir::Etc::SourceParts "$folder/parts";
Dir::State::Lists "$folder/lists";
Dir::Cache "$folder";
APT::Sandbox::User "root";
Acquire::Retries "3";
EOF
if [ ! -e "$folder/packages/usr/include/gpiod.h" ]; then
  export APT_CONFIG=$folder/apt.conf
  apt-get -qq update
  (cd "$folder" && apt-get -qq download libgpiod-dev) || { echo 'apt cannot download libgpiod-dev from bookworm-backports: check the network' >&2; exit 1; }
  unset APT_CONFIG
  dpkg-deb -x "$folder"/libgpiod-dev_2*.deb "$folder/packages"
fi
library=$(dirname "$(find "$folder/packages" -name libgpiod.a)")
c++ -std=c++20 -O1 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -I "$top" -isystem "$folder/packages/usr/include" \
  "$top/board/linux/gpio_v2.cpp" "$here/gpio_test.cpp" "$library/libgpiod.a" -o "$folder/gpio_test"
"$here/run-vm.sh" "$here/guest/board_gpio.sh" "$here/guest/lib.sh" "$folder/gpio_test"
