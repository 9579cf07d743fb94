// setjmp and longjmp on WebAssembly's exceptions, which wasi-libc lacks: what the compiler calls for them with -wasm-enable-sjlj. libpng and Qhull
// leave by them. After LLVM's WebAssemblyLowerEmscriptenEHSjLj.cpp, whose functions these are.
#include <csetjmp>

__asm__(".globl __c_longjmp\n.tagtype __c_longjmp i32\n__c_longjmp:\n");

extern "C" {
// In `setjmp`: function: the call of the function that it is in; label: the setjmp, from 1.
void __wasm_setjmp(void* environment, unsigned label, void* function) {
  auto* const at = static_cast<std::jmp_buf*>(environment);
  (*at)[0].function = function;
  (*at)[0].label = label;
}
// A jump has come to this call of a function: which setjmp of it is meant; 0: none, it is another call's.
unsigned __wasm_setjmp_test(void* environment, void* function) {
  const auto* const at = static_cast<std::jmp_buf*>(environment);
  return (*at)[0].function == function ? (*at)[0].label : 0;
}
[[noreturn]] void __wasm_longjmp(void* environment, int value) {
  auto* const at = static_cast<std::jmp_buf*>(environment);
  (*at)[0].environment = environment;
  (*at)[0].value = value == 0 ? 1 : value;
  constexpr int kLongJump = 1;  // __c_longjmp; 0 is __cpp_exception
  __builtin_wasm_throw(kLongJump, &(*at)[0].environment);
}
}
