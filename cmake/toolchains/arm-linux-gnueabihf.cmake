# 32-bit ARM Linux (BeagleBone). Debian: g++-arm-linux-gnueabihf; qemu-user runs the programs.
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_LIBRARY_ARCHITECTURE arm-linux-gnueabihf)
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)  # notes on what GCC 7 changed; all is compiled by one GCC
set(THIMBLE_DEBIAN_ARCHITECTURE armhf)
set(THIMBLE_QEMU qemu-arm)
include(${CMAKE_CURRENT_LIST_DIR}/arm-linux.cmake)
