#!/usr/bin/env python3
"""install.py OUTPUT: npm installs the packages with models of package.json, and OUTPUT/models gets their models, unpacked. What is installed
already is not installed again, so a second run needs no network."""
import gzip
import hashlib
import pathlib
import shutil
import subprocess
import sys

source = pathlib.Path(__file__).resolve().parent
output = pathlib.Path(sys.argv[1])
inputs = [source / name for name in ("package.json", "package-lock.json", ".npmrc", "install.py")]
wanted = hashlib.sha256(b"".join(path.read_bytes() for path in inputs)).hexdigest()
stamp = output / "installed"
if stamp.exists() and stamp.read_text() == wanted:
    sys.exit()

shutil.rmtree(output, ignore_errors=True)
output.mkdir(parents=True)
for path in inputs[:3]:
    shutil.copy(path, output)
# Without the packages' scripts: they make other forms of the same models.
subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], cwd=output, check=True)
packages = output / "node_modules"
for path in sorted(packages.rglob("*")):
    if not path.name.endswith((".stl", ".ply.gz")):
        continue
    model = output / "models" / path.relative_to(packages).with_name(path.name.removesuffix(".gz"))
    model.parent.mkdir(parents=True, exist_ok=True)
    data = path.read_bytes()
    model.write_bytes(gzip.decompress(data) if path.suffix == ".gz" else data)
shutil.rmtree(packages)
stamp.write_text(wanted)
