# Debian packages by component: `thimble` (for a host: command, simulator, scenes), `thimble-board`, `libthimble-dev`, `python3-thimble` and
# `thimble-doc`; the last two if they are built (THIMBLE_PYTHON, THIMBLE_MANUAL). All of them: cmake --workflow --preset packages
# A build for a board makes only its own, for its architecture. The same tree gives the same bytes.
include(GNUInstallDirs)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # what is packed is built, and the tests need not be
set(THIMBLE_MAINTAINER "Thimble maintainers <maintainers@thimble.invalid>" CACHE STRING "Who made the packages")

set(components board)
if(THIMBLE_HOST)
  list(APPEND components host dev)
  if(THIMBLE_PYTHON)
    list(APPEND components python)
  endif()
  if(THIMBLE_MANUAL AND TARGET manual)
    list(APPEND components doc)
  endif()
endif()
# All that is packed.
add_custom_target(thimble_packed)
set(targets thimble-board)
if(THIMBLE_HOST)
  list(APPEND targets thimble thimble-sim)
  foreach(name IN LISTS thimble_public)
    get_target_property(type thimble_${name} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND targets thimble_${name})
    endif()
  endforeach()
endif()
foreach(target thimble_python manual)
  if(TARGET ${target})
    list(APPEND targets ${target})
  endif()
endforeach()
add_dependencies(thimble_packed ${targets})

set(CPACK_HOST_NAME thimble)
set(CPACK_BOARD_NAME thimble-board)
set(CPACK_DEV_NAME libthimble-dev)
set(CPACK_PYTHON_NAME python3-thimble)
set(CPACK_DOC_NAME thimble-doc)

# The time of everything in the packages: that of the last commit.
set(epoch $ENV{SOURCE_DATE_EPOCH})
if(NOT epoch)
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%ct OUTPUT_VARIABLE epoch OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT epoch)  # sources without their history
  file(TIMESTAMP ${PROJECT_SOURCE_DIR}/CHANGELOG.md epoch "%s")
endif()
set(given_epoch $ENV{SOURCE_DATE_EPOCH})
set(ENV{SOURCE_DATE_EPOCH} ${epoch})
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(ENV{SOURCE_DATE_EPOCH} ${given_epoch})

# Required files of each package: licence and changelog, which names the release that it is built on.
cmake_host_system_information(RESULT release QUERY DISTRIB_VERSION_CODENAME)
if(NOT release)
  set(release unstable)
endif()
set(packaging ${PROJECT_BINARY_DIR}/packaging)
find_program(GZIP gzip REQUIRED)
foreach(component IN LISTS components)
  string(TOUPPER ${component} COMPONENT)
  set(package ${CPACK_${COMPONENT}_NAME})
  file(WRITE ${packaging}/${package}/changelog
    "${package} (${PROJECT_VERSION}) ${release}; urgency=medium\n\n  * Built from the source tree; its history says what changed.\n\n -- ${THIMBLE_MAINTAINER}  ${date}\n")
  execute_process(COMMAND ${GZIP} -9nf ${packaging}/${package}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${packaging}/${package}/changelog.gz ${PROJECT_SOURCE_DIR}/cmake/packages/copyright
    DESTINATION share/doc/${package} COMPONENT ${component})
endforeach()

# Man pages, from what the programs print. Those of another architecture cannot be asked here.
if(NOT CMAKE_CROSSCOMPILING)
  set(host_programs thimble thimble-sim)
  set(board_programs thimble-board)
  foreach(component host board)
    list(TRANSFORM ${component}_programs PREPEND ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/ OUTPUT_VARIABLE programs)
    list(JOIN programs "\" \"" programs)
    install(CODE "execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/scripts/man_pages\"
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/man/man1\" \"${programs}\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
  endforeach()
endif()

# Links of installed Markdown lead to what is installed, and so does the "$schema" of scenes.
foreach(component host board)
  string(TOUPPER ${component} COMPONENT)
  install(CODE "execute_process(COMMAND \"${PROJECT_SOURCE_DIR}/scripts/installed_links\" \"${CPACK_${COMPONENT}_NAME}\"
    \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
endforeach()

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

# thimble_of_this_version(OUT PACKAGE PATTERN): the versions of a package that what is built here is of, as a dependency; any where there is no dpkg.
function(thimble_of_this_version out package pattern)
  execute_process(COMMAND dpkg-query --show --showformat "\${Version}" ${package} OUTPUT_VARIABLE version RESULT_VARIABLE failed ERROR_QUIET)
  set(${out} ${package} PARENT_SCOPE)
  if(NOT failed AND version MATCHES "${pattern}")
    set(${out} "${package} (>= ${CMAKE_MATCH_0}), ${package} (<< ${CMAKE_MATCH_0}.99)" PARENT_SCOPE)
  endif()
endfunction()

set(CPACK_DEBIAN_HOST_PACKAGE_NAME thimble)
set(CPACK_COMPONENT_HOST_DESCRIPTION "force-feedback arm: scenes, devices, simulator
Compiles scenes, uploads them to the controller of a haptic arm, shows what
the fingertip feels, and simulates an arm where there is none.")
set(CPACK_DEBIAN_HOST_PACKAGE_RECOMMENDS "gnuplot-nox")
set(CPACK_DEBIAN_HOST_PACKAGE_SUGGESTS "can-utils, iproute2, xdg-utils")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libthimble-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEV_DESCRIPTION "force-feedback arm: libraries for C++
Renders the contact forces of a scene, computes the kinematics of arms,
compiles scenes, talks to devices and simulates them: headers, static
libraries and targets for CMake, find_package(thimble).")
if(THIMBLE_HOST)  # the schemas' headers ask for this FlatBuffers, and the names of fmt's functions have its major version
  thimble_of_this_version(flatbuffers libflatbuffers-dev "^[0-9]+\\.[0-9]+\\.[0-9]+")
  thimble_of_this_version(fmt libfmt-dev "^[0-9]+")
endif()
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libassimp-dev, libbearssl-dev, libboost-dev, libeigen3-dev, ${flatbuffers}, ${fmt}, libmnl-dev, libpng-dev, \
libqhull-dev, liburdfdom-dev, nlohmann-json3-dev, pkgconf, zlib1g-dev")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-thimble)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "force-feedback arm: Python module
Simulates scenes, talks to devices and reads recordings, with arrays of NumPy.")
if(THIMBLE_PYTHON)  # a module is of one interpreter
  find_package(Python REQUIRED COMPONENTS Interpreter)
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), python3 (<< ${Python_VERSION_MAJOR}.${next}), python3-numpy")
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-matplotlib")  # docs/first-experiment.md draws with it
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-h5py, python3-pandas")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/cmake/packages/python/postinst ${PROJECT_SOURCE_DIR}/cmake/packages/python/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_DOC_PACKAGE_NAME thimble-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_COMPONENT_DOC_DESCRIPTION "force-feedback arm: manual
The manual as HTML: /usr/share/doc/thimble-doc/html/index.html.")
if(doc IN_LIST components)  # its scripts (cmake/manual.cmake) and the index that they search are of one version of Sphinx
  thimble_of_this_version(CPACK_DEBIAN_DOC_PACKAGE_DEPENDS libjs-sphinxdoc "^[0-9]+\\.[0-9]+")
endif()

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
else()
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
endif()
set(CPACK_THIMBLE_EPOCH ${epoch})
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/packages/when_packed.cmake)
include(CPack)
