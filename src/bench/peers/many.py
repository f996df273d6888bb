#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Time of many motions to reach an error: qdot's lanes beside heyoka's batch mode, in one run, one thread each.

    src/bench/peers/many.py [--work DIR] [--flags "-O3 -march=native"] [--rounds N] [--offline]

Both go through tolerances in turn; for each error the time is interpolated between the two tolerances beside it, in logarithms, from the least of all rounds.
heyoka is installed by pip into DIR (default build/peers). Ratios above 1 are in favour of qdot.
"""
import math
import os
import sys

import peers
from motion import options_from, parser_for, program
from peers import Absent, package_python, ran, source


def at_error(points, error):
    """Time at which the error is reached; points of (error, time)."""
    points = sorted(points)
    for (fine, slow), (coarse, fast) in zip(points, points[1:]):
        if fine <= error <= coarse and fine < coarse:
            share = math.log(error / fine) / math.log(coarse / fine)
            return math.exp((1 - share) * math.log(slow) + share * math.log(fast))
    return None


def main():
    parser = parser_for(__doc__, "heyoka")
    parser.add_argument("--rounds", type=int, default=2)
    options = options_from(parser)

    own = program(options, "many_qdot")
    problems = os.path.join(options.work, "many_problems.jsonl")
    with open(problems, "w", encoding="utf-8") as file:
        file.write(ran([own, "problems"], "fails"))
    commands = {"qdot": [own], "heyoka": [package_python(options, "heyoka"), source("many_heyoka.py"), problems]}
    found = {}
    for _ in range(options.rounds):
        for who, command in commands.items():
            for line in ran(command, "fails", timeout=3600).splitlines():
                problem, tolerance, microseconds, error = line.split(";")
                key = (problem, who, float(tolerance))
                found[key] = min(found.get(key, (math.inf, 0.0)), (float(microseconds), float(error)))
    print("| problem | error | qdot, µs for a motion | heyoka, µs | times qdot |\n|---|---|---|---|---|")
    for problem in dict.fromkeys(key[0] for key in found):
        for error in (1e-5, 1e-7, 1e-9):
            times = [at_error([(e, t) for (p, w, _), (t, e) in found.items() if p == problem and w == who and e > 0], error) for who in commands]
            if all(times):
                print(f"| {problem} | {error:.0e} | {times[0]:.1f} | {times[1]:.1f} | {times[1] / times[0]:.2f} |")


if __name__ == "__main__":
    try:
        main()
    except Absent as problem:
        sys.exit(f"many.py: {problem}")
