"""Two operating worlds on one emulated chip: Debian's kernel with its CAN driver on a Cortex-A53, the image of board/zynqmp on the Cortex-R5F, and
a session from the one to the other over the emulated bus by way of SocketCAN."""

import os
import shutil
import subprocess
import time
import unittest
from pathlib import Path

from stub import assemble_stub, tool
from zynqmp_rig import Board, ZynqmpRig, figure

HERE = Path(__file__).resolve().parent
CLIENT = Path(os.environ["THIMBLE_CAN_CLIENT"])
KERNEL_AT, TREE_AT, INITRAMFS_AT = 0x02000000, 0x0E000000, 0x10000000
INIT = """#!/bin/busybox sh
/bin/busybox mount -t proc none /proc
/bin/busybox mount -t sysfs none /sys
for module in can can-dev can-raw xilinx_can; do /bin/busybox insmod /modules/$module.ko || echo "guest: no $module"; done
/can_client can0 1000000 /image
echo "guest: exit $?"
while :; do /bin/busybox sleep 1000; done
"""


class Linux(ZynqmpRig):
    def initramfs(self, base, image):
        root = self.folder / "root"
        for folder in ("bin", "dev", "proc", "sys", "modules"):
            (root / folder).mkdir(parents=True)
        shutil.copy(base / "busybox", root / "bin/busybox")
        for module in (base / "modules").iterdir():
            shutil.copy(module, root / "modules")
        shutil.copy(CLIENT, root / "can_client")
        shutil.copy(image, root / "image")
        (root / "init").write_text(INIT)
        (root / "init").chmod(0o755)
        file = self.folder / "initramfs"
        with open(file, "wb") as out:
            names = subprocess.run(["find", "."], cwd=root, capture_output=True, check=True).stdout
            subprocess.run([tool("cpio"), "-o", "-H", "newc", "--quiet"], cwd=root, input=names, stdout=out, check=True)
        return file

    def test_a_session_over_socketcan(self):
        base = Path(subprocess.run([HERE / "prepare-linux.sh"], capture_output=True, text=True, check=True).stdout.strip())
        image = self.folder / "image"
        image.write_bytes(self.image(self.plane_scene()).read_bytes()[:-8])  # without its trailer: what is sent
        initramfs = self.initramfs(base, image)
        tree = self.folder / "tree"
        subprocess.run([tool("dtc"), "-q", "-O", "dtb", "-o", tree, HERE / "zcu102.dts"], check=True)
        console = self.folder / "linux"
        loads = [(base / "Image", KERNEL_AT), (tree, TREE_AT), (initramfs, INITRAMFS_AT)]
        more = [word for file, at in loads for word in ("-device", f"loader,file={file},addr={at:#x},force-raw=on")]
        board = Board(self.folder, self.flash(), console=f"file:{console}", more=more,
                      kernel=lambda stub: assemble_stub(stub, f"-DLINUX={KERNEL_AT:#x}", f"-DDEVICE_TREE={TREE_AT:#x}"))
        self.addCleanup(board.stop)
        started = time.monotonic()

        def wait_for(text, seconds=200):
            end = time.monotonic() + seconds
            while text not in (said := console.read_text(errors="replace")):
                self.assertNotIn("guest: exit", said, said)
                self.assertLess(time.monotonic(), end, said)
                time.sleep(0.1)

        wait_for("homed")
        board.tell("hand 0 0 0.01")
        wait_for("armed")
        board.tell("hand 0 0 -0.01")
        end = time.monotonic() + 200
        while "guest: exit" not in (said := console.read_text(errors="replace")):
            self.assertLess(time.monotonic(), end, said)
            time.sleep(0.1)
        self.assertIn("guest: exit 0", said)
        self.assertIn("board zynqmp", said)
        self.assertIn("mode ready", said)
        figure("%.0f s; the guest: %s" % (time.monotonic() - started, "; ".join(said.splitlines()[-7:])))


if __name__ == "__main__":
    unittest.main()
