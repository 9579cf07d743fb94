#!/bin/sh
# build-image.sh BOARD: builds the image of a bare-metal board by its preset, into build/BOARD.
set -eu
if ! command -v arm-none-eabi-g++ > /dev/null; then
  echo "build-image: arm-none-eabi-g++ is missing: apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib" >&2
  exit 1
fi
cd "$(dirname "$0")/../../.."
exec cmake --workflow --preset "$1"
