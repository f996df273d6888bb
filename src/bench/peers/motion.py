#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Time to reach an error: qdot from T and V beside its peers, in one run.

    src/bench/peers/motion.py [--work DIR] [--json FILE] [--flags "-O3 -march=native"] [--only PROBLEM] [--rounds N] [--offline]

Every peer searches its cheapest tolerance for the errors of src/bench/motion_problems.hpp and times it; the peers take turns, and the least
of all rounds counts. heyoka and SciPy are installed by pip into DIR (default build/peers), the headers of Boost by apt where they are missing.
A peer that cannot be had is reported as absent, with the reason. Ratios above 1 are in favour of qdot.
"""
import argparse
import glob
import json
import os
import sys

import peers
from peers import Absent, package_python, ran, source

columns = ["heyoka.lagrangian", "heyoka, by hand", "odeint rkf78", "odeint dopri5", "cvode adams", "scipy DOP853"]


def program(options, name, *flags):
    path = os.path.join(options.work, name)
    repository = os.path.dirname(peers.src)
    if not (options.measure_only and os.path.exists(path)):
        ran([options.compiler, "-std=c++20", *options.flags.split(), "-DNDEBUG", "-w", f"-I{peers.src}", f"-I{repository}/include", "-isystem",
             options.eigen, source(f"{name}.cxx"), "-o", path, *flags], "does not build", timeout=1800)
    return path


def boost(options):
    if os.path.exists("/usr/include/boost/numeric/odeint.hpp"):
        return []
    include = os.path.join(options.work, "boost/usr/include")
    if not os.path.exists(include):
        if options.offline:
            raise Absent("not installed, and --offline")
        ran(["apt-get", "download", "libboost1.74-dev"], "apt cannot download libboost1.74-dev", cwd=options.work, timeout=900)
        package = glob.glob(os.path.join(options.work, "libboost1.74-dev_*.deb"))[0]
        ran(["dpkg", "-x", package, os.path.join(options.work, "boost")], "cannot be unpacked")
    return ["-isystem", include]


def parsed(text):
    for line in text.splitlines():
        problem, error, method, setting, reached, microseconds = line.split(";")
        yield {"problem": problem, "error": float(error), "method": method, "setting": float(setting), "reached": float(reached),
               "microseconds": float(microseconds)}


def number(x):
    return f"{x:.0f}" if x >= 100 else f"{x:.1f}" if x >= 10 else f"{x:.2f}"


def parser_for(description, packages):
    """What all programs that measure peers are told."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", default=os.path.join(os.path.dirname(peers.src), "build/peers"), help="where things are built")
    parser.add_argument("--python", help=f"Python of an environment with {packages}, instead of DIR/venv")
    parser.add_argument("--eigen", default="/usr/include/eigen3", help="include directory of Eigen")
    parser.add_argument("--compiler", default="g++")
    parser.add_argument("--flags", default="-O3 -march=native")
    parser.add_argument("--offline", action="store_true", help="use only what is installed")
    parser.add_argument("--measure-only", action="store_true", help="take programs as they were built before")
    return parser


def options_from(parser):
    options = parser.parse_args()
    options.work = os.path.abspath(options.work)
    os.makedirs(options.work, exist_ok=True)
    options.python = os.path.abspath(options.python) if options.python else os.path.join(options.work, "venv/bin/python")
    return options


def main():
    parser = parser_for(__doc__, "heyoka and scipy")
    parser.add_argument("--only", default="", help="problems whose name begins so")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", help="write the rows here")
    parser.add_argument("--build-only", action="store_true", help="build, install and measure nothing")
    options = options_from(parser)

    commands, absent = [("qdot", [program(options, "motion_qdot")])], {}
    problems = os.path.join(options.work, "problems.jsonl")
    with open(problems, "w", encoding="utf-8") as file:
        file.write(ran([program(options, "motion_problems")], "fails"))
    others = [("heyoka", lambda: [package_python(options, "heyoka"), source("motion_heyoka.py"), problems]),
              ("odeint", lambda: [program(options, "motion_odeint", *boost(options))]),
              ("cvode", lambda: [program(options, "motion_cvode", "-lsundials_cvode", "-lsundials_nvecserial")]),
              ("scipy", lambda: [package_python(options, "scipy"), source("motion_scipy.py"), problems])]
    for name, command in others:
        try:
            commands.append((name, command()))
        except Absent as reason:
            absent[name] = str(reason)
    if options.build_only:
        return
    best = {}
    for turn in range(options.rounds):
        for name, command in commands:
            if name == "scipy" and turn > 0:
                continue  # a hundred times slower than the others
            for row in parsed(ran([*command, *([options.only] if options.only else [])], "fails", timeout=3600)):
                key = row["problem"], row["error"], row["method"]
                if key not in best or row["microseconds"] < best[key]["microseconds"]:
                    best[key] = row
    rows = list(best.values())
    own = ("dop853", "dopri5", "taylor")
    print(f"| problem | error | qdot, µs | with | {' | '.join(own)} | {' | '.join(columns)} |")
    print("|---" * (4 + len(own) + len(columns)) + "|")
    for problem, error in dict.fromkeys((row["problem"], row["error"]) for row in rows):
        times = {row["method"]: row["microseconds"] for row in rows if (row["problem"], row["error"]) == (problem, error)}
        qdot = {method: times[method] for method in own if method in times}
        if not qdot:
            continue
        method = min(qdot, key=qdot.get)
        cells = [number(times[m] / qdot[method]) if m in times else "–" for m in (*own, *columns)]
        print(f"| {problem} | {error:.0e} | {number(qdot[method])} | {method} | {' | '.join(cells)} |")
    for name, reason in absent.items():
        print(f"\n{name}: absent, {reason}")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"flags": options.flags, "rows": rows, "absent": absent}, file, indent=2, ensure_ascii=False)


if __name__ == "__main__":
    try:
        main()
    except Absent as problem:
        sys.exit(f"motion.py: {problem}")
