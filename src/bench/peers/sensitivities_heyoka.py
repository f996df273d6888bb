# SPDX-License-Identifier: MIT
#
# sensitivities_heyoka.py: the same by heyoka's var_ode_sys, equations by heyoka.lagrangian; lines as sensitivities.hpp has them.
import heyoka as hy
import numpy as np

from sensitivities_known import expected, least_microseconds

q, v = hy.make_vars("q0", "q1"), hy.make_vars("v0", "v1")
T = v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * hy.cos(q[0] - q[1])
equations = hy.lagrangian(T + 9.81 * (2.0 * hy.cos(q[0]) + hy.cos(q[1])), list(q), list(v))
variational = hy.var_ode_sys(equations, hy.var_args.vars, order=1)
start = np.array([1.7, 1.7, 0.0, 0.0])
for tolerance in [10.0**-k for k in range(4, 15)]:
    plain, derived = hy.taylor_adaptive(equations, start, tol=tolerance), hy.taylor_adaptive(variational, start, tol=tolerance)
    begin = derived.state.copy()

    def run(integrator, state):
        integrator.time = 0.0
        integrator.state[:] = state
        integrator.propagate_until(3.0)

    with_phi = least_microseconds(lambda: run(derived, begin), 60)
    error = np.abs(derived.state[4:].reshape(4, 4) - expected).max()
    print(f"heyoka;{tolerance:.0e};{with_phi:.2f};{error:.2e};{least_microseconds(lambda: run(plain, start), 60):.2f}", flush=True)
