# SPDX-License-Identifier: MIT
#
# sensitivities_casadi.py: the same by CasADi, whose integrator is CVODES on equations that CasADi derives; errors of Phi controlled. By forward sensitivities
# of all four columns at once. Lines as sensitivities.hpp has them.
import casadi as ca
import numpy as np

from sensitivities_known import expected, least_microseconds

x = ca.SX.sym("x", 4)
q, v = x[:2], x[2:]
T = v[0] ** 2 + 0.5 * v[1] ** 2 + v[0] * v[1] * ca.cos(q[0] - q[1])
L = T + 9.81 * (2 * ca.cos(q[0]) + ca.cos(q[1]))
p = ca.gradient(L, v)
M = ca.jacobian(p, v)
acceleration = ca.solve(M, ca.gradient(L, q) - ca.jtimes(p, q, v))
ode = {"x": x, "ode": ca.vertcat(v, acceleration)}
start, seeds = np.array([1.7, 1.7, 0.0, 0.0]), np.eye(4)
for tolerance in [10.0**-k for k in range(4, 13)]:
    options = {"abstol": tolerance, "reltol": tolerance, "linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional",
               "fsens_err_con": True, "max_num_steps": 1000000}
    flow = ca.integrator("flow", "cvodes", ode, 0.0, 3.0, options)
    forward = flow.forward(4)
    xf = flow(x0=start)["xf"]

    def derived():
        return forward(x0=start, out_xf=xf, fwd_x0=seeds)["fwd_xf"]

    with_phi = least_microseconds(derived, 10)
    error = np.abs(np.array(derived()) - expected).max()
    print(f"casadi;{tolerance:.0e};{with_phi:.2f};{error:.2e};{least_microseconds(lambda: flow(x0=start), 10):.2f}", flush=True)
