"""An emulated ZCU102 whose Cortex-R5F runs board/zynqmp, with the simulated arm and a second node on its CAN bus."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "end_to_end"))
from rig import BIN, Rig, figure  # noqa: E402, F401
from stub import assemble_stub, tool  # noqa: E402

RAM_BYTES = 1 << 30
FLASH_BYTES = 64 << 20
IMAGE = Path(os.environ["THIMBLE_ZYNQMP_IMAGE"])
# Time goes by as instructions do, 4 ns each, so a busy machine delays no tick.
CLOCK = ["-icount", "shift=2,sleep=off"]


class Board:
    """Runs until stop(); the flash is a file of the caller's. more: options of QEMU's, in place of those for the core that only starts the
    Cortex-R5F; kernel(folder) makes what that core runs."""

    def __init__(self, folder, flash, kernel=None, console="null", more=()):
        qemu = [tool("setpriv"), "--pdeathsig", "KILL", tool("qemu-system-aarch64")]  # it ends with this process
        self.folder = Path(tempfile.mkdtemp(dir=folder))
        memory = self.folder / "memory"
        with open(memory, "wb") as file:
            file.truncate(RAM_BYTES)
        stub = self.folder / "stub"
        (kernel or assemble_stub)(stub)
        qtest = self.folder / "qtest"
        self.peer = subprocess.Popen([BIN / "arm_peer", memory, "4000", qtest], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                     text=True, bufsize=1)
        self.qemu = None
        self.expect_line("arm")
        self.console = self.folder / "console"
        self.qemu = subprocess.Popen(
            [*qemu, "-M", "xlnx-zcu102,canbus0=bus,canbus1=bus,memory-backend=ram", "-object", "can-bus,id=bus", "-object",
             f"memory-backend-file,id=ram,size={RAM_BYTES},mem-path={memory},share=on", "-smp", "5", "-m", "1G", "-display", "none",
             "-monitor", "none", "-nodefaults", "-audiodev", "none,id=none", *CLOCK, "-qtest", f"unix:{qtest},server=on,wait=off",
             "-qtest-log", "none", "-serial", console, "-chardev", f"pty,id=uart,logfile={self.console}", "-serial", "chardev:uart",
             "-drive", f"if=mtd,index=2,file={flash},format=raw", "-kernel", stub, "-device", f"loader,file={IMAGE}", *more],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said = ""
        for line in self.qemu.stdout:
            said += line
            if found := re.search(r"redirected to (/dev/pts/\d+)", line):
                self.uart = "slcan:" + found[1]
                break
        else:
            raise AssertionError("QEMU does not start: " + said)
        self.wait_for_text("Thimble")

    def join_bus(self):
        """The second node on the bus is this process's; nothing else may use that controller."""
        self.uri = self.ask("bus")
        return self

    def wait_for_text(self, text, seconds=30):
        """Until the board has written this on its UART."""
        end = time.monotonic() + seconds
        while text not in self.console.read_text(errors="replace"):
            if self.qemu.poll() is not None or time.monotonic() > end:
                raise AssertionError(f"the board does not say {text!r}, but {self.console.read_text(errors='replace')!r}")
            time.sleep(0.05)

    def expect_line(self, wanted):
        line = self.peer.stdout.readline().strip()
        if line != wanted:
            raise AssertionError(f"arm_peer says {line!r}, not {wanted!r}")

    def ask(self, command):
        self.peer.stdin.write(command + "\n")
        answer = self.peer.stdout.readline().strip()
        if not answer:
            raise AssertionError(f"arm_peer has ended at {command!r}")
        return answer

    def tell(self, command):
        if self.ask(command) != "ok":
            raise AssertionError(command)

    def stop(self):
        for process in (self.peer, self.qemu):
            if process is not None and process.poll() is None:
                process.kill()
            if process is not None:
                process.wait(timeout=20)
        for pipe in (self.peer.stdin, self.peer.stdout, self.qemu and self.qemu.stdout):
            if pipe is not None:
                pipe.close()
        shutil.rmtree(self.folder, ignore_errors=True)


class ZynqmpRig(Rig):
    def run_thimble(self, *arguments, timeout=60):
        """The board is slower than time: its answers may come late."""
        patience = ["--timeout", "20"] if "--device" in arguments else []
        return super().run_thimble(*arguments, *patience, timeout=timeout)

    def flash(self):
        """An erased chip."""
        file = self.folder / f"flash-{self.id()}"
        with open(file, "wb") as out:
            out.write(b"\xff" * FLASH_BYTES)
        return file

    def board(self, flash=None):
        board = Board(self.folder, flash or self.flash())
        self.addCleanup(board.stop)
        return board.join_bus()

    def touch(self, board, uri=None):
        """Homes, arms and presses the fingertip 5 mm into the floor."""
        uri = uri or board.uri
        self.ok("home", "--device", uri)
        board.tell("hand 0 0 0.01")
        self.ok("arm", "--device", uri)
        self.rest(board)  # a contact that begins during the ramp stays soft
        board.tell("hand 0 0 -0.01")
        self.wait_for(lambda: self.force_N(uri) > 1.0, "a force of the floor")

    def rest(self, board):
        """A second for the arm: the ramp is over, and the hand has come to rest."""
        steps = lambda: int(board.ask("state").split()[6])
        end = steps() + 4000
        self.wait_for(lambda: steps() >= end, "the arm to move on", seconds=60)

    def force_N(self, uri):
        """The floor's on the fingertip, upwards, of the newest record."""
        return float(self.ok("monitor", "--count", "1", "--device", uri).out.splitlines()[-1].split()[6])

    def wait_for(self, condition, what, seconds=30):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, "waited for " + what)
