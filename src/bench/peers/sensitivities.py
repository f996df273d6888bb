#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Time of a run with its 4 x 4 derivatives by the start, to reach an error of these: qdot beside CVODES, heyoka and CasADi, in one run.

    src/bench/peers/sensitivities.py [--work DIR] [--flags "-O3 -march=native"] [--rounds N] [--offline]

The double pendulum, 3 s from 1.7 rad, against digits of extended precision. Each goes through tolerances in turn; for each error the time is interpolated
between the two tolerances beside it, in logarithms, from the least of all rounds. heyoka and CasADi are installed by pip into DIR (default build/peers).
Ratios above 1 are in favour of qdot; "runs" is the time by that of the same tool's run without derivatives, with the same tolerance.
"""
import math
import sys

from many import at_error
from motion import options_from, parser_for, program
from peers import Absent, package_python, ran, source


def main():
    parser = parser_for(__doc__, "heyoka and casadi")
    parser.add_argument("--rounds", type=int, default=2)
    options = options_from(parser)
    found, absent = {}, {}
    tools = {"qdot": lambda: [program(options, "sensitivities_qdot")],
             "cvodes": lambda: [program(options, "sensitivities_cvodes", "-lsundials_cvodes", "-lsundials_nvecserial")],
             "heyoka": lambda: [package_python(options, "heyoka"), source("sensitivities_heyoka.py")],
             "casadi": lambda: [package_python(options, "casadi"), source("sensitivities_casadi.py")]}
    commands = {}
    for tool, command in tools.items():
        try:
            commands[tool] = command()
        except Absent as reason:
            absent[tool] = str(reason)
    for _ in range(options.rounds):
        for tool, command in commands.items():
            for line in ran(command, "fails", timeout=3600).splitlines():
                _, tolerance, microseconds, error, plain = line.split(";")
                before = found.get((tool, tolerance), (math.inf, 0.0, math.inf))
                found[tool, tolerance] = (min(before[0], float(microseconds)), float(error), min(before[2], float(plain)))
    print("| error of Φ | tool | µs | times qdot | runs |\n|---|---|---|---|---|")
    for error in (1e-5, 1e-7, 1e-9):
        own = None
        for tool in commands:
            rows = [row for (who, _), row in found.items() if who == tool]
            time, plain = (at_error([(e, row) for row, e in pairs], error) for pairs in ([(r[0], r[1]) for r in rows], [(r[2], r[1]) for r in rows]))
            own = own or time
            if time:
                print(f"| {error:.0e} | {tool} | {time:.0f} | {time / own:.1f} | {time / plain:.1f} |")
    for tool, reason in absent.items():
        print(f"\n{tool}: absent, {reason}")


if __name__ == "__main__":
    try:
        main()
    except Absent as problem:
        sys.exit(f"sensitivities.py: {problem}")
