# What a project outside links: thimble::control and the others, by add_subdirectory() or, installed (component `dev`), by
# find_package(thimble). Headers keep the paths that they have in the tree.
set(thimble_public kinematics control firmware link proof bearssl arm_image scene_schema core warnings no_runtime host_code text_files
  board_posix scene_walk plant arm_mechanics any_plant board_sim sim_files arm_image_file file_keys compiler arm_pose arms services client
  recording replay files lab)
foreach(name IN LISTS thimble_public)
  add_library(thimble::${name} ALIAS thimble_${name})
  set_target_properties(thimble_${name} PROPERTIES EXPORT_NAME ${name})
endforeach()
if(NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

set(libraries lib/${CMAKE_LIBRARY_ARCHITECTURE})
set(package ${libraries}/cmake/thimble)
list(TRANSFORM thimble_public PREPEND thimble_ OUTPUT_VARIABLE targets)
install(TARGETS ${targets} EXPORT thimble ARCHIVE DESTINATION ${libraries} COMPONENT dev)
install(EXPORT thimble NAMESPACE thimble:: FILE thimbleTargets.cmake DESTINATION ${package} COMPONENT dev)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/packaging/thimbleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/packages/thimbleConfig.cmake ${PROJECT_BINARY_DIR}/packaging/thimbleConfigVersion.cmake
  DESTINATION ${package} COMPONENT dev)

foreach(folder kinematics control firmware board/common board/files board/posix board/sim board/walk host-tools/arms host-tools/client
    host-tools/compiler host-tools/files host-tools/keys host-tools/lab)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}/ DESTINATION include/thimble/${folder} COMPONENT dev FILES_MATCHING PATTERN *.h PATTERN *.def)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/host-tools/error.h DESTINATION include/thimble/host-tools COMPONENT dev)
foreach(schema scene arm recording)
  install(FILES ${PROJECT_BINARY_DIR}/generated/thimble_${schema}_schema/${schema}_generated.h
    DESTINATION include/thimble/thimble_${schema}_schema COMPONENT dev)
endforeach()
