# Qhull::qhull_r, compiled from Debian's source.
if(NOT TARGET Qhull::qhull_r)
  enable_language(C)
  include(${CMAKE_CURRENT_LIST_DIR}/debian_library.cmake)
  debian_library(thimble_qhull qhull src/libqhull_r/*_r.c)
  target_include_directories(thimble_qhull SYSTEM PUBLIC ${thimble_qhull_SOURCE}/src)
  add_library(Qhull::qhull_r ALIAS thimble_qhull)
endif()
set(Qhull_FOUND TRUE)
