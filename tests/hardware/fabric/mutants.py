#!/usr/bin/env python3
"""mutants.py FABRIC_TEST FOLDER: seeds defects in the logic of board/zynqmp/fabric, one at a time, and fails if one is not caught.

A defect is caught by the proof or by the case of FABRIC_TEST that its row names. FOLDER has the models of build_model.
"""
import os
import pathlib
import shutil
import subprocess
import sys

import prove

HERE = pathlib.Path(__file__).resolve().parent

# (what is wrong, file, text, what stands there instead, the proof of prove.SHORT or the case of fabric_test that catches it).
MUTANTS = [
    ("watchdog one microsecond late", "enable", "elapsed_us >= watchdog_us", "elapsed_us > watchdog_us", "enable"),
    ("enable one clock late", "enable", "clocks <= 10'd3;", "clocks <= 10'd2;", "enable"),
    ("enable on through a reset", "enable", "reset || expired || tripped ?", "expired || tripped ?", "enable"),
    ("any commit ends a trip", "enable", "if (!reset && commit && wanted == {ARMS{1'b0}})", "if (!reset && commit)", "enable"),
    ("pulse after the enable", "enable", "pulse <= next_enable &", "pulse <= enable &", "enable"),
    ("edges of B are not counted", "encoder", "if (edge_a != edge_b)", "if (edge_a && !edge_b)", "encoder"),
    ("B counts the wrong way", "encoder", "edge_a ? now_a != now_b : now_a == now_b", "now_a != now_b", "encoder"),
    ("filter longer than the edges allow", "filter", "LENGTH[7:0] - 8'd1", "LENGTH[7:0]", "encoder"),
    ("latch of one counter only", "registers", "latched_count <= count;", "latched_count[31:0] <= count[31:0];", "registers"),
    ("lines that are not latched", "registers", "latched_line <= line;\n      latched_index", "latched_index", "registers"),
    ("currents applied before the commit", "registers", "if (commit) current_uA <= staged_uA;", "current_uA <= staged_uA;", "registers"),
    ("drives read as good after a trip", "registers", "good & ~{ARMS{tripped}}", "good", "registers"),
    ("parts of words are written", "axi", "wire write = take_write && s_axi_wstrb == 4'hF;", "wire write = take_write;", "axi"),
    ("an answer that does not wait", "axi", "end else if (s_axi_bready) s_axi_bvalid", "end else s_axi_bvalid", "axi"),
    ("watchdog at an address of its own", "registers", "WORD_WATCHDOG = 10'd5", "WORD_WATCHDOG = 10'd6", "DriverRig.TheWatchdog*"),
    ("a set of frames of two commits", "dac", "else if (pending && step < LOAD && step != RANGE)", "else if (1'b0)", "DriverRig.Converters*"),
    ("comparison without signs", "dac", "localparam signed [31:0] MOST", "localparam [31:0] MOST", "DriverRig.Converters*"),
    ("current without an enable", "dac", "enable ? chosen : 32'd0", "chosen", "DriverRig.Converters*"),
]


def caught_by_test(logic, folder, case, fabric_test):
    build = subprocess.run([HERE / "build_model", logic, folder, "-O1"], capture_output=True, text=True)
    if build.returncode != 0:
        sys.exit(f"mutants: build_model: {build.stdout}{build.stderr}")
    test = subprocess.run([fabric_test, "--gtest_brief=1", f"--gtest_filter={case}"], capture_output=True, text=True,
                          env={**os.environ, "THIMBLE_FABRIC": str(folder / "libfabric.so")})
    if test.returncode not in (0, 1):
        sys.exit(f"mutants: fabric_test ends with {test.returncode}: {test.stdout}{test.stderr}")
    return test.returncode == 1


def main():
    fabric_test, models = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    missed = 0
    for name, file, text, instead, catcher in MUTANTS:
        logic = models / "mutant.v"
        shutil.rmtree(logic, ignore_errors=True)
        shutil.copytree(prove.LOGIC, logic)
        source = logic / f"fabric_{file}.v"
        shipped = source.read_text()
        if shipped.count(text) != 1:
            sys.exit(f"mutants: fabric_{file}.v has {shipped.count(text)} times: {text}")
        source.write_text(shipped.replace(text, instead))
        if catcher in prove.SHORT:
            caught = not prove.holds(prove.SHORT[catcher], logic)[0]
        else:
            caught = caught_by_test(logic, models / "mutant", catcher, fabric_test)
        print(f"{'caught' if caught else 'MISSED'} by {catcher:24} {name}", flush=True)
        missed += not caught
    for name, proof in prove.SHORT.items():  # what is seeded is what fails
        if not prove.holds(proof)[0]:
            sys.exit(f"mutants: the proof {name} fails without a defect")
    print(f"{len(MUTANTS)} defects, {missed} missed")
    sys.exit(missed != 0)


if __name__ == "__main__":
    main()
