#!/usr/bin/env python3
"""portability.py [--write]: what each module needs of the system, for docs/portability.md, found by a compiler. It takes the configured build of the
preset `portable`, and prints the table of modules; with --write it is written there.

Headers: those of libc6-dev and linux-libc-dev that are none of POSIX.1-2017. Names: each source that includes a header of the system is parsed as a
POSIX.1-2008 program (_XOPEN_SOURCE=700 without _GNU_SOURCE), and what its text then lacks is listed. A constant that glibc declares in any mode, such as SOCK_CLOEXEC, is not found.
"""

import functools
import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BUILD = ROOT / "build/portable"
PAGE = ROOT / "docs/portability.md"
BEGIN, END = "<!-- modules begin -->\n", "\n<!-- modules end -->"
MODULES = ["kinematics", "control", "firmware", *(f"board/{name}" for name in ("common", "files", "walk", "sim", "posix")),
           *(f"host-tools/{name}" for name in ("keys", "compiler", "arms", "client", "commission", "can_tools", "files", "lab", "sweep", "viewer", "cli"))]
POSIX = {name + ".h" for name in """aio arpa/inet cpio dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen monetary mqueue ndbm net/if netdb
    netinet/in netinet/tcp nl_types poll pthread pwd regex sched search semaphore signal spawn strings stropts sys/ipc sys/mman sys/msg sys/resource
    sys/select sys/sem sys/shm sys/socket sys/stat sys/statvfs sys/time sys/times sys/types sys/uio sys/un sys/utsname sys/wait syslog tar termios time trace
    ulimit unistd utime utmpx wordexp""".split()}  # without those that C++ has
MISSING = re.compile(r"(?:undeclared identifier|unknown type name|no (?:member|type) named) '(?!__builtin_)(\w+)'")  # Clang's own names are none of the system


@functools.cache
def flags():
    """What any source of the build is compiled with, and its compiler."""
    found = {}
    for command in json.loads((BUILD / "compile_commands.json").read_text()):
        words = shlex.split(command["command"])
        compiler = next(word for word in words if "clang++" in word)
        for word, after in zip(words, words[1:]):
            if re.match("-(I|D)", word):
                found[word] = [word]
            elif word == "-isystem":
                found[after] = [word, after]
    return compiler, [word for words in found.values() for word in words]


@functools.cache
def package_of(header):
    """The Debian package of a header; "" for those of the C++ library and of the build."""
    places = [Path("/usr/include"), *Path("/usr/include").glob("*-linux-gnu"), *(Path(word) for word in flags()[1] if word.startswith("/"))]
    if any((place / header).exists() for place in Path("/usr/lib").glob("llvm-22/include/c++/v1")):
        return ""
    file = next((place / header for place in places if (place / header).exists()), None)
    if not file or BUILD in file.parents:
        return ""
    return subprocess.run(["dpkg-query", "--search", file.resolve()], capture_output=True, text=True, check=True).stdout.split(":")[0]


@functools.cache
def includes(file):
    return set(re.findall(r"^#include <(.*?)>", file.read_text(), re.M))


def of_system(header):
    return package_of(header) in ("libc6-dev", "linux-libc-dev")


def missing_names(file):
    compiler, words = flags()
    told = subprocess.run([compiler, "-xc++", "-std=c++20", "-stdlib=libc++", "-U_GNU_SOURCE", "-D_XOPEN_SOURCE=700", "-fsyntax-only", "-ferror-limit=0", "-w",
                           *words, str(file)], cwd=BUILD, capture_output=True, text=True).stderr
    return {name[1] for path, message in re.findall(r"^(\S+?):\d+:\d+: (?:fatal )?error: (.*)$", told, re.M)
            if Path(path).resolve() == file and (name := MISSING.search(message))}


def table():
    rows = ["| module | its sources need | headers beyond POSIX | names beyond POSIX | libraries |", "|---|---|---|---|---|"]
    for module in MODULES:
        files = [file for suffix in ("*.cpp", "*.h") for file in (ROOT / module).rglob(suffix) if "node_modules" not in file.parts]
        headers = {header for file in files for header in includes(file)}
        ours = {header for header in headers if of_system(header)}
        beyond = sorted(ours - POSIX)
        lacking = sorted({name for file in files if any(map(of_system, includes(file))) for name in missing_names(file)})
        needs = "Linux" if any(header.startswith("linux/") for header in beyond) else "POSIX" if ours else "C++"
        others = sorted({package_of(header).removesuffix("-dev") for header in headers} - {"", "libc6", "linux-libc"})
        cells = [module, needs, *(", ".join(f"`{it}`" for it in names_) for names_ in (beyond, lacking)), ", ".join(others)]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def in_page():
    return PAGE.read_text().split(BEGIN)[1].split(END)[0]


def write(text):
    PAGE.write_text(PAGE.read_text().replace(in_page(), text))


if __name__ == "__main__":
    text = table()
    print(text)
    if "--write" in sys.argv:
        write(text)
