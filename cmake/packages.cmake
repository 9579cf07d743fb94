# Debian packages by component: `thimble` (for a host: command, simulator, scenes) and `thimble-board`. After a build:
#   cpack --config build/release/CPackConfig.cmake -B build/release/packages
# A build for a board makes only the second one, for its architecture.
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # what is packed is built, and the tests need not be
set(THIMBLE_MAINTAINER "Thimble maintainers <maintainers@thimble.invalid>" CACHE STRING "Who made the packages")

set(components board)
if(THIMBLE_HOST)
  list(PREPEND components host)
endif()
set(CPACK_HOST_NAME thimble)
set(CPACK_BOARD_NAME thimble-board)

# Required files of each package: licence and changelog.
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(packaging ${PROJECT_BINARY_DIR}/packaging)
find_program(GZIP gzip REQUIRED)
foreach(component IN LISTS components)
  string(TOUPPER ${component} COMPONENT)
  set(package ${CPACK_${COMPONENT}_NAME})
  file(WRITE ${packaging}/${package}/changelog
    "${package} (${PROJECT_VERSION}) bookworm; urgency=medium\n\n  * Built from the source tree; its history says what changed.\n\n -- ${THIMBLE_MAINTAINER}  ${now}\n")
  execute_process(COMMAND ${GZIP} -9nf ${packaging}/${package}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${packaging}/${package}/changelog.gz ${PROJECT_SOURCE_DIR}/cmake/packages/copyright
    DESTINATION share/doc/${package} COMPONENT ${component})
endforeach()

# Man pages, from what the programs print. Those of another architecture cannot be asked here.
if(NOT CMAKE_CROSSCOMPILING)
  set(host_programs thimble thimble-sim)
  set(board_programs thimble-board)
  foreach(component IN LISTS components)
    list(TRANSFORM ${component}_programs PREPEND ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/ OUTPUT_VARIABLE programs)
    list(JOIN programs "\" \"" programs)
    install(CODE "execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/scripts/man_pages\"
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/man/man1\" \"${programs}\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
  endforeach()
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME thimble)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${THIMBLE_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_HOST_PACKAGE_NAME thimble)
set(CPACK_COMPONENT_HOST_DESCRIPTION "force-feedback arm: scenes, devices, simulator
Compiles scenes, uploads them to the controller of a haptic arm, shows what
the fingertip feels, and simulates an arm where there is none.")
set(CPACK_DEBIAN_HOST_PACKAGE_RECOMMENDS "gnuplot-nox")
set(CPACK_DEBIAN_HOST_PACKAGE_SUGGESTS "can-utils, iproute2")

set(CPACK_DEBIAN_BOARD_PACKAGE_NAME thimble-board)
set(CPACK_COMPONENT_BOARD_DESCRIPTION "force-feedback arm: controller for embedded Linux
Reads the encoders, renders what the fingertip touches and drives the motors
of a haptic arm, on a board with its electronics: CAN, SPI, GPIO, counters.
The service starts once /etc/thimble/board.json has been written.")
set(CPACK_DEBIAN_BOARD_PACKAGE_SUGGESTS "iproute2, gpiod")
set(CPACK_DEBIAN_BOARD_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/board/linux/packaging/postinst
  ${PROJECT_SOURCE_DIR}/board/linux/packaging/prerm
  ${PROJECT_SOURCE_DIR}/board/linux/packaging/postrm)
set(CPACK_DEBIAN_BOARD_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_BOARD_PACKAGE_DEPENDS "systemd")
set(CPACK_DEBIAN_BOARD_PACKAGE_RECOMMENDS udev)
if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE ${THIMBLE_DEBIAN_ARCHITECTURE})
  set(CPACK_THIMBLE_BINARY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/thimble-board)
  set(CPACK_THIMBLE_DEBIAN_PACKAGES ${THIMBLE_DEBIAN_PACKAGES})
  set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/packages/cross_depends.cmake)
else()
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
endif()
include(CPack)
