// A QEMU plugin: how many instructions the guest executes between two of its addresses, each time. The counts repeat exactly, whatever
// the machine does beside it.
//
//   qemu-system-arm ... -plugin file=libtick_plugin.so,begin=HEX,end=HEX,csv=FILE
//
// FILE has one line a passage. At exit: "ticks n=N min=A max=B sum=C at=D" on stderr, `at` the first passage that took the most.
// The declarations are those of QEMU's qemu-plugin.h, API version 1; Debian does not package the header.
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void *), void *);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *, void (*)(unsigned, void *), int, void *);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb *, int, void *, uint64_t);

#define EXPORT __attribute__((visibility("default")))
enum { ADD_U64 = 0, NO_REGISTERS = 0 };

EXPORT int qemu_plugin_version = 1;

static uint64_t executed, begin_address, end_address, started, passages, least = UINT64_MAX, most, sum, most_at;
static int inside;
static FILE *csv;

static void on_begin(unsigned cpu, void *data) {
  (void)cpu, (void)data;
  started = executed;
  inside = 1;
}

static void on_end(unsigned cpu, void *data) {
  (void)cpu, (void)data;
  if (!inside) return;
  inside = 0;
  const uint64_t count = executed - started;
  if (count < least) least = count;
  if (count > most) most = count, most_at = passages;
  sum += count;
  if (csv) fprintf(csv, "%" PRIu64 "\n", count);
  passages++;
}

// A block is counted when it is entered: it ends at its first branch. The two addresses begin functions, hence blocks, so both have their
// whole block in the count.
static void on_block(qemu_plugin_id_t id, struct qemu_plugin_tb *block) {
  (void)id;
  qemu_plugin_register_vcpu_tb_exec_inline(block, ADD_U64, &executed, qemu_plugin_tb_n_insns(block));
  for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); i++) {
    struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(block, i);
    const uint64_t address = qemu_plugin_insn_vaddr(insn);
    if (address == begin_address) qemu_plugin_register_vcpu_insn_exec_cb(insn, on_begin, NO_REGISTERS, NULL);
    if (address == end_address) qemu_plugin_register_vcpu_insn_exec_cb(insn, on_end, NO_REGISTERS, NULL);
  }
}

static void at_exit(qemu_plugin_id_t id, void *data) {
  (void)id, (void)data;
  fprintf(stderr, "ticks n=%" PRIu64 " min=%" PRIu64 " max=%" PRIu64 " sum=%" PRIu64 " at=%" PRIu64 "\n", passages,
          passages ? least : 0, most, sum, most_at);
  if (csv) fclose(csv);
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info_t *info, int argc, char **argv) {
  (void)info;
  for (int i = 0; i < argc; i++) {
    // Bit 0 of a Thumb function's address says that it is one.
    if (!strncmp(argv[i], "begin=", 6)) begin_address = strtoull(argv[i] + 6, NULL, 16) & ~UINT64_C(1);
    if (!strncmp(argv[i], "end=", 4)) end_address = strtoull(argv[i] + 4, NULL, 16) & ~UINT64_C(1);
    if (!strncmp(argv[i], "csv=", 4) && !(csv = fopen(argv[i] + 4, "w"))) return 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, on_block);
  qemu_plugin_register_atexit_cb(id, at_exit, NULL);
  return 0;
}
