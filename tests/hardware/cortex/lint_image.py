"""lint_image.py ELF --objects DIR --limits FILE...: what a bare-metal image may not have, and how much stack it takes at worst.

An image is refused for a heap, exceptions, RTTI, stdio, locales, arithmetic in double (the cores have single-precision units), work before
run_board, a section over the linker script's budget, a recursion, a function or a context over its stack, and a sum over the stack.

The calls are read from the disassembly, so the libraries' count too. A function's stack is the compiler's word (-fcallgraph-info=su: the .ci
files below DIR, and each call that they name must be in the disassembly) or, for a library without one, the sum of all that its instructions
take. Contexts are those that interrupt one another: their worst paths add up. What sets the stack pointer to the stack's end, a start, takes
nothing of its caller's. A board whose tick has a memory of its own names the tick's roots: what they reach, and the constants that its code
names, must not be between the linker script's outside_begin and outside_end. The limits are an INI file; of several, a later one's options
replace an earlier one's:

    [functions]            most_bytes: what one function may take
    [context NAME]         roots: functions; most_bytes: what their worst path may take; entry_bytes: what the processor pushes before them
    [tick]                 roots: functions
    [call NAME]            from, to: patterns of demangled names, one a line, * for anything: which functions are called by way of a pointer or
                           a table; "none" instead of patterns: nothing on this board; reason
    [allow SYMBOL]         a symbol that would be refused; reason

A rule is for all calls through pointers that a function makes: two kinds in one function need two rules that name it. What such a rule
misses shows as a function that no root reaches, which is refused too, as is a rule that matches nothing and a limit far above its figure.

Exit code 0: none of that; 1: refused, each reason a line; 2: it could not be checked.
"""

import argparse
import collections
import configparser
import re
import sys
from pathlib import Path

from arm_image import Image, Unusable

# What must not be in an image, by the names of its symbols.
REFUSED = (
    ("the heap", r"_*(malloc|calloc|realloc|free|memalign|sbrk|cfree)(_r)?|_Zn[wa].*|_Zd[la].*"),
    ("exceptions", r"__cxa_(throw|rethrow|allocate_exception|begin_catch|end_catch|get_globals).*|_Unwind_.*|__gxx_personality.*"
                   r"|_ZSt\d+__throw_.*|__gnu_unwind.*"),
    ("RTTI", r"_ZTI.*|_ZTS.*|__dynamic_cast"),
    ("stdio", r"_*(v|s|f|d|vs|vf|sn|vsn|as|vas|i|si|fi|svf|svfi|vfi)*(printf|scanf)(_r|_i|_common|_float)?|_*(put|get)(s|c|char)(_r)?"
              r"|_*f(open|close|read|write|flush|puts|putc|seek)(_r)?|_*(write|read|lseek|close|fstat|isatty)(_r)?|__s[fw](p|rite|vwrite).*"
              r"|__sf(p|v|moreglue|_fake_\w+)?|_ZNSt8ios_base.*|_ZSt4c(out|in|err)"),
    ("a locale", r"_*setlocale(_r)?|_*localeconv(_r)?|__(global_)?locale.*|_ZNSt6locale.*"),
    ("arithmetic in double", r"__aeabi_(d|cd).*|__aeabi_(f2d|i2d|ui2d|l2d|ul2d)|__(add|sub|mul|div|neg|cmp|eq|ne|lt|le|gt|ge|unord)df2"
                             r"|__(add|sub|mul|div)df3|__(extendsf|trunc|fix|fixuns|float|floatun)\w*df\w*|__truncdfsf2"),
)

# A limit is lowered when its figure falls: it may be so much above.
LOOSE_RATIO, LOOSE_BYTES = 1.25, 64
IDLE_SHOWN = 12  # of the functions that need not be in the memory of the tick

FRAME = re.compile(r"(\d+) bytes \((static|dynamic|dynamic,bounded)\)$")


def figure(what, value, limit):
    print("[ figure   ] %-72s %12d   (%s)" % (what, value, limit))


