# thimble_core: compile options of every library of the controller. Floating-point results must be the same on every target, so
# contraction and vectorised sums are off.
# thimble_host_code: the same warnings for code that runs on a PC only.
# thimble_brief_code: less optimisation, for code that takes longer to compile than to run: commands, but not the libraries that they
# call.
# thimble_unit_code: no optimisation, for unit tests that compute little.
# thimble_loop_code: the same for tests that simulate, with -O1, because they are too slow without optimisation.
add_library(thimble_warnings INTERFACE)
if(PROJECT_IS_TOP_LEVEL)  # a project that uses the renderer sets its own warnings
  set(warnings -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wcast-align -Wnon-virtual-dtor
    -Woverloaded-virtual -Wdouble-promotion -Wswitch-enum -Wsuggest-override -Wzero-as-null-pointer-constant -Werror)
  target_compile_options(thimble_warnings INTERFACE "$<BUILD_INTERFACE:${warnings}>")
endif()
target_compile_features(thimble_warnings INTERFACE cxx_std_20)
target_include_directories(thimble_warnings INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/thimble>)

add_library(thimble_core INTERFACE)
target_link_libraries(thimble_core INTERFACE thimble_warnings)
# -fno-math-errno: a square root is one instruction; nothing reads errno.
target_compile_options(thimble_core INTERFACE -ffp-contract=off -fno-math-errno)
# Eigen's vectorised sums would differ between targets.
target_compile_definitions(thimble_core INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MAX_STATIC_ALIGN_BYTES=0)

add_library(thimble_no_runtime INTERFACE)  # for the libraries of the controller, not for their users
target_compile_options(thimble_no_runtime INTERFACE -fno-exceptions -fno-rtti)
if(CMAKE_SYSTEM_NAME STREQUAL "Generic")  # stack use of each function, for tests/hardware/cortex/lint_image.py
  target_compile_options(thimble_no_runtime INTERFACE -fcallgraph-info=su)
endif()

add_library(thimble_host_code INTERFACE)
target_link_libraries(thimble_host_code INTERFACE thimble_core)

add_library(thimble_loop_code INTERFACE)
target_link_libraries(thimble_loop_code INTERFACE thimble_host_code)
target_compile_options(thimble_loop_code INTERFACE $<$<AND:$<CONFIG:Release>,$<NOT:$<PLATFORM_ID:WASI>>>:-O1>)  # a page loads it: small instead

add_library(thimble_brief_code INTERFACE)
target_link_libraries(thimble_brief_code INTERFACE thimble_loop_code)
if(CMAKE_CXX_FLAGS_DEBUG MATCHES sanitize)
  target_compile_options(thimble_brief_code INTERFACE $<$<CONFIG:Debug>:-O0>)
endif()

add_library(thimble_unit_code INTERFACE)
target_link_libraries(thimble_unit_code INTERFACE thimble_host_code)
target_compile_options(thimble_unit_code INTERFACE -O0)
