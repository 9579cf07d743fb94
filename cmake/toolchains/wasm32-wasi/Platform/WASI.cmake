# What CMake 3.25 does not know of wasm32-wasi: no shared libraries, and modules are called .wasm.
set(WASI TRUE)
set(CMAKE_EXECUTABLE_SUFFIX .wasm)
set_property(GLOBAL PROPERTY TARGET_SUPPORTS_SHARED_LIBS FALSE)
