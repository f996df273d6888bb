# SPDX-License-Identifier: MIT
#
# motion_scipy.py FILE [PROBLEM]: SciPy's DOP853 on equations derived by hand in NumPy, on the problems of FILE; lines as motion_qdot's.
import json
import sys
import time
from math import cos, sin

import numpy as np
from scipy.integrate import solve_ivp


def rates_of(problem):
    n = problem["n"]
    if problem["name"].startswith("kepler"):
        def plane(t, y):
            k = -(y[0] * y[0] + y[1] * y[1]) ** -1.5
            return y[2], y[3], k * y[0], k * y[1]
        return plane
    if n == 2:
        def double(t, y):
            a, b, u, v = y
            s, c = sin(a - b), cos(a - b)
            p, r = -v * v * s - 2.0 * 9.81 * sin(a), u * u * s - 9.81 * sin(b)
            i = 1.0 / (2.0 - c * c)
            return u, v, (p - c * r) * i, (2.0 * r - c * p) * i
        return double
    links = np.array([[n - max(i, j) for j in range(n)] for i in range(n)], float)
    weights = 9.81 * np.arange(n, 0, -1)

    def chain(t, y):
        d = y[:n, None] - y[None, :n]
        r = -weights * np.sin(y[:n]) - (links * np.sin(d)) @ y[n:] ** 2
        return np.concatenate((y[n:], np.linalg.solve(links * np.cos(d), r)))
    return chain


wanted_name = sys.argv[2] if len(sys.argv) > 2 else ""
for line in open(sys.argv[1], encoding="utf-8"):
    problem = json.loads(line)
    if not problem["name"].startswith(wanted_name):
        continue
    end, rates = np.array(problem["end"]), rates_of(problem)
    for wanted in problem["errors"]:
        for k in range(12, 55, 2):  # its rtol ends at 100 ε
            tol = 10.0 ** (-k / 4)
            began = time.perf_counter()
            y = solve_ivp(rates, (0.0, problem["t_end"]), problem["start"], "DOP853", rtol=max(tol, 2.3e-14), atol=tol).y[:, -1]
            seconds = time.perf_counter() - began
            error = np.max(np.abs(y - end)) / (np.max(np.abs(end)) if problem["relative"] else 1.0)
            if error <= wanted:
                for _ in range(2):
                    began = time.perf_counter()
                    solve_ivp(rates, (0.0, problem["t_end"]), problem["start"], "DOP853", rtol=max(tol, 2.3e-14), atol=tol)
                    seconds = min(seconds, time.perf_counter() - began)
                print(f"{problem['name']};{wanted:.0e};scipy DOP853;{tol:.1e};{error:.1e};{1e6 * seconds:.1f}", flush=True)
                break