class Lint:
    def __init__(self, image, limits):
        self.image = image
        self.limits = limits
        self.errors = []

    def refuse(self, text, *values):
        self.errors.append(text % values)

    def check_symbols(self):
        allowed = {section.removeprefix("allow ") for section in self.limits.sections() if section.startswith("allow ")}
        for what, pattern in REFUSED:
            for name in sorted(self.image.symbols):
                if re.fullmatch(pattern, name) and name not in allowed:
                    self.refuse("%s: the symbol %s", what, name)
        for name in sorted(allowed - set(self.image.symbols)):
            self.refuse("[allow %s] matches nothing", name)
        begin, end = self.symbol("init_array_begin"), self.symbol("init_array_end")
        if begin != end:
            names = [f.shown for f in self.image.functions.values() if f.name.startswith("_GLOBAL__sub_I_")]
            self.refuse("%d initialisers run before run_board: %s. Make their objects constinit", (end - begin) // 4, ", ".join(names))

    def symbol(self, name):
        value = self.image.symbols.get(name)
        if value is None:
            raise Unusable("the image has no symbol %s: it is not linked with board/cortex/sections.ld" % name)
        return value

    def check_sections(self):
        address = {}
        for name, start, size in self.image.sections:
            address[name] = start
            figure("bytes of " + name, size, "at 0x%08x" % start)
        code = self.symbol("data_stored") + self.symbol("data_end") - self.symbol("data_begin") - address[".text"]
        data = self.symbol("bss_end") - address[".data"]
        for what, size in (("code", code), ("data", data)):
            budget = self.symbol(what + "_budget")
            figure("bytes of " + what, size, "at most %d" % budget)
            if size > budget:
                self.refuse("%s: %d bytes, of %d", what, size, budget)

    def read_frames(self, folders):
        """The compiler's words, of the files that the image is made of; a function of several files has its greatest."""
        by_name = collections.defaultdict(list)
        for function in self.image.functions.values():
            for name in function.names:
                by_name[name].append(function)
        sources = 0
        calls = collections.defaultdict(list)  # function -> the callees of each file that has it
        for path in sorted(path for folder in folders for path in Path(folder).rglob("*.ci")):
            if path.stem not in self.image.files:
                continue
            sources += 1
            text = path.read_text()
            named = {}
            for title, label in re.findall(r'^node: \{ title: "(.*?)" label: "(.*?)"', text, re.MULTILINE):
                frame = FRAME.search(label)
                if frame is None:
                    continue
                for function in by_name[title.rsplit(":", 1)[-1]]:
                    named[title] = function
                    function.frame = max(int(frame[1]), function.frame if function.compiled else 0)
                    function.compiled = True
                    if frame[2] == "dynamic":
                        self.refuse("%s: its stack has no bound (an array of variable size, or alloca)", function.shown)
            of_file = collections.defaultdict(set)
            for caller, callee in re.findall(r'^edge: \{ sourcename: "(.*?)" targetname: "(.*?)"', text, re.MULTILINE):
                if caller in named and not callee.startswith("__aeabi_"):  # GCC 12 takes some of libgcc's for one another
                    of_file[named[caller]].add(callee.rsplit(":", 1)[-1])
            for function in set(named.values()):
                calls[function].append(of_file[function])
        for function in self.image.functions.values():
            if not function.compiled and function.runs_into:
                function.callees[function.runs_into.address] = function.runs_into
        if sources == 0:
            raise Unusable("no .ci file of the image's sources below %s: build it anew" % ", ".join(folders))
        for function, files in calls.items():
            self.check_calls(function, files)

    def check_calls(self, function, files):
        """That the disassembly has the calls which the compiler says there are, in one of the files that have the function."""
        found = {name for callee in function.callees.values() for name in callee.names} | set(function.names)
        if function.indirect:
            found.add("__indirect_call")
        missing = min((callees - found for callees in files), key=len)
        if missing:
            self.refuse("%s: it should call %s, and does not: the .ci files are not those of this image", function.shown,
                        ", ".join(sorted(missing)))

    def add_rules(self):
        ruled = set()
        for section in self.limits.sections():
            if not section.startswith("call "):
                continue
            callers = self.matching(section, "from")
            callees = [] if self.words(section, "to") == ["none"] else self.matching(section, "to")
            for caller in callers:
                if not caller.indirect:
                    self.refuse("[%s] from: %s calls nothing through a pointer", section, caller.shown)
                ruled.add(caller)
                for callee in callees:
                    caller.callees[callee.address] = callee
        for function in self.image.functions.values():
            if function.indirect and function not in ruled:
                self.refuse("%s calls through a pointer, and no rule says what", function.shown)

    def words(self, section, option):
        lines = self.limits.get(section, option, fallback="").splitlines()
        found = [line.strip() for line in lines if line.strip()]
        if not found:
            raise Unusable("the limits have no '%s' in [%s]" % (option, section))
        return found

    def number(self, section, option):
        text = self.words(section, option)[0]
        if not text.isdigit():
            raise Unusable("[%s] %s = %s: it has to be a number of bytes" % (section, option, text))
        return int(text)

    def matching(self, section, option):
        found = []
        for pattern in self.words(section, option):
            matcher = re.compile(".*".join(map(re.escape, pattern.split("*"))))
            matches = [function for function in self.image.functions.values() if matcher.fullmatch(function.shown)]
            if option == "from":  # a function that was inlined elsewhere, or split, is not one that calls
                matches = [function for function in matches if function.indirect] or matches
            if not matches:
                self.refuse("[%s] %s: '%s' matches nothing", section, option, pattern)
            found += matches
        return found

    def check_stack(self):
        most = self.number("functions", "most_bytes")
        greatest = max(self.image.functions.values(), key=lambda function: function.frame)
        self.hold("stack of the greatest function, " + greatest.shown.split("(")[0], greatest.frame, most)
        for function in self.image.functions.values():
            if function.frame > most:
                self.refuse("%s takes %d bytes of stack, of %d", function.shown, function.frame, most)

        reached = {}  # function -> (bytes of its worst path, the path)
        total = 0
        for section in self.limits.sections():
            if not section.startswith("context "):
                continue
            roots = self.matching(section, "roots")
            if not roots:
                continue
            worst, path = max((self.worst(root, reached, []) for root in roots), key=lambda found: found[0])
            worst += self.number(section, "entry_bytes")
            total += worst
            self.hold("stack of the %s" % section, worst, self.number(section, "most_bytes"))
            for function in path:
                print("%20d  %s" % (function.frame, function.shown))
        stack = self.symbol("stack_end") - self.symbol("stack_begin")
        figure("stack of all contexts, one upon the other", total, "at most %d" % stack)
        if total > stack:
            self.refuse("the contexts' worst paths take %d bytes of stack, of %d", total, stack)
        for function in self.image.functions.values():
            if function.compiled and function not in reached:
                self.refuse("%s is in the image, and no root reaches it: a rule is missing, or a reference is needless", function.shown)
            elif not function.compiled and function in reached and function.odd:
                self.refuse("%s: its stack is not known, for '%s'", function.shown, function.odd[0])

    def check_tick(self):
        """That what the tick runs, and the constants that its code names, are not between outside_begin and outside_end."""
        if "tick" not in self.limits:
            return
        begin, end = self.symbol("outside_begin"), self.symbol("outside_end")
        above = {root: None for root in self.matching("tick", "roots")}
        to_do = list(above)
        while to_do:
            function = to_do.pop()
            for callee in function.callees.values():
                if callee not in above and not callee.anew:
                    above[callee] = function
                    to_do.append(callee)
        for function, caller in above.items():
            if begin <= function.address < end:
                self.refuse("%s is outside the memory of the tick, which runs it: %s", function.shown,
                            "it is a root" if caller is None else caller.shown + " calls it")
            elif any(begin & ~0xFFFF <= constant < end for constant in function.constants):
                self.refuse("%s runs in the tick, and uses a constant outside its memory", function.shown)
        idle = [function for function in self.image.functions.values() if function not in above and not begin <= function.address < end]
        figure("bytes of functions in the memory of the tick which it does not run", sum(f.end - f.address for f in idle), "they may be outside")
        for function in sorted(idle, key=lambda function: function.address - function.end)[:IDLE_SHOWN]:
            print("%20d  %s" % (function.end - function.address, function.shown))

    def hold(self, what, found, most):
        figure(what, found, "at most %d" % most)
        if found > most:
            self.refuse("%s: %d bytes, of %d", what, found, most)
        elif most > found * LOOSE_RATIO + LOOSE_BYTES:
            self.refuse("%s: %d bytes, far below the limit of %d. Lower the limit", what, found, most)

    def worst(self, function, reached, above):
        if function in above:
            circle = above[above.index(function):] + [function]
            raise Recursion(" calls ".join(each.shown for each in circle))
        if function not in reached:
            below = [self.worst(callee, reached, above + [function]) for callee in function.callees.values() if not callee.anew]
            most, path = max(below, key=lambda found: found[0], default=(0, []))
            reached[function] = (function.frame + most, [function] + path)
        return reached[function]


class Recursion(Exception):
    pass


def read_limits(paths):
    limits = configparser.ConfigParser(interpolation=None, delimiters=("=",), comment_prefixes=("#",), default_section="")
    known = {"functions": {"most_bytes"}, "tick": {"roots"}, "context": {"roots", "entry_bytes", "most_bytes"}, "call": {"from", "to", "reason"},
             "allow": {"reason"}}
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                limits.read_file(file)
        except (OSError, configparser.Error) as error:
            raise Unusable("the limits: %s" % error) from None
    for section in limits.sections():
        options = known.get(section.split()[0], set())
        unknown = set(limits.options(section)) - options
        if not options or unknown:
            raise Unusable("the limits: [%s] %s is not known" % (section, " ".join(sorted(unknown))))
        if "reason" in options and not limits.get(section, "reason", fallback=""):
            raise Unusable("the limits: [%s] has no reason" % section)
    return limits


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("elf", type=Path)
    parser.add_argument("--objects", action="append", required=True, metavar="DIR", help="where the compiler's .ci files are")
    parser.add_argument("--limits", action="append", required=True, metavar="FILE")
    arguments = parser.parse_args()
    try:
        limits = read_limits(arguments.limits)
        if not arguments.elf.is_file():
            raise Unusable("there is no %s: build the image first" % arguments.elf)
        lint = Lint(Image(arguments.elf), limits)
        lint.check_symbols()
        lint.check_sections()
        lint.read_frames(arguments.objects)
        lint.add_rules()
        try:
            lint.check_tick()
            lint.check_stack()
        except Recursion as circle:
            lint.refuse("a recursion: %s", circle)
    except Unusable as error:
        print("lint_image: %s" % error, file=sys.stderr)
        return 2
    for error in lint.errors:
        print("lint_image: %s: %s" % (arguments.elf.name, error), file=sys.stderr)
    return 1 if lint.errors else 0


if __name__ == "__main__":
    sys.exit(main())
