# Common part of the toolchain files for ARM Linux. The including file sets the processor, Debian's two names for it, and the
# emulator.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-gcc)
set(CMAKE_CXX_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-g++)
set(CMAKE_SIZE_TOOL ${CMAKE_LIBRARY_ARCHITECTURE}-size)

# Libraries and headers for the target: Debian's, fetched into a cache, or those in the folder THIMBLE_SYSROOT. The compiler has its
# own C and C++ libraries.
if(NOT THIMBLE_SYSROOT)
  execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/../../scripts/sysroot ${THIMBLE_DEBIAN_ARCHITECTURE}
    OUTPUT_VARIABLE place OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "no libraries for ${THIMBLE_DEBIAN_ARCHITECTURE}, see above; or name a folder that has them: -D THIMBLE_SYSROOT=FOLDER")
  endif()
  set(THIMBLE_SYSROOT ${place}/root)
  set(THIMBLE_DEBIAN_PACKAGES ${place}/packages)  # for dpkg-shlibdeps
endif()
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES THIMBLE_SYSROOT)
set(CMAKE_FIND_ROOT_PATH ${THIMBLE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${THIMBLE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${THIMBLE_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/pkgconfig:${THIMBLE_SYSROOT}/usr/share/pkgconfig)

set(CMAKE_CROSSCOMPILING_EMULATOR ${THIMBLE_QEMU} -L /usr/${CMAKE_LIBRARY_ARCHITECTURE}
  -E LD_LIBRARY_PATH=${THIMBLE_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE})
