# nlohmann_json::nlohmann_json: its headers alone. /usr/include as a whole belongs to the build machine.
find_path(NLOHMANN_INCLUDE_DIR nlohmann/json.hpp PATHS /usr/include /usr/local/include NO_CMAKE_FIND_ROOT_PATH REQUIRED)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated/libraries)
file(CREATE_LINK ${NLOHMANN_INCLUDE_DIR}/nlohmann ${CMAKE_BINARY_DIR}/generated/libraries/nlohmann SYMBOLIC)
if(NOT TARGET nlohmann_json::nlohmann_json)
  add_library(nlohmann_json::nlohmann_json INTERFACE IMPORTED)
  target_include_directories(nlohmann_json::nlohmann_json INTERFACE ${CMAKE_BINARY_DIR}/generated/libraries)
endif()
set(nlohmann_json_FOUND TRUE)
