"""That lint_image.py refuses what it is there for: small bad programs, linked as the images are, and each refusal by its name."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3]
LINT = SOURCE / "tests/hardware/cortex/lint_image.py"
FLAGS = ("-mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard -std=c++20 -O2 -ffunction-sections -fno-rtti -fno-threadsafe-statics "
         "-fno-use-cxa-atexit -fcallgraph-info=su").split()
LINK = ["-nostartfiles", "--specs=nano.specs", "--specs=nosys.specs", "-Wl,--gc-sections", "-T", SOURCE / "board/mps2-an500/mps2-an500.ld",
        "-L", SOURCE / "board/cortex"]

OF_ZYNQMP = ["-mcpu=cortex-r5", "-mfpu=vfpv3-d16", "-fno-exceptions"]

LIMITS = """
[functions]
most_bytes = 64
[context background]
roots = start
entry_bytes = 0
most_bytes = 64
"""
BEGIN = "volatile int in, out; volatile float real;\n"
GOOD = BEGIN + "[[gnu::noinline]] float twice(float x) { return x * 2.0F; }\nextern \"C\" void start() { for (;;) real = twice(real); }\n"
THROUGH_POINTER = BEGIN + """
[[gnu::noinline]] void first() { out = 1; }
[[gnu::noinline]] void second() { out = 2; }
void (*const table[])() = {first, second};
extern "C" void start() { for (;;) table[in & 1](); }
"""
RULE = """
[call table]
from = start
to =
  first()
  second()
reason = the table
"""


TICK = """
[tick]
roots = tick()
"""
# Two files of the board that has a memory outside the tick's: what both have stays in that of the tick.
SHARED = BEGIN.replace("volatile", "extern volatile") + "[[gnu::noinline]] inline void shared() { out = 3; }\n"
OUTSIDE = SHARED + """
extern const int table[];
const int table[] = {3, 1, 4, 1, 5};
void background() { shared(); out = 2; }
"""
INSIDE = BEGIN + SHARED + """
extern const int table[];
void background();
[[gnu::noinline]] void deep() { background(); out = 1; }
[[gnu::noinline]] void tick() { %s; out = 4; }
extern "C" void start() { for (;;) { tick(); deep(); } }
"""


class LintImage(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def build(self, source, *flags, stack="-fcallgraph-info=su"):
        (self.folder / "image.cpp").write_text(source)
        compiler = ["arm-none-eabi-g++", *FLAGS, *(flags or ["-fno-exceptions"]), stack]
        subprocess.run([*compiler, "-c", "image.cpp", "-o", "image.cpp.obj"], cwd=self.folder, check=True)
        subprocess.run([*compiler, "image.cpp.obj", "-o", "image.elf", *LINK], cwd=self.folder, check=True)

    def build_two(self, in_tick):
        """For the board with two memories, which are too far apart for a call without a veneer."""
        compiler = ["arm-none-eabi-g++", *FLAGS, *OF_ZYNQMP, "-fcallgraph-info=su"]
        objects = []
        for name, source in (("unity_outside_tick_cxx.cxx", OUTSIDE), ("image.cpp", INSIDE % in_tick)):
            (self.folder / name).write_text(source)
            objects.append(name + ".obj")
            subprocess.run([*compiler, "-x", "c++", "-c", name, "-o", objects[-1]], cwd=self.folder, check=True)
        link = [str(option).replace("mps2-an500", "zynqmp") for option in LINK]
        subprocess.run([*compiler, *objects, "-o", "image.elf", *link], cwd=self.folder, check=True)

    def lint(self, limits):
        (self.folder / "limits").write_text(limits)
        return subprocess.run([sys.executable, "-B", LINT, self.folder / "image.elf", "--objects", self.folder, "--limits", self.folder / "limits"],
                              capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})

    def passes(self, source, limits=LIMITS):
        self.build(source)
        run = self.lint(limits)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        return run.stdout

    def refuses(self, words, source, *flags, limits=LIMITS):
        self.build(source, *flags)
        run = self.lint(limits)
        self.assertEqual(run.returncode, 1, run.stderr)
        for word in words:
            self.assertIn(word, run.stderr)

    def unusable(self, words, limits):
        run = self.lint(limits)
        self.assertEqual(run.returncode, 2)
        self.assertIn(words, run.stderr)

    def test_good_program(self):
        self.assertRegex(self.passes(GOOD), r"stack of the context background +\d+ ")

    def test_heap(self):
        self.refuses(["the heap: the symbol malloc", "the heap: the symbol _sbrk"],
                     "#include <cstdlib>\n" + BEGIN + "extern \"C\" void start() { for (;;) out = std::malloc(in) != nullptr; }",
                     "-fno-exceptions", "-fno-builtin")

    def test_operator_new(self):
        self.refuses(["the heap: the symbol _Znwj"], BEGIN + "extern \"C\" void start() { for (;;) out = *new int(in); }")

    def test_double(self):
        self.refuses(["arithmetic in double: the symbol __aeabi_dmul", "arithmetic in double: the symbol __aeabi_f2d"],
                     BEGIN + "extern \"C\" void start() { for (;;) real = real * 0.1; }")

    def test_throw(self):
        self.refuses(["exceptions: the symbol __cxa_throw", "RTTI: the symbol _ZTIi"],
                     BEGIN + "extern \"C\" { int __dso_handle, __exidx_start, __exidx_end; void start() { if (in != 0) throw 1; } }",
                     "-fexceptions")

    def test_printf(self):
        self.refuses(["stdio: the symbol printf", "stdio: the symbol _write"],
                     "#include <cstdio>\n" + BEGIN + "extern \"C\" void start() { for (;;) std::printf(\"%d\", in); }")

    def test_locale(self):
        self.refuses(["a locale: the symbol setlocale"],
                     "#include <clocale>\n" + BEGIN + "extern \"C\" void start() { for (;;) std::setlocale(LC_ALL, \"C\"); }")

    def test_initialiser(self):
        self.refuses(["1 initialisers run before run_board: _GLOBAL__sub_I_"],
                     BEGIN + "int early = in;\nextern \"C\" void start() { for (;;) out = early; }")

    LARGE = BEGIN + """
