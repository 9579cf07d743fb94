#!/usr/bin/env python3
"""prove.py: proves the properties of properties/*.vh of the logic in board/zynqmp/fabric, for every input and for all time.

Each proof is a bounded check from reset and a temporal induction, by yosys-smtbmc with z3. What feeds a proved module but does not matter
to its properties (decoders, converters) is cut out, so its outputs may be anything.
"""
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
LOGIC = HERE.parent.parent.parent / "board" / "zynqmp" / "fabric"
CUT = "delete */t:*fabric_dac* */t:*fabric_encoder* */t:*fabric_filter*"

# Proof: (module, parameters, what is cut, clocks of the bounded check, clocks of the induction). The bounded check is at least as long.
PROOFS = {
    "encoder": ("encoder", {"FILTER": 16}, "", 24, 22),  # as shipped
    "enable": ("enable", {"CLOCKS_PER_US": 100, "PULSE_CLOCKS": 500}, "", 6, 3),  # as shipped, every time up to 5 ms
    "registers": ("registers", {}, CUT, 8, 4),
    "axi": ("axi", {}, CUT, 8, 4),
}
# For seeded defects, which a short trace must show: small numbers, so that it is short.
SHORT = {
    "encoder": ("encoder", {"FILTER": 3}, "", 20, 0),
    "enable": ("enable", {"CLOCKS_PER_US": 4, "PULSE_CLOCKS": 2}, "", 11, 0),
    "registers": PROOFS["registers"][:4] + (0,),
    "axi": PROOFS["axi"][:4] + (0,),
}


def run(*command):
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except FileNotFoundError:
        sys.exit(f"prove: {command[0]} is missing: scripts/packages.sh names the packages of the tests")
    return done.returncode, done.stdout + done.stderr


def holds(proof, logic=LOGIC):
    """(True, "") or (False, what the solver found). SystemExit if the tools fail."""
    module, parameters, cut, bounded, induction = proof
    with tempfile.TemporaryDirectory() as folder:
        smt2 = f"{folder}/{module}.smt2"
        values = " ".join(f"-set {name} {value}" for name, value in parameters.items())
        script = f"""read_verilog -formal -DPROVE_{module.upper()} -I{HERE}/properties {logic}/*.v
            {f"chparam {values} fabric_{module}" if values else ""}
            hierarchy -top fabric_{module}; proc -norom; {cut}
            flatten; setundef -undriven -anyseq; async2sync; dffunmap; opt_clean; write_smt2 -wires {smt2}"""
        code, text = run("yosys", "-q", "-p", " ; ".join(line.strip() for line in script.splitlines() if line.strip()))
        if code != 0:
            sys.exit(f"prove: yosys: {text}")
        for arguments in [("-t", str(bounded))] + ([("-i", "-t", str(induction))] if induction else []):
            code, text = run("yosys-smtbmc", "--noprogress", "-s", "z3", *arguments, smt2)
            if "Status: PASSED" in text and code == 0:
                continue
            found = [line.split("  ")[-1].strip() for line in text.splitlines() if "ailed" in line]
            if not found:
                sys.exit(f"prove: yosys-smtbmc: {text}")
            return False, "\n".join(found)
    return True, ""


def main():
    failed = False
    for name, proof in PROOFS.items():
        proved, found = holds(proof)
        values = ", ".join(f"{key} {value}" for key, value in proof[1].items())
        print(f"{name:10} {'proved' if proved else 'FAILED'} {'(' + values + ')' if values else ''}\n{found}".rstrip(), flush=True)
        failed = failed or not proved
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
