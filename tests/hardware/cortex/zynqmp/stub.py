"""What the first Cortex-A53 of an emulated ZCU102 runs: it starts the Cortex-R5F (stub.S)."""
import shutil
import subprocess
from pathlib import Path


def tool(name):
    """Its path; a machine without it fails."""
    path = shutil.which(name)
    if path is None:
        raise AssertionError(name + " is missing: scripts/packages.sh names the packages of the tests")
    return path


def assemble_stub(output, *options):
    subprocess.run([tool("aarch64-linux-gnu-gcc"), "-nostdlib", "-static", "-Wl,-Ttext=0x08000000,--build-id=none", *options,
                    Path(__file__).with_name("stub.S"), "-o", output], check=True)
