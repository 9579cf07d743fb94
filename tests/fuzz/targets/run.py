#!/usr/bin/env python3
"""run.py TARGET --seconds N [--fresh] : runs a fuzz target from its corpus, tests/fuzz/corpus/NAME, and prints executions and edges.

  --fresh   another seed than the last time; what it finds is added to build/.../fuzz/NAME, where the next run begins. Without it the seed
            is 1 and nothing is kept.
  --merge   instead: the corpus anew, few inputs of it and of what was found that take the same edges.

An input that fails is kept in build/.../fuzz, and printed in base64: `base64 -d >INPUT`, then `TARGET INPUT` runs it alone.
"""
import argparse
import base64
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FUZZ = pathlib.Path(__file__).resolve().parent.parent
# Potential fields of many cells take longest: 10 s of processor time under the sanitizers, 0.4 s without. None needs half of this memory.
LIMITS = ["-timeout=300", "-rss_limit_mb=1024", "-malloc_limit_mb=512"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("target", type=pathlib.Path)
    arguments.add_argument("--seconds", type=int, default=60)
    arguments.add_argument("--fresh", action="store_true")
    arguments.add_argument("--merge", action="store_true")
    chosen = arguments.parse_args()
    name = chosen.target.name.removesuffix("_fuzz")
    corpus = FUZZ / "corpus" / name
    kept = chosen.target.resolve().parent.parent / "fuzz"
    found = kept / name
    found.mkdir(parents=True, exist_ok=True)
    command = [chosen.target, *LIMITS, f"-artifact_prefix={kept}/{name}-"]
    if chosen.merge:
        with tempfile.TemporaryDirectory() as small:
            subprocess.run([*command, "-set_cover_merge=1", "-use_counters=0", small, corpus, found], check=True)
            shutil.rmtree(corpus)
            shutil.copytree(small, corpus)
        return 0

    dictionary = FUZZ / "dictionaries" / f"{name}.dict"
    if dictionary.exists():
        command.append(f"-dict={dictionary}")
    command += ["-print_final_stats=1", f"-max_total_time={chosen.seconds}"]
    with tempfile.TemporaryDirectory() as forgotten:
        folders = [found, corpus] if chosen.fresh else ["-seed=1", forgotten, corpus]
        run = subprocess.run([*command, *folders], text=True, stderr=subprocess.PIPE, errors="replace")
    if run.returncode != 0:
        print(run.stderr[-20000:])
        for kept_input in re.findall(r"Test unit written to (.*)", run.stderr):
            print(kept_input, base64.b64encode(pathlib.Path(kept_input).read_bytes()).decode())
        return run.returncode
    executions = re.search(r"stat::number_of_executed_units:\s*(\d+)", run.stderr)[1]
    edges = re.findall(r"cov: (\d+)", run.stderr)[-1]
    print(f"{name}: {executions} executions, {edges} edges, {len(list(corpus.iterdir()))} inputs in the corpus")
    return 0


if __name__ == "__main__":
    sys.exit(main())
