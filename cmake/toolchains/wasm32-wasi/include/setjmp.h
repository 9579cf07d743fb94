/* What wasi-libc lacks. The compiler makes exceptions of calls (-mllvm -wasm-enable-sjlj), which board/page/long_jump.cpp throws. */
#pragma once
typedef struct {
  void *function;
  unsigned label;
  void *environment;
  int value;
} jmp_buf[1];
#ifdef __cplusplus
extern "C" {
#endif
int setjmp(jmp_buf) __attribute__((returns_twice));
void longjmp(jmp_buf, int) __attribute__((noreturn));
#ifdef __cplusplus
}
#endif
