# Generates readers and writers of the images: scenes (control/scene/scene.fbs) and arms (firmware/arm/arm.fbs).
find_program(FLATC flatc REQUIRED)
set(headers "")
foreach(schema control/scene/scene firmware/arm/arm)
  get_filename_component(name ${schema} NAME)
  set(folder ${CMAKE_BINARY_DIR}/generated/thimble_${name}_schema)
  add_custom_command(
    OUTPUT ${folder}/${name}_generated.h
    COMMAND ${FLATC} --cpp --scoped-enums --cpp-std c++17 -o ${folder} ${PROJECT_SOURCE_DIR}/${schema}.fbs
    DEPENDS ${PROJECT_SOURCE_DIR}/${schema}.fbs
    VERBATIM)
  list(APPEND headers ${folder}/${name}_generated.h)
endforeach()
add_custom_target(thimble_scene_schema_header DEPENDS ${headers})
add_library(thimble_scene_schema INTERFACE)
target_include_directories(thimble_scene_schema SYSTEM INTERFACE $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/generated>)
add_dependencies(thimble_scene_schema thimble_scene_schema_header)
target_compile_definitions(thimble_scene_schema INTERFACE
  FLATBUFFERS_ASSERT=thimble_flatbuffers_assert
  FLATBUFFERS_ASSERT_INCLUDE="control/scene/flatbuffers_assert.h")
if(CMAKE_CROSSCOMPILING)  # /usr/include has the headers of the build machine
  find_path(FLATBUFFERS_INCLUDE_DIR flatbuffers/flatbuffers.h PATHS /usr/include /usr/local/include REQUIRED)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated)
  file(CREATE_LINK ${FLATBUFFERS_INCLUDE_DIR}/flatbuffers ${CMAKE_BINARY_DIR}/generated/flatbuffers SYMBOLIC)
endif()
