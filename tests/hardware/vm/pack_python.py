"""pack_python.py ARCHIVE.tar PROGRAM.py MODULE...: this interpreter's modules that PROGRAM.py and MODULEs load, and the shared libraries of those, as they lie in the file
system. For the virtual machine, which has the interpreter itself (run-vm.sh copies it like any program) and nothing else of Python."""

import importlib
import os
import re
import runpy
import subprocess
import sys
import tarfile

archive, program, *names = sys.argv[1:]
out = os.dup(1)
os.dup2(2, 1)  # some modules say what they lack
for name in names:
    importlib.import_module(name)
importlib.import_module("encodings.idna")
runpy.run_path(program)  # not as __main__: it only loads what it imports
os.dup2(out, 1)
files = {module.__file__ for name, module in list(sys.modules.items()) if name != "__main__" and getattr(module, "__file__", None) and os.path.isfile(module.__file__)}
compiled = {module.__cached__ for module in list(sys.modules.values()) if os.path.isfile(getattr(module, "__cached__", None) or "")}
libraries = set()
for extension in [file for file in files if file.endswith(".so")]:
    linked = subprocess.run(["ldd", extension], capture_output=True, text=True, check=True).stdout
    libraries |= set(re.findall(r"/\S+\.so\S*", linked))
with tarfile.open(archive, "w") as tar:
    for file in sorted(files | compiled):  # compiled, because the guest would take a minute for it
        tar.add(os.path.abspath(file))
    for library in sorted(libraries):
        tar.add(os.path.realpath(library), arcname="usr/lib/vm/" + os.path.basename(library))
