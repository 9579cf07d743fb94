# assimp::assimp, compiled from Debian's source: the importers of OBJ, STL, PLY, OFF and glTF 2 alone, without the steps that change a mesh.
if(NOT TARGET assimp::assimp)
  include(${CMAKE_CURRENT_LIST_DIR}/debian_library.cmake)
  set(formats Obj STL Ply OFF glTF2)
  list(TRANSFORM formats PREPEND code/AssetLib/ OUTPUT_VARIABLE folders)
  list(TRANSFORM folders APPEND /*.cpp)
  # Of its common code what these importers need: to compile all of it takes as long as to compile everything else.
  set(common AssertHandler Assimp Base64 BaseImporter BaseProcess CreateAnimMesh DefaultIOStream DefaultIOSystem DefaultLogger Exceptional IOSystem Importer
    ImporterRegistry PostStepRegistry RemoveComments SGSpatialSort SceneCombiner ScenePreprocessor SkeletonMeshBuilder SpatialSort StandardShapes Subdivision
    Version material scene simd)
  list(TRANSFORM common REPLACE "(.+)" "code/Common/\\1.cpp")
  debian_library(thimble_assimp assimp ${common} code/Material/*.cpp code/PostProcessing/ArmaturePopulate.cpp code/PostProcessing/ProcessHelper.cpp
    code/PostProcessing/ScaleProcess.cpp code/PostProcessing/ValidateDataStructure.cpp
    code/AssetLib/glTF/glTFCommon.cpp ${folders})
  set(source ${thimble_assimp_SOURCE})

  # What the registries name is left out, but for these formats.
  foreach(registry ImporterRegistry PostStepRegistry)
    file(STRINGS ${source}/code/Common/${registry}.cpp lines REGEX "ASSIMP_BUILD_NO_")
    string(REGEX MATCHALL "ASSIMP_BUILD_NO_[0-9A-Z_]+" found "${lines}")
    list(APPEND left_out ${found})
  endforeach()
  list(REMOVE_DUPLICATES left_out)
  # A member of aiMesh depends on ARMATUREPOPULATE; Importer.cpp calls VALIDATEDS.
  list(FILTER left_out EXCLUDE REGEX "_NO_((OBJ|STL|PLY|OFF|GLTF|GLTF2)_IMPORTER|(ARMATUREPOPULATE|VALIDATEDS)_PROCESS)$")
  set(headers ${CMAKE_BINARY_DIR}/generated/assimp)
  set(ASSIMP_VERSION_MAJOR 5)
  set(ASSIMP_VERSION_MINOR 2)
  set(ASSIMP_VERSION_PATCH 5)
  set(ASSIMP_PACKAGE_VERSION 0)
  set(GIT_COMMIT_HASH 0)
  configure_file(${source}/revision.h.in ${headers}/revision.h)
  configure_file(${source}/include/assimp/config.h.in ${headers}/assimp/config.h)
  target_compile_definitions(thimble_assimp PRIVATE ${left_out} ASSIMP_BUILD_NO_EXPORT ASSIMP_BUILD_SINGLETHREADED RAPIDJSON_HAS_STDSTRING=1
    RAPIDJSON_NOMEMBERITERATORCLASS)
  # Headers alone of libutfcpp-dev, as assimp's own copy.
  find_path(UTFCPP_INCLUDE_DIR utf8.h PATHS /usr/include PATH_SUFFIXES utf8cpp NO_CMAKE_FIND_ROOT_PATH REQUIRED)
  file(MAKE_DIRECTORY ${headers}/code ${headers}/contrib/utf8cpp/source)
  file(CREATE_LINK ${UTFCPP_INCLUDE_DIR}/utf8.h ${headers}/contrib/utf8cpp/source/utf8.h SYMBOLIC)
  file(CREATE_LINK ${UTFCPP_INCLUDE_DIR}/utf8 ${headers}/contrib/utf8cpp/source/utf8 SYMBOLIC)
  target_include_directories(thimble_assimp SYSTEM PUBLIC ${source}/include ${headers}
    PRIVATE ${headers}/code ${source} ${source}/code ${source}/contrib ${source}/contrib/rapidjson/include)
  # All in one unit, for the time; these have names of their own that others have too.
  set_target_properties(thimble_assimp PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  foreach(alone STL/STLLoader Ply/PlyLoader OFF/OFFLoader glTF2/glTF2Importer)
    set_source_files_properties(${source}/code/AssetLib/${alone}.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
  set_source_files_properties(${source}/code/Common/DefaultIOSystem.cpp
    PROPERTIES COMPILE_OPTIONS "-include;${CMAKE_CURRENT_LIST_DIR}/include/no_realpath.h")
  add_library(assimp::assimp ALIAS thimble_assimp)
endif()
set(assimp_FOUND TRUE)
