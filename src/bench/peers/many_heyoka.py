# SPDX-License-Identifier: MIT
#
# many_heyoka.py FILE: the problems of many_qdot.cxx by heyoka's adaptive Taylor integrator in batch mode, equations by heyoka.lagrangian. A line
# "problem;tolerance;microseconds;error" for each tolerance and the best of the batch sizes 4 and 8.
import json
import sys
import time

import heyoka as hy
import numpy as np


def variables(n):
    return list(hy.make_vars(*[f"q{i}" for i in range(n)])), list(hy.make_vars(*[f"v{i}" for i in range(n)]))


def double_pendulum():
    q, v = variables(2)
    return hy.lagrangian(0.5 * (2.0 * v[0] * v[0] + v[1] * v[1] + 2.0 * v[0] * v[1] * hy.cos(q[0] - q[1])) + 9.81 * (2.0 * hy.cos(q[0]) + hy.cos(q[1])), q, v)


def kepler():
    q, v = variables(2)
    return hy.lagrangian(0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / hy.sqrt(q[0] * q[0] + q[1] * q[1]), q, v)


def chain(n):
    q, v = variables(n)
    vx = vy = y = L = hy.expression(0.0)
    for k in range(n):
        vx = vx + hy.cos(q[k]) * v[k]
        vy = vy + hy.sin(q[k]) * v[k]
        y = y - hy.cos(q[k])
        L = L + 0.5 * (vx * vx + vy * vy) - 9.81 * y
    return hy.lagrangian(L, q, v)


systems = {"double_pendulum": double_pendulum, "kepler": kepler, **{f"chain {n}": (lambda n=n: chain(n)) for n in (2, 3, 4)}}
for line in open(sys.argv[1], encoding="utf-8"):
    problem = json.loads(line)
    given = np.array(problem["motions"]).T
    n = given.shape[0] // 3
    starts, ends = given[: 2 * n], given[2 * n :]
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
        best, error = 1e30, 0.0
        for batch in (4, 8):
            integrator = hy.taylor_adaptive_batch(systems[problem["problem"]](), np.zeros((2 * n, batch)), tol=tolerance)
            for _ in range(3):
                reached = np.empty_like(ends)
                began = time.perf_counter()
                for k in range(0, starts.shape[1], batch):
                    integrator.set_time(0.0)
                    integrator.state[:] = starts[:, k : k + batch]
                    integrator.propagate_until(np.full(batch, 5.0))
                    reached[:, k : k + batch] = integrator.state[:n]
                best = min(best, 1e6 * (time.perf_counter() - began) / starts.shape[1])
                error = np.median(np.linalg.norm(reached - ends, axis=0))
        print(f"{problem['problem']};{tolerance:g};{best:.3f};{error:.3g}", flush=True)
