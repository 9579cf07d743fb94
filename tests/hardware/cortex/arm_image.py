"""A linked bare-metal ARM image: its symbols and sections, and of each function the calls, the stack and the constants by its disassembly."""

import collections
import re
import subprocess

TOOLS = "arm-none-eabi-"

VENEER = re.compile(r"__.*_(veneer|from_arm|from_thumb)$")
CALL = re.compile(r"blx?(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|al)?$")


class Unusable(Exception):
    """The check cannot be made; the message says why and what to do."""


def tool(name, *arguments):
    try:
        return subprocess.run([TOOLS + name, *map(str, arguments)], capture_output=True, text=True, check=True).stdout
    except FileNotFoundError:
        raise Unusable("%s%s is missing: apt-get install binutils-arm-none-eabi" % (TOOLS, name)) from None
    except subprocess.CalledProcessError as error:
        raise Unusable("%s%s: %s" % (TOOLS, name, error.stderr.strip())) from None


class Function:
    def __init__(self, names, address, end):
        self.names = names
        self.name = names[0]
        self.shown = self.name
        self.address = address
        self.end = end
        self.callees = {}  # by address, so that aliases are one
        self.runs_into = None  # hand-written code may, without a branch
        self.indirect = 0
        self.constants = set()  # of 32 bits: addresses, among others
        self.frame = 0
        self.anew = False  # it sets the stack pointer to the stack's end, as a start does
        self.odd = []  # what the disassembly does with the stack that is not understood
        self.compiled = False  # its frame is the compiler's word


class Image:
    def __init__(self, elf):
        self.symbols = {}  # name -> value, and what is only referenced: None
        self.files = set()
        self.sections = []  # (name, address, bytes), of what takes memory
        self.functions = {}  # by address
        self._read_symbols(elf)
        self._read_sections(elf)
        self._read_code(elf)

    def _read_symbols(self, elf):
        starts = collections.defaultdict(list)
        for line in tool("readelf", "--symbols", "--wide", elf).splitlines():
            row = line.split()
            if len(row) < 8 or not row[0].rstrip(":").isdigit():
                continue
            value, size, kind, index, name = int(row[1], 16), int(row[2], 0), row[3], row[6], row[7]
            if kind == "FILE":
                self.files.add(name)
            elif not name.startswith("$") and kind != "SECTION":
                self.symbols[name] = None if index == "UND" else value
                if kind == "FUNC" and index != "UND":
                    starts[value & ~1].append((name, size))
        ordered = sorted(starts)
        for address, following in zip(ordered, ordered[1:] + [1 << 32]):
            sizes = [size for _, size in starts[address]]
            end = address + max(sizes) if max(sizes) else following
            self.functions[address] = Function([name for name, _ in starts[address]], address, end)
        shown = tool("c++filt", "--", *[function.name for function in self.functions.values()]).splitlines()
        for function, name in zip(self.functions.values(), shown):
            function.shown = name

    def _read_sections(self, elf):
        for line in tool("readelf", "--sections", "--wide", elf).splitlines():
            row = re.match(r"\s*\[ *\d+\] (\S+)\s+\S+\s+([0-9a-f]{8}) [0-9a-f]+ ([0-9a-f]+) [0-9a-f]{2}\s+\w*A", line)
            if row:
                self.sections.append((row[1], int(row[2], 16), int(row[3], 16)))

    def _read_code(self, elf):
        owner = {}
        current = None
        code = []
        for line in tool("objdump", "--disassemble", "--no-show-raw-insn", "--wide", elf).splitlines():
            row = re.match(r"\s*([0-9a-f]+):\t(\S+)\s*(.*)", line)
            if row is None:
                continue
            address = int(row[1], 16)
            if row[2].startswith("."):
                if row[2] == ".word" and current is not None and address < current.end:
                    current.constants.add(int(row[3].split()[0], 16))
                continue
            current = self.functions.get(address, current)
            if current is not None and address < current.end:
                owner[address] = current
                code.append((current, row[2].removesuffix(".n").removesuffix(".w"), re.split(r"\s*[;@] ", row[3])[0]))
        last = {}
        for function, mnemonic, operands in code:
            self._read_instruction(owner, function, mnemonic, operands)
            if mnemonic != "nop":  # which fills up to the constants behind the code
                last[function] = (mnemonic, operands)
        for function, instruction in last.items():
            if not ends(*instruction):
                function.runs_into = self.functions.get(function.end)
        # The linker's code for a call that is too far, or between ARM and Thumb code, is a jump to its only constant.
        veneers = {}
        for function in self.functions.values():
            targets = [owner.get(constant & ~1) for constant in function.constants]
            if VENEER.match(function.name) and len(targets) == 1 and targets[0]:
                veneers[function] = targets[0]
                function.indirect = 0
        for function in self.functions.values():
            callees = [veneers.get(callee, callee) for callee in function.callees.values()]
            function.callees = {callee.address: callee for callee in callees}

    def _read_instruction(self, owner, function, mnemonic, operands):
        branch = re.search(r"\b([0-9a-f]+) <[^>]+>$", operands)
        if mnemonic.startswith(("b", "cb")) and branch:
            target = owner.get(int(branch[1], 16))
            if target is None:
                function.odd.append("a branch to %s, which is no code" % branch[1])
            elif target is not function or (CALL.match(mnemonic) and int(branch[1], 16) == function.address):
                function.callees[target.address] = target
        elif re.match(r"blx", mnemonic) or (re.match(r"bx|mov(?!t|w)", mnemonic) and is_jump(mnemonic, operands)):
            function.indirect += 1
        elif re.match(r"ldr\w*$", mnemonic) and re.match(r"pc, \[(?!sp\])(?!.*, lsl #2\])", operands):
            function.indirect += 1  # with lsl it is a switch
        elif mnemonic.startswith("movt"):
            function.constants.add(int(operands.split("#")[1]) << 16)  # the upper half
        taken = stack_taken(mnemonic, operands)
        if mnemonic.startswith("ldr") and operands.startswith("sp, [pc"):
            function.anew = True
        elif taken is None:
            function.odd.append("%s %s" % (mnemonic, operands))
        else:
            function.frame += taken


