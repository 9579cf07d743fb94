# Cortex-R5F (the real-time cores of Zynq UltraScale+). Same packages as for the Cortex-M7. In ARM code the image is 65 kB larger than the
# tightly coupled memory.
set(THIMBLE_CPU "-mcpu=cortex-r5 -mfpu=vfpv3-d16 -mfloat-abi=hard -mthumb")
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
