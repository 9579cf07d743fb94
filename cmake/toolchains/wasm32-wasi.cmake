# Modules for a web page, with Debian's clang, libc++ and wasi-libc (scripts/packages.sh: packages_to_page).
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR}/wasm32-wasi)  # its find_package() compiles the sources of libraries
set(CMAKE_SYSTEM_NAME WASI)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(llvm /usr/lib/llvm-22)
set(CMAKE_C_COMPILER ${llvm}/bin/clang)
set(CMAKE_CXX_COMPILER ${llvm}/bin/clang++)
set(CMAKE_AR ${llvm}/bin/llvm-ar CACHE FILEPATH "")
set(CMAKE_RANLIB ${llvm}/bin/llvm-ranlib CACHE FILEPATH "")
set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_SYSROOT /usr)  # include/wasm32-wasi and lib/wasm32-wasi are looked for in it
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
# The new name, wasm32-wasip1, is not that of wasi-libc's folders.
set(CMAKE_C_FLAGS_INIT "-Wno-deprecated -D_WASI_EMULATED_SIGNAL")
# Exceptions by WebAssembly's first instructions for them, which older browsers and Node.js have too.
# -nostdinc++: clang would also look into /usr/include/c++/v1, where the header of Debian's libc++ for this machine is, if it is installed.
set(CMAKE_CXX_FLAGS_INIT "-Wno-deprecated -D_WASI_EMULATED_SIGNAL -fwasm-exceptions -nostdinc++ -isystem /usr/include/wasm32-wasi/c++/v1")
# --no-wasm-opt: clang runs a wasm-opt that it finds, which takes the names of functions away.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-mexec-model=reactor --no-wasm-opt -Wl,--gc-sections -Wl,--strip-debug -Wl,-z,stack-size=1048576")
