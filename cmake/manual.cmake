# The target `manual`: docs/ as HTML, in build/<preset>/manual/html. It takes the Python package, whose docstrings are a part of it.
# THIMBLE_MANUAL=ON makes it with everything else, and installs it (component `doc`). No network; the same sources give the same bytes.
find_program(SPHINX_BUILD sphinx-build)
find_program(DOXYGEN doxygen)
if(THIMBLE_MANUAL AND NOT (SPHINX_BUILD AND DOXYGEN AND TARGET thimble_python))
  message(FATAL_ERROR "THIMBLE_MANUAL needs THIMBLE_PYTHON and the packages_to_document of scripts/packages.sh")
endif()
if(NOT (SPHINX_BUILD AND DOXYGEN AND TARGET thimble_python))
  return()
endif()

set(manual ${PROJECT_BINARY_DIR}/manual)
set(all "")
if(THIMBLE_MANUAL)
  set(all ALL)
endif()
# What has changed since the last run is read anew: both programs look for themselves.
add_custom_target(manual ${all}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manual}/doxygen
  COMMAND ${CMAKE_COMMAND} -E env THIMBLE_DOXYGEN_OUTPUT=${manual}/doxygen ${DOXYGEN} ${PROJECT_SOURCE_DIR}/docs/manual/Doxyfile
  COMMAND ${CMAKE_COMMAND} -E env THIMBLE_VERSION=${PROJECT_VERSION} THIMBLE_DOXYGEN_XML=${manual}/doxygen/xml
    PYTHONPATH=$<PATH:GET_PARENT_PATH,$<TARGET_FILE_DIR:thimble_python>> PYTHONDONTWRITEBYTECODE=1
    ${SPHINX_BUILD} -W --keep-going -q -b html -c ${PROJECT_SOURCE_DIR}/docs/manual -d ${manual}/doctrees ${PROJECT_SOURCE_DIR} ${manual}/html
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
  VERBATIM)
add_dependencies(manual thimble_python)
if(THIMBLE_MANUAL)
  install(DIRECTORY ${manual}/html DESTINATION share/doc/thimble-doc COMPONENT doc PATTERN .buildinfo EXCLUDE)
  # Scripts that Debian has in libjs-sphinxdoc are links to it, as its policy asks. The index of the search belongs to this version of Sphinx.
  install(CODE "
    set(static \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/share/doc/thimble-doc/html/_static)
    set(debian /usr/share/javascript/sphinxdoc/1.0)
    file(GLOB scripts RELATIVE \${static} \${static}/*.js)
    foreach(script IN LISTS scripts)
      if(EXISTS \${debian}/\${script})
        file(SHA256 \${static}/\${script} ours)
        file(SHA256 \${debian}/\${script} theirs)
        if(ours STREQUAL theirs)
          file(CREATE_LINK ../../../../javascript/sphinxdoc/1.0/\${script} \${static}/\${script} SYMBOLIC)
        endif()
      endif()
    endforeach()" COMPONENT doc)
endif()
