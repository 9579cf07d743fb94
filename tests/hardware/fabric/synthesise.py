#!/usr/bin/env python3
"""synthesise.py: lints the logic in board/zynqmp/fabric and synthesises it for UltraScale+ by yosys, without vendor tools. Prints what it
takes and the longest path between registers, in cells (LUTs and steps of 4 bits of a carry chain), and fails above LIMITS, with any warning
of the lint, and if there is a latch or a combinational loop.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

LOGIC = pathlib.Path(__file__).resolve().parent.parent.parent.parent / "board" / "zynqmp" / "fabric"
LIMITS = {"look-up tables": 1100, "registers": 1800, "multipliers": 2, "longest path": 11}
# What is linted: the shipped parameters, and the ends of their ranges.
PARAMETERS = ({}, {"ARMS": 1, "CLOCK_HZ": 4000000, "FILTER": 2, "PULSE_CLOCKS": 2, "FULL_SCALE_UA": 65536, "INVERT": "3'd7", "SPI_HALF_CLOCKS": 1},
              {"CLOCK_HZ": 500000000, "FILTER": 255, "PULSE_CLOCKS": 65535, "FULL_SCALE_UA": 33554431, "SPI_HALF_CLOCKS": 16, "SPI_GAP_CLOCKS": 100})


def run(*command):
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except FileNotFoundError:
        sys.exit(f"synthesise: {command[0]} is missing: scripts/packages.sh names the packages of the tests")
    if done.returncode != 0:
        sys.exit(f"synthesise: {command[0]}:\n{done.stdout}{done.stderr}")
    return done.stdout


def main():
    sources = sorted(str(file) for file in LOGIC.glob("*.v"))
    for parameters in PARAMETERS:
        values = [f"-G{name}={value}" for name, value in parameters.items()]
        run("verilator", "--lint-only", "-Wall", "--language", "1364-2005", "--top-module", "fabric_axi", *values, *sources)
    with tempfile.TemporaryDirectory() as folder:
        # Registers and multipliers are cut out before ltp, which would take their inputs and outputs for one path.
        run("yosys", "-q", "-p", f"""read_verilog {' '.join(sources)}
            synth_xilinx -family xcup -top fabric_axi -flatten -noiopad -noclkbuf
            check -assert
            tee -o {folder}/stat stat
            delete t:FDRE t:FDSE t:DSP48E2
            tee -o {folder}/ltp ltp""".replace("\n", " ; "))
        stat, ltp = (pathlib.Path(folder, name).read_text() for name in ("stat", "ltp"))
    cells = {kind: int(number) for kind, number in re.findall(r"^ +([A-Z]\w*) +(\d+)$", stat, re.MULTILINE)}
    unknown = [kind for kind in cells if not re.fullmatch(r"LUT[1-6]|CARRY4|MUXF[789]|FDRE|FDSE|INV|DSP48E2", kind)]
    if unknown:
        sys.exit(f"synthesise: cells that the logic should not need: {', '.join(unknown)}")
    found = {
        "look-up tables": sum(number for kind, number in cells.items() if kind.startswith("LUT")),
        "registers": cells["FDRE"] + cells.get("FDSE", 0),
        "multipliers": cells.get("DSP48E2", 0),
        "longest path": int(re.search(r"length=(\d+)", ltp).group(1)),
    }
    for name, number in found.items():
        print(f"{name:16}{number:6} (limit {LIMITS[name]}){'' if number <= LIMITS[name] else '   OVER THE LIMIT'}")
    sys.exit(any(number > LIMITS[name] for name, number in found.items()))


if __name__ == "__main__":
    main()
