# Run by CPack: what a binary of another architecture depends on. CPack's own call of dpkg-shlibdeps asks the packages of this machine;
# this one those of scripts/sysroot.
if(NOT IS_DIRECTORY "${CPACK_THIMBLE_DEBIAN_PACKAGES}")
  message(FATAL_ERROR "the packages of Debian's ${CPACK_DEBIAN_PACKAGE_ARCHITECTURE} are missing, so dependencies cannot be told: "
    "configure without THIMBLE_SYSROOT")
endif()
set(place ${CPACK_PACKAGE_DIRECTORY}/shlibdeps)
file(WRITE ${place}/debian/control "Source: thimble\n\nPackage: thimble-board\nArchitecture: any\n")
file(GLOB packages ${CPACK_THIMBLE_DEBIAN_PACKAGES}/*)
list(TRANSFORM packages PREPEND -S)
execute_process(
  COMMAND ${CMAKE_COMMAND} -E env DEB_HOST_ARCH=${CPACK_DEBIAN_PACKAGE_ARCHITECTURE} dpkg-shlibdeps -O ${packages} ${CPACK_THIMBLE_BINARY}
  WORKING_DIRECTORY ${place} OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_VARIABLE told RESULT_VARIABLE failed)
if(failed OR NOT found MATCHES "^shlibs:Depends=(.+)$")
  message(FATAL_ERROR "dpkg-shlibdeps: ${told}")
endif()
string(PREPEND CPACK_DEBIAN_BOARD_PACKAGE_DEPENDS "${CMAKE_MATCH_1}, ")
