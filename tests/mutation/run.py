#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Do the tests notice a broken sign? Breaks the headers in many small ways and sees which tests fail.

    tests/mutation/run.py [--work DIR] [--launcher CMD] [--only TEXT] [--table FILE] [--fits]

The mutants of a test file are written into a scratch copy of the headers, each behind a switch

    before   →   (qdot_mutant == 17 ? (after) : (before))

which a test program reads from the environment (QDOT_MUTANT=17). So a test file is compiled once for all its mutants (no
sanitizer; -O0, and -O2 for those of OPTIMIZED), and run once for each, after it has passed with none of them. A mutant is killed
when the tests fail, crash or take far longer. The table goes to docs/lab/mutation.md with --table. Needs g++ (or CXX), Eigen, Catch2 2
and SUNDIALS where Debian has them.
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

from mutants import MUTANTS as PLAIN, OPTIMIZED

MUTANTS = PLAIN + OPTIMIZED
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


def optimization(number):
    return "-O0" if number <= len(PLAIN) else "-O2"


def require_that_all_fit():
    stale = []
    for header, what, before, _, _ in MUTANTS:
        found = (root / "include/qdot" / header).read_text().count(before)
        if found != 1:
            stale.append(f"{header}: {what}: found {found} times: {before}")
    if stale:
        sys.exit("mutants.py no longer fits the headers:\n  " + "\n  ".join(stale))


def mutated(headers, mutants):
    """Writes the switches of some mutants into the headers; two of the same text are nested."""
    written = {}  # by header and text
    for number, (header, _, before, after, _) in mutants:
        path = headers / header
        inner = written.get((header, before), before)
        outer = switched(number, before, after) if inner == before else f"(QDOT_MUTANT({number}) ? ({after}) : {inner})"
        path.write_text(path.read_text().replace(inner, outer))
        written[header, before] = outer


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--work", type=pathlib.Path, help="scratch directory to keep and use again")
    arguments.add_argument("--launcher", default="", help="command in front of every compilation and test run")
    arguments.add_argument("--only", default="", help="only the mutants whose test begins with this regular expression")
    arguments.add_argument("--fits", action="store_true", help="only see that what is to be broken stands in the headers, once each")
    arguments.add_argument("--table", type=pathlib.Path, help="write the results here, as a Markdown table, in place of the one that ends the file")
    asked = arguments.parse_args()

    require_that_all_fit()
    if asked.fits:
        return
    work = asked.work or pathlib.Path(tempfile.mkdtemp(prefix="qdot-mutation-"))
    work.mkdir(parents=True, exist_ok=True)
    (work / "switch.hpp").write_text(
        "#pragma once\n#include <cstdlib>\n"
        "inline const int qdot_mutant = [] { const char* s = std::getenv(\"QDOT_MUTANT\"); return s ? std::atoi(s) : 0; }();\n"
        "#define QDOT_MUTANT(n) (!__builtin_is_constant_evaluated() && ::qdot_mutant == n)\n"
        "#include <catch2_bridge.hpp>\n#include <Eigen/Dense>\n")

    launcher = shlex.split(asked.launcher)
    compiler = launcher + [os.environ.get("CXX", "g++"), "-std=c++20", "-w", "-I", str(work), "-I", str(work / "include"),
                           "-I", str(root / "src"), "-I", str(root / "tests"), "-isystem", "/usr/include/eigen3",
                           f'-DQDOT_SOURCE_DIR="{root}"']

    def compiled(output, *inputs):
        subprocess.run([*compiler, *map(str, inputs), "-o", str(output)], check=True)

    if not (work / "main.o").exists():
        compiled(work / "main.o", "-O0", "-c", root / "tests/catch2_main.cpp")
    shutil.rmtree(work / "switch.hpp.gch", ignore_errors=True)
    (work / "switch.hpp.gch").mkdir()

    def passes(program, mutant):
        return subprocess.run([*launcher, "timeout", str(SLOW), str(program), "--abort", "~[long]"],
                              env={**os.environ, "QDOT_MUTANT": str(mutant)}, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL).returncode == 0

    chosen = [(k, m) for k, m in enumerate(MUTANTS, 1) if re.match(asked.only, m[4])]
    known = work / "results.json"  # of this and of earlier runs with --only
    results = json.loads(known.read_text()) if known.exists() else {}
    survived = 0
    for test, level in dict.fromkeys((m[4], optimization(k)) for k, m in chosen):
        mutants = [(k, m) for k, m in chosen if (m[4], optimization(k)) == (test, level)]
        shutil.rmtree(work / "include", ignore_errors=True)
        shutil.copytree(root / "include", work / "include")
        mutated(work / "include/qdot", mutants)
        program = work / (re.sub(r"\W", "_", test) + level)
        libraries = [f"-lsundials_{name}" for name in SUNDIALS] + ["-lquadmath", "-lpthread"]
        if not (work / "switch.hpp.gch" / level).exists():
            compiled(work / "switch.hpp.gch" / level, level, "-x", "c++-header", work / "switch.hpp")
        compiled(program, level, "-include", work / "switch.hpp", root / "tests" / (test + ".test.cpp"), work / "main.o", *libraries)
        if not passes(program, 0):
            sys.exit(f"{test} at {level} fails without any mutant")
        for number, (header, what, *_) in mutants:
            killed = not passes(program, number)
            survived += not killed
            results[f"{header}: {what}"] = killed
            known.write_text(json.dumps(results))
            print(f"{'killed  ' if killed else 'SURVIVED'}  {header}: {what}  ({test})", flush=True)
    print(f"{len(chosen) - survived} killed, {survived} survived")
    if asked.table:
        text = asked.table.read_text() if asked.table.exists() else ""
        earlier = dict(re.findall(r"^(\| .* \|) (\S.*) \|$", text, re.MULTILINE))  # of what did not run here
        word = {True: "killed", False: "**survived**"}
        rows = []
        for m in MUTANTS:
            row = f"| `{m[0]}` | {m[1]} | `{m[4]}` |"
            result = results.get(f"{m[0]}: {m[1]}")
            rows.append(f"{row} {earlier.get(row, 'not tried') if result is None else word[result]} |")
        rows.sort(key=lambda row: re.sub("[`|]", "", row).lower().split())
        before = text[: text.find("| header |")] if "| header |" in text else text
        asked.table.write_text(before + "\n".join(["| header | mutant | test | result |", "|---|---|---|---|", *rows, ""]))
    sys.exit(survived > 0)


if __name__ == "__main__":
    main()
