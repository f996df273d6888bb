# SPDX-License-Identifier: MIT
#
# heyoka_chain.py N…: one line "heyoka N ns" for each N, the time of one q̈ in a compiled function that evaluates 1024 states per call. heyoka
# gives the equations and no solution of M q̈ = r for itself, except inside lagrangian(), which is asked for here.
import sys
import time

import heyoka as hy
import numpy as np


def chain(n):
    q, v = hy.make_vars(*[f"q{i}" for i in range(n)]), hy.make_vars(*[f"v{i}" for i in range(n)])
    q, v = (list(q), list(v)) if n > 1 else ([q], [v])
    vx = vy = y = hy.expression(0.0)
    T = V = hy.expression(0.0)
    for k in range(n):
        vx = vx + hy.cos(q[k]) * v[k]
        vy = vy + hy.sin(q[k]) * v[k]
        T = T + 0.5 * (vx * vx + vy * vy)
        y = y - hy.cos(q[k])
        V = V + 9.81 * y
    equations = hy.lagrangian(T - V, q, v, hy.expression(0.0))
    accelerations = [right for left, right in equations if str(left).startswith("v")]
    return hy.cfunc(accelerations, vars=q + v)


states = 1024
for n in map(int, sys.argv[1:]):
    f = chain(n)
    random = np.random.default_rng(1)
    inputs = np.ascontiguousarray(random.uniform(-2.0, 2.0, (2 * n, states)))
    outputs = np.zeros((n, states))
    best = float("inf")
    for _ in range(300):
        began = time.perf_counter()
        f(inputs, outputs=outputs)
        best = min(best, time.perf_counter() - began)
    # against M q̈ = r of the closed form
    th, om = inputs[:n], inputs[n:]
    weight = np.array([[n - max(i, j) for j in range(n)] for i in range(n)], float)
    worst = 0.0
    for k in range(0, states, 37):
        d = th[:, k][:, None] - th[:, k][None, :]
        r = -np.array([n - i for i in range(n)]) * 9.81 * np.sin(th[:, k]) - (weight * np.sin(d)) @ om[:, k] ** 2
        a = np.linalg.solve(weight * np.cos(d), r)
        worst = max(worst, np.max(np.abs(a - outputs[:, k]) / (1 + np.abs(a))))
    print(f"heyoka {n} {1e9 * best / states:.2f} {worst:.1e}", flush=True)
