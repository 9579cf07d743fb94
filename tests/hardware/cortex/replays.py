"""Recorded runs and their replay on emulated boards: what the tests here and find_worst share."""
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent / "zynqmp"))
from stub import assemble_stub  # noqa: E402

HERE = pathlib.Path(__file__).parent
SCENES = HERE.parent.parent.parent / "scenes"
BUILD = HERE.parent.parent.parent / "build"
TICKS = 42_000  # of each scene; 24 scenes are a million ticks
WORST_TICKS = 20_000
# Scenes that are also replayed at the highest rate, and how long: until the hand has touched.
FAST, FAST_HZ, FAST_TICKS = ("asteroid", "blocks", "buttons", "textures"), 20_000, 50_000

# How QEMU starts the image build/BOARD/bin/replay-BOARD.elf, with the recording where board/BOARD/CMakeLists.txt says.
QEMU = {
    "mps2-an500": ["qemu-system-arm", "-M", "mps2-an500", "-kernel", "{elf}", "-device", "loader,file={recording},addr=0x60800000,force-raw=on"],
    # The first Cortex-A53 only starts the Cortex-R5F: no instruction of its own is in a tick.
    "zynqmp": ["qemu-system-aarch64", "-M", "xlnx-zcu102", "-smp", "5", "-m", "1G", "-audiodev", "none,id=none", "-kernel", "{stub}",
               "-device", "loader,file={elf}", "-device", "loader,file={recording},addr=0x3E800000,force-raw=on"],
}
# The image's exit codes; QEMU's own are below.
ENDS = {33: "the scene was refused", 34: "homing was refused", 35: "arming was refused", 36: "a fault latched", 40: "the image crashed, or a tick used what is outside its memory",
        41: "QEMU loaded no recording, or forces.bin can't be written"}


class Failed(Exception):
    pass


def scenes():
    """{name: (scene file, stroke file)}; the name is FOLDER, or FOLDER.FILE where they differ."""
    found = {}
    for file in sorted(SCENES.glob("*/*.scene.json")):
        own, folder = file.name.removesuffix(".scene.json"), file.parent.name
        stroke = file.parent / (own + ".stroke.csv")
        found[folder if own == folder else folder + "." + own] = (file, stroke if stroke.exists() else file.parent / "stroke.csv")
    return found


def record(recorder, scene_file, path, ticks, out, rate_Hz=4000):
    """out.rec, out.forces. Fails when this machine does not replay its own run byte for byte."""
    run = subprocess.run([recorder, scene_file, str(path), str(ticks), str(rate_Hz), f"{out}.rec", f"{out}.forces"], capture_output=True, text=True)
    if run.returncode != 0:
        raise Failed(run.stderr.strip())
    return run.stdout.strip()


def cost_rows(recording):
    """What record_run wrote beside it: of each tick the estimate for each board of QEMU, then the terms; empty where the arm is not armed."""
    return [[] if line.startswith("-") else [float(word) for word in line.split()] for line in open(f"{recording}.cost")]


def worst(estimate):
    """BoardCost::worst() of board/sim/tick_cost.cpp."""
    return 6700 + 1.5 * estimate


def address_of(elf, symbol):
    for line in subprocess.run(["arm-none-eabi-nm", elf], capture_output=True, text=True, check=True).stdout.splitlines():
        fields = line.split()
        if fields[-1] == symbol:
            return fields[0]
    raise Failed(f"{elf} has no symbol {symbol}")


def replay(board, recording, plugin, folder):
    """Runs it with `folder` as working directory: forces.bin, and the instructions of every tick."""
    elf = BUILD / board / "bin" / f"replay-{board}.elf"
    counts = folder / "counts"
    if board == "zynqmp":
        assemble_stub(folder / "stub")
    command = [part.format(elf=elf, stub=folder / "stub", recording=pathlib.Path(recording).absolute()) for part in QEMU[board]]
    command += ["-display", "none", "-monitor", "none", "-serial", "none", "-nodefaults", "-semihosting-config", "enable=on,target=native",
                "-plugin", f"file={pathlib.Path(plugin).absolute()},begin={address_of(elf, 'tick_begin')},end={address_of(elf, 'tick_end')},csv={counts}"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=280)
    if run.returncode != 0:
        raise Failed(f"{board}: {ENDS.get(run.returncode, 'QEMU failed')} (exit code {run.returncode})\n{run.stderr}")
    return [int(line) for line in counts.read_text().split()]
