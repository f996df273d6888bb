#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Do the tests notice a broken sign? Breaks the headers in many small ways and sees which tests fail.

    tests/mutation/run.py [--work DIR] [--launcher CMD] [--only TEXT] [--table FILE]

All mutants of mutants.py are written into one scratch copy of the headers, each behind a switch

    before   →   (qdot_mutant == 17 ? (after) : (before))

which a test program reads from the environment (QDOT_MUTANT=17). So a test file is compiled once for all its mutants (-O0, no
sanitizer), and run once for each, after it has passed with none of them. A mutant is killed when the tests fail, crash or take
far longer. The table goes to docs/mutation.md with --table. Needs g++ (or CXX), Eigen, Catch2 2 and SUNDIALS where Debian has them.
"""

import argparse
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

from mutants import MUTANTS

root = pathlib.Path(__file__).resolve().parents[2]
SUNDIALS = ("cvode nvecserial sunlinsoldense sunlinsolband sunmatrixdense sunmatrixband sunnonlinsolnewton "
            "sunnonlinsolfixedpoint").split()
SLOW = 60  # seconds; tests take a few


def switched(number, before, after):
    if isinstance(after, tuple):
        after, type_ = after
        return f"(QDOT_MUTANT({number}) ? {type_}({after}) : {type_}({before}))"
    if before.endswith(";"):
        return f"{{ if (QDOT_MUTANT({number})) {{ {after} }} else {{ {before} }} }}"
    return f"(QDOT_MUTANT({number}) ? ({after}) : ({before}))"


def mutated(headers):
    """Writes the switches into the headers; two mutants of the same text are nested."""
    stale = []
    for number, (header, what, before, after, _) in enumerate(MUTANTS, 1):
        path = headers / header
        text = path.read_text()
        first = next(k for k, m in enumerate(MUTANTS, 1) if m[0] == header and m[2] == before)
        if first != number:  # the other mutant's switch is there: this one goes round it
            inner = switched(first, before, MUTANTS[first - 1][3])
            text = text.replace(inner, f"(QDOT_MUTANT({number}) ? ({after}) : {inner})")
        elif text.count(before) == 1:
            text = text.replace(before, switched(number, before, after))
        else:
            stale.append(f"{header}: {what}: found {text.count(before)} times: {before}")
        path.write_text(text)
    if stale:
        sys.exit("mutants.py no longer fits the headers:\n  " + "\n  ".join(stale))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--work", type=pathlib.Path, help="scratch directory to keep and use again")
    arguments.add_argument("--launcher", default="", help="command in front of every compilation and test run")
    arguments.add_argument("--only", default="", help="only the mutants whose test begins with this regular expression")
    arguments.add_argument("--table", type=pathlib.Path, help="write the results here, as a Markdown table, in place of the one that ends the file")
    asked = arguments.parse_args()

    work = asked.work or pathlib.Path(tempfile.mkdtemp(prefix="qdot-mutation-"))
    work.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(work / "include", ignore_errors=True)
    shutil.copytree(root / "include", work / "include")
    mutated(work / "include/qdot")
    (work / "switch.hpp").write_text(
        "#pragma once\n#include <cstdlib>\n"
        "inline const int qdot_mutant = [] { const char* s = std::getenv(\"QDOT_MUTANT\"); return s ? std::atoi(s) : 0; }();\n"
        "#define QDOT_MUTANT(n) (!__builtin_is_constant_evaluated() && ::qdot_mutant == n)\n"
        "#include <catch2_bridge.hpp>\n#include <Eigen/Dense>\n")

    launcher = shlex.split(asked.launcher)
    compiler = launcher + [os.environ.get("CXX", "g++"), "-std=c++20", "-O0", "-w", "-I", str(work), "-I", str(work / "include"),
                           "-I", str(root / "src"), "-I", str(root / "tests"), "-isystem", "/usr/include/eigen3",
                           f'-DQDOT_SOURCE_DIR="{root}"']

    def compiled(output, *inputs):
        subprocess.run([*compiler, *map(str, inputs), "-o", str(output)], check=True)

    if not (work / "main.o").exists():
        compiled(work / "main.o", "-c", root / "tests/catch2_main.cpp")
    compiled(work / "switch.hpp.gch", "-x", "c++-header", work / "switch.hpp")

    def passes(program, mutant):
        return subprocess.run([*launcher, "timeout", str(SLOW), str(program), "--abort", "~[long]"],
                              env={**os.environ, "QDOT_MUTANT": str(mutant)}, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL).returncode == 0

    chosen = [(k, m) for k, m in enumerate(MUTANTS, 1) if re.match(asked.only, m[4])]
    known = work / "results.json"  # of this and of earlier runs with --only
    results = json.loads(known.read_text()) if known.exists() else {}
    survived = 0
    for test in dict.fromkeys(m[4] for _, m in chosen):
        program = work / re.sub(r"\W", "_", test)
        libraries = [f"-lsundials_{name}" for name in SUNDIALS] + ["-lquadmath", "-lpthread"]
        compiled(program, "-include", work / "switch.hpp", root / "tests" / (test + ".test.cpp"), work / "main.o", *libraries)
        if not passes(program, 0):
            sys.exit(f"{test} fails without any mutant")
        for number, (header, what, *_) in ((k, m) for k, m in chosen if m[4] == test):
            killed = not passes(program, number)
            survived += not killed
            results[f"{header}: {what}"] = killed
            known.write_text(json.dumps(results))
            print(f"{'killed  ' if killed else 'SURVIVED'}  {header}: {what}  ({test})", flush=True)
    print(f"{len(chosen) - survived} killed, {survived} survived")
    if asked.table:
        word = {True: "killed", False: "**survived**", None: "not tried"}
        rows = [f"| `{m[0]}` | {m[1]} | `{m[4]}` | {word[results.get(f'{m[0]}: {m[1]}')]} |" for m in MUTANTS]
        text = asked.table.read_text() if asked.table.exists() else ""
        before = text[: text.find("| header |")] if "| header |" in text else text
        asked.table.write_text(before + "\n".join(["| header | mutant | test | result |", "|---|---|---|---|", *rows, ""]))
    sys.exit(survived > 0)


if __name__ == "__main__":
    main()
