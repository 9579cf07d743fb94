// What the first Cortex-A53 runs in the emulated machine (AArch64, EL1): it switches the Cortex-R5F on by way of QEMU's PSCI, at the
// vectors of the image. With LINUX it then enters the kernel, as the boot protocol has it; else it sleeps.
  .global _start
_start:
  ldr x0, =0x84000003  // CPU_ON
  mov x1, #4           // QEMU's number of the first Cortex-R5F
  mov x2, #0           // where its image has the reset vector
  mov x3, #0
  smc #0
#ifdef LINUX
  ldr x0, =DEVICE_TREE
  mov x1, xzr
  mov x2, xzr
  mov x3, xzr
  ldr x4, =LINUX
  br x4
#endif
1:
  wfi
  b 1b
