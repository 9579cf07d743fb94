# thimble_controller_headers(TARGET): the headers that most files of the controller include are parsed once for all of its libraries:
# control/solids/box.cpp takes 1.3 s instead of 2.0 s on a Cortex-R5. Few of the project's own are among them, because GCC instantiates what
# the inline functions of a precompiled header use in every file again: with control/renderer.h an empty file took 1.6 s. Applies where the
# controller is compiled file by file, in the release preset and for the bare-metal boards, and for a page. The preset `dev` does without, and
# so finds a file that does not include what it uses.
if(THIMBLE_UNITY STREQUAL "host" OR NOT (THIMBLE_HOST OR THIMBLE_UNITY) OR THIMBLE_BOARD STREQUAL "page")
  file(WRITE ${CMAKE_BINARY_DIR}/generated/controller_headers.cpp "")
  add_library(thimble_controller_headers OBJECT ${CMAKE_BINARY_DIR}/generated/controller_headers.cpp)
  target_link_libraries(thimble_controller_headers PRIVATE thimble_core thimble_no_runtime thimble_scene_schema Eigen3::Eigen)
  target_precompile_headers(thimble_controller_headers PRIVATE <Eigen/Geometry> <algorithm> <array> <atomic> <cmath> <cstdint> <cstring>
    <optional> <span> <string_view> <thimble_scene_schema/scene_generated.h> <kinematics/vector.h>)
endif()

function(thimble_controller_headers target)
  if(TARGET thimble_controller_headers)
    target_link_libraries(${target} PRIVATE thimble_scene_schema)  # GCC checks that the macros of the headers are defined here too
    target_precompile_headers(${target} REUSE_FROM thimble_controller_headers)
  endif()
endfunction()

# thimble_outside_tick(TARGET REGEX): the sources that match do not run in the tick, so they may be compiled as one. Each is small, and takes a
# second for its headers: together those of the firmware take 6 s instead of 35 s on a Cortex-R5. On the bare-metal boards, whose code memory
# is small, they are optimised for size: 47 instead of 68 kB there. On zynqmp they are in a memory of their own (board/zynqmp/zynqmp.ld).
function(thimble_outside_tick target regex)
  if(TARGET thimble_controller_headers AND NOT CMAKE_UNITY_BUILD)
    get_target_property(sources ${target} SOURCES)
    list(FILTER sources INCLUDE REGEX "${regex}")
    set_source_files_properties(${sources} PROPERTIES UNITY_GROUP outside_tick)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
      # Options of the sources would keep them from being compiled as one. The precompiled headers are for another optimisation.
      set_source_files_properties(${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/Unity/unity_outside_tick_cxx.cxx
        PROPERTIES COMPILE_OPTIONS -Os SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endif()
endfunction()
