# 64-bit ARM Linux (Raspberry Pi, Kria). Debian: g++-aarch64-linux-gnu; qemu-user runs the programs.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(THIMBLE_DEBIAN_ARCHITECTURE arm64)
set(THIMBLE_QEMU qemu-aarch64)
include(${CMAKE_CURRENT_LIST_DIR}/arm-linux.cmake)
