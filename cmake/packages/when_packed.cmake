# Run by CPack before it installs and packs: the time of all files, and of the man pages.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  set(ENV{SOURCE_DATE_EPOCH} ${CPACK_THIMBLE_EPOCH})
endif()
if(CPACK_THIMBLE_BINARY)
  include(${CMAKE_CURRENT_LIST_DIR}/cross_depends.cmake)
endif()