[[gnu::noinline]] void fill() { volatile char large[10240]; for (int i = 0; i < 10240; ++i) large[i] = 0; }
extern "C" void start() { for (;;) fill(); }
"""

    def test_large_function(self):
        self.refuses(["fill() takes 10240 bytes of stack, of 64", "stack of the context background: 102"], self.LARGE)

    def test_sum_over_the_stack(self):
        limits = LIMITS.replace("64", "10250")
        self.passes(self.LARGE, limits)
        twice = limits + "[context interrupt]\nroots = fill()\nentry_bytes = 104\nmost_bytes = 10400\n"
        self.passes(self.LARGE, twice)
        self.refuses(["the contexts' worst paths take 30", "bytes of stack, of 21504"], self.LARGE,
                     limits=twice + "[context upon]\nroots = fill()\nentry_bytes = 104\nmost_bytes = 10400\n")

    def test_array_of_variable_size(self):
        self.refuses(["its stack has no bound"],
                     BEGIN + "extern \"C\" void start() { for (;;) { volatile char* p = static_cast<char*>(__builtin_alloca(in)); p[0] = 1; } }")

    def test_recursion(self):
        self.refuses(["a recursion: deep(int) calls deep(int)"], BEGIN + """
[[gnu::noinline]] int deep(int n) { return n == in ? 0 : deep(n + 1) * n + deep(n + 2); }
extern "C" void start() { for (;;) out = deep(0); }
""", "-fno-exceptions", "-fno-inline")

    def test_start_that_is_called(self):
        source = BEGIN + """extern "C" {
[[gnu::naked]] void start() { asm volatile("%s b go\\n .ltorg"); }
[[gnu::used]] void go() { if (in != 0) start(); for (;;) out = in; }
}"""
        self.passes(source % "ldr sp, =stack_end\\n")
        self.refuses(["a recursion: start calls go calls start"], source % "")

    def test_library_function(self):
        source = BEGIN + """
asm(".thumb_func\\n.type library, %%function\\nlibrary: push {r4, lr}\\n vpush {d8-d9}\\n %s\\n vpop {d8-d9}\\n pop {r4, pc}\\n .size library, . - library");
extern "C" void library();
extern "C" void start() { for (;;) library(); }
"""
        self.assertRegex(self.passes(source % "sub sp, #8\\n add sp, #8"), r"\n +32  library\n")
        self.refuses(["library: its stack is not known, for 'sub sp, sp, r0'"], source % "sub sp, sp, r0\\n add sp, sp, r0")

    def test_call_through_a_pointer(self):
        self.refuses(["start calls through a pointer, and no rule says what", "first() is in the image, and no root reaches it"], THROUGH_POINTER)
        self.passes(THROUGH_POINTER, LIMITS + RULE)
        self.refuses(["second() is in the image, and no root reaches it"], THROUGH_POINTER, limits=LIMITS + RULE.replace("  second()\n", ""))

    def test_rules_that_match_nothing(self):
        self.refuses(["[call table] from: start calls nothing through a pointer", "[call table] to: 'first()' matches nothing"],
                     GOOD, limits=LIMITS + RULE)
        self.refuses(["[allow malloc] matches nothing"], GOOD, limits=LIMITS + "[allow malloc]\nreason = none\n")

    def test_loose_limit(self):
        self.refuses(["far below the limit of 1000. Lower the limit"], GOOD, limits=LIMITS.replace("64", "1000"))

    def test_outside_the_tick(self):
        limits = LIMITS + TICK
        self.build_two("shared()")
        run = self.lint(limits)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        called = "background() is outside the memory of the tick, which runs it: %s calls it"
        for refusal, in_tick in ((called % "tick()", "background()"), (called % "deep()", "deep()"),
                                 ("tick() runs in the tick, and uses a constant outside its memory", "out = table[in]")):
            with self.subTest(in_tick):
                self.build_two(in_tick)
                run = self.lint(limits)
                self.assertEqual(run.returncode, 1, run.stderr)
                self.assertIn(refusal, run.stderr)

    def test_over_the_budget(self):  # the linker refuses it first, unless told not to
        self.refuses(["data: 2000", "bytes, of 174080"],
                     BEGIN + "volatile char large[200000];\nextern \"C\" void start() { for (;;) out = large[in]; }",
                     "-fno-exceptions", "-Wl,--noinhibit-exec")

    def test_unusable(self):
        self.build(GOOD, stack="-fno-stack-protector")
        (self.folder / "image.cpp.ci").unlink(missing_ok=True)
        self.unusable("no .ci file", LIMITS)
        self.build(GOOD)
        self.unusable("[call table] has no reason", LIMITS + RULE.replace("reason = the table\n", ""))
        self.unusable("[functions] mots_bytes is not known", LIMITS.replace("most", "mots", 1))
        self.unusable("has to be a number of bytes", LIMITS.replace("64", "64 kB"))
        (self.folder / "image.elf").unlink()
        self.unusable("build the image first", LIMITS)


if __name__ == "__main__":
    unittest.main()
