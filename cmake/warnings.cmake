# thimble_core: what every library of the controller is compiled with (no heap, no exceptions, no RTTI below
# host-tools; the same floating-point result on every target, so contraction and vectorised sums are off).
# thimble_host_code: the same warnings for code that runs on a PC only.
# thimble_brief_code: besides, optimised less, for what takes longer to compile than to run: commands and unit tests, not the
# libraries they call.
# thimble_loop_code: the same for tests that simulate; they would crawl without any optimisation.
add_library(thimble_warnings INTERFACE)
if(PROJECT_IS_TOP_LEVEL)  # a project that links the renderer has warnings of its own
  target_compile_options(thimble_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wcast-align -Wnon-virtual-dtor
    -Woverloaded-virtual -Wdouble-promotion -Wswitch-enum -Wsuggest-override -Wzero-as-null-pointer-constant -Werror)
endif()
target_compile_features(thimble_warnings INTERFACE cxx_std_20)
target_include_directories(thimble_warnings INTERFACE ${PROJECT_SOURCE_DIR})

add_library(thimble_core INTERFACE)
target_link_libraries(thimble_core INTERFACE thimble_warnings)
# -fno-math-errno: a root is one instruction; nothing reads errno.
target_compile_options(thimble_core INTERFACE -ffp-contract=off -fno-math-errno)
# Eigen's packet sums would differ from one target to the next.
target_compile_definitions(thimble_core INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MAX_STATIC_ALIGN_BYTES=0)

add_library(thimble_no_runtime INTERFACE)  # added by the controller's own libraries, not by their users
target_compile_options(thimble_no_runtime INTERFACE -fno-exceptions -fno-rtti)
if(THIMBLE_BOARD AND NOT THIMBLE_BOARD STREQUAL "linux")  # what tests/hardware/cortex/lint_image.py reads beside the objects: each function's stack
  target_compile_options(thimble_no_runtime INTERFACE -fcallgraph-info=su)
endif()

add_library(thimble_host_code INTERFACE)
target_link_libraries(thimble_host_code INTERFACE thimble_core)

add_library(thimble_loop_code INTERFACE)
target_link_libraries(thimble_loop_code INTERFACE thimble_host_code)
target_compile_options(thimble_loop_code INTERFACE $<$<CONFIG:Release>:-O1>)

add_library(thimble_brief_code INTERFACE)
target_link_libraries(thimble_brief_code INTERFACE thimble_loop_code)
if(CMAKE_CXX_FLAGS_DEBUG MATCHES sanitize)
  target_compile_options(thimble_brief_code INTERFACE $<$<CONFIG:Debug>:-O0>)
endif()
