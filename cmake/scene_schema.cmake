# Generates reader and writer of scene images from control/scene/scene.fbs.
find_program(FLATC flatc REQUIRED)
set(SCENE_SCHEMA_DIR ${CMAKE_BINARY_DIR}/generated/thimble_scene_schema)
add_custom_command(
  OUTPUT ${SCENE_SCHEMA_DIR}/scene_generated.h
  COMMAND ${FLATC} --cpp --scoped-enums --cpp-std c++17 -o ${SCENE_SCHEMA_DIR} ${PROJECT_SOURCE_DIR}/control/scene/scene.fbs
  DEPENDS ${PROJECT_SOURCE_DIR}/control/scene/scene.fbs
  VERBATIM)
add_custom_target(thimble_scene_schema_header DEPENDS ${SCENE_SCHEMA_DIR}/scene_generated.h)
add_library(thimble_scene_schema INTERFACE)
target_include_directories(thimble_scene_schema SYSTEM INTERFACE ${CMAKE_BINARY_DIR}/generated)
add_dependencies(thimble_scene_schema thimble_scene_schema_header)
target_compile_definitions(thimble_scene_schema INTERFACE
  FLATBUFFERS_ASSERT=thimble_flatbuffers_assert
  FLATBUFFERS_ASSERT_INCLUDE="control/scene/flatbuffers_assert.h")
if(CMAKE_CROSSCOMPILING)  # /usr/include has the headers of the build machine
  find_path(FLATBUFFERS_INCLUDE_DIR flatbuffers/flatbuffers.h PATHS /usr/include /usr/local/include REQUIRED)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated)
  file(CREATE_LINK ${FLATBUFFERS_INCLUDE_DIR}/flatbuffers ${CMAKE_BINARY_DIR}/generated/flatbuffers SYMBOLIC)
endif()
