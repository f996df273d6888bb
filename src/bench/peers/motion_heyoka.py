# SPDX-License-Identifier: MIT
#
# motion_heyoka.py FILE [PROBLEM]: heyoka's Taylor integrator from a Lagrangian and from equations derived by hand, on the problems of FILE (from
# motion_problems); lines as motion_qdot's. Its compiled code is kept by its own cache; compiling is not measured, nor is the call from Python.
import json
import sys
import time

import heyoka as hy
import numpy as np


def variables(n):
    names = [f"q{i}" for i in range(n)], [f"v{i}" for i in range(n)]
    return [[hy.expression(name) for name in half] for half in names]


def energies(problem, q, v):
    n = problem["n"]
    if problem["name"].startswith("kepler"):
        return 0.5 * (v[0] * v[0] + v[1] * v[1]), -1.0 / hy.sqrt(q[0] * q[0] + q[1] * q[1])
    if problem["name"].startswith("double"):
        return (0.5 * (2.0 * v[0] * v[0] + v[1] * v[1] + 2.0 * v[0] * v[1] * hy.cos(q[0] - q[1])),
                -9.81 * (2.0 * hy.cos(q[0]) + hy.cos(q[1])))
    vx = vy = y = T = V = hy.expression(0.0)
    for k in range(n):
        vx, vy = vx + hy.cos(q[k]) * v[k], vy + hy.sin(q[k]) * v[k]
        T = T + 0.5 * (vx * vx + vy * vy)
        y = y - hy.cos(q[k])
        V = V + 9.81 * y
    return T, V


def by_hand(problem, q, v):
    n = problem["n"]
    if problem["name"].startswith("kepler"):
        r3 = (q[0] * q[0] + q[1] * q[1]) ** -1.5
        a = [-q[0] * r3, -q[1] * r3]
    elif n == 2:
        s, c = hy.sin(q[0] - q[1]), hy.cos(q[0] - q[1])
        u, w = -v[1] * v[1] * s - 2.0 * 9.81 * hy.sin(q[0]), v[0] * v[0] * s - 9.81 * hy.sin(q[1])
        i = 1.0 / (2.0 - c * c)
        a = [(u - c * w) * i, (2.0 * w - c * u) * i]
    else:
        M = [[float(n - max(i, j)) * hy.cos(q[i] - q[j]) if i != j else hy.expression(float(n - i)) for j in range(n)] for i in range(n)]
        a = [-(n - i) * 9.81 * hy.sin(q[i]) - sum((n - max(i, j)) * hy.sin(q[i] - q[j]) * v[j] * v[j] for j in range(n) if j != i)
             for i in range(n)]
        for k in range(n):
            for i in range(k + 1, n):
                factor = M[i][k] / M[k][k]
                for j in range(k + 1, n):
                    M[i][j] = M[i][j] - factor * M[k][j]
                a[i] = a[i] - factor * a[k]
        for i in reversed(range(n)):
            a[i] = (a[i] - sum(M[i][j] * a[j] for j in range(i + 1, n))) / M[i][i]
    return [(q[i], v[i]) for i in range(n)] + [(v[i], a[i]) for i in range(n)]


def cheapest(problem, method, equations, compact):
    start, end, t_end = np.array(problem["start"]), np.array(problem["end"]), problem["t_end"]
    made = {}

    def run(k):  # tolerance 10^(−k/4)
        if k not in made:
            tol = 10.0 ** (-k / 4)
            ta = hy.taylor_adaptive(equations, start, tol=tol, compact_mode=compact)
            outcome = ta.propagate_until(t_end)[0]
            error = np.max(np.abs(ta.state - end)) / (np.max(np.abs(end)) if problem["relative"] else 1.0)
            made[k] = ta, float(error) if outcome == hy.taylor_outcome.time_limit and np.isfinite(error) else float("inf")
        return made[k]

    for wanted in problem["errors"]:
        tightest = 62  # 3e-16
        k = min(tightest, round(-4 * np.log10(wanted)))
        while k < tightest and run(k)[1] > wanted:
            k += 2
        if run(k)[1] > wanted:
            continue
        while k > 8 and run(k - 1)[1] <= wanted:
            k -= 1
        ta, error = run(k)
        best = [float("inf"), float("inf")]
        began = time.perf_counter()
        while time.perf_counter() - began < 0.1:
            for case, goal in enumerate((t_end, 0.0)):
                ta.time = 0.0
                ta.state[:] = start
                before = time.perf_counter()
                ta.propagate_until(goal)
                best[case] = min(best[case], time.perf_counter() - before)
        print(f"{problem['name']};{wanted:.0e};{method};{10.0 ** (-k / 4):.1e};{error:.1e};{1e6 * (best[0] - best[1]):.2f}", flush=True)


wanted_name = sys.argv[2] if len(sys.argv) > 2 else ""
for line in open(sys.argv[1], encoding="utf-8"):
    problem = json.loads(line)
    if not problem["name"].startswith(wanted_name):
        continue
    n = problem["n"]
    q, v = variables(n)
    T, V = energies(problem, q, v)
    cheapest(problem, "heyoka.lagrangian", hy.lagrangian(T - V, q, v, hy.expression(0.0)), n > 4)
    if n <= 4:
        cheapest(problem, "heyoka, by hand", by_hand(problem, q, v), False)