def is_jump(mnemonic, operands):
    """bx or mov: to where a register says, and not a return."""
    return operands != "lr" if mnemonic.startswith("bx") else re.match(r"pc, (?!lr)", operands) is not None


def ends(mnemonic, operands):
    """Nothing runs on behind this instruction."""
    return (mnemonic in ("b", "bx", "bl", "udf") or operands.startswith("pc,") or
            (mnemonic.startswith(("pop", "ldm")) and "pc" in operands))


def registers(operands):
    count = 0
    for entry in re.search(r"\{(.*)\}", operands)[1].split(","):
        bounds = re.findall(r"\d+", entry) if "-" in entry else []
        count += int(bounds[1]) - int(bounds[0]) + 1 if bounds else 1
    return count


def stack_taken(mnemonic, operands):
    """Bytes that an instruction moves the stack pointer down; 0 where it moves up; None: not known."""
    if re.match(r"push|stm(db|fd)|vpush|vstmdb", mnemonic) and re.match(r"\{|sp!,", operands):
        wide = re.search(r"\{d\d", operands) is not None
        return registers(operands) * (8 if wide else 4)
    stored = re.match(r"[^\[]*\[sp, #-(\d+)\]!", operands)
    if mnemonic.startswith("str") and stored:
        return int(stored[1])
    if re.match(r"(sub|add)(w|s)?$", mnemonic) and operands.startswith("sp,"):
        amount = re.match(r"sp, (?:sp, )?#(-?\d+)", operands)
        if amount is None:
            return None
        down = int(amount[1]) * (1 if mnemonic.startswith("sub") else -1)
        return max(down, 0)
    if operands.startswith("sp,") and not mnemonic.startswith(("cmp", "tst", "str", "stm", "ldm", "vldm", "vstm")):
        return None
    return 0
