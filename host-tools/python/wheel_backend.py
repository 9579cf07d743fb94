"""Builds the wheel (PEP 517): CMake builds and installs the component `python`, which is zipped. Called by pip; pyproject.toml names it.

pip wheel . --config-settings build=FOLDER takes a folder that is configured for the calling interpreter already; default: build/wheel.
"""
import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import time
import tomllib
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
    version = re.search(r"^project\(.*VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)[1]
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    build = (config_settings or {}).get("build")
    if not build:
        build = SOURCE / "build/wheel"
        _run("cmake", "--preset", "python", "-B", build, "-DTHIMBLE_TESTS=OFF", f"-DPython_EXECUTABLE={sys.executable}")
        _run("cmake", "--build", build, "--target", "thimble_python")
    with tempfile.TemporaryDirectory() as place:
        _run("cmake", "--install", pathlib.Path(build).absolute(), "--strip", "--prefix", place, "--component", "python", stdout=subprocess.DEVNULL)
        root = next(pathlib.Path(place).glob("**/dist-packages"))
        files = {str(file.relative_to(root)): file.read_bytes() for file in sorted(root.rglob("*")) if file.is_file()}
    info = f"thimble-{version}.dist-info"
    files[f"{info}/METADATA"] = "".join((
        f"Metadata-Version: 2.1\nName: thimble\nVersion: {version}\nSummary: {project['description']}\nLicense: {project['license']['text']}\n",
        f"Requires-Python: {project['requires-python']}\n", *(f"Requires-Dist: {name}\n" for name in project["dependencies"]))).encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: thimble\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{info}/LICENSE"] = (SOURCE / "LICENSE").read_bytes()
    rows = [f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip('=')},{len(data)}\n"
            for name, data in files.items()]
    files[f"{info}/RECORD"] = "".join([*rows, f"{info}/RECORD,,\n"]).encode()

    name = f"thimble-{version}-{tag}.whl"
    written = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", 0)) or None)[:6]
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, max(written, (1980, 1, 1, 0, 0, 0)))
            entry.external_attr = (0o755 if path.endswith(".so") else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return name


def _run(*command, **options):
    subprocess.run([*map(str, command)], check=True, cwd=SOURCE, **options)
