# SPDX-License-Identifier: MIT
#
# casadi_chain.py OUTPUT.c N…: Lagrange's equations of the chain derived by CasADi and written as C: functions chain_N(q, qdot) → qddot
# by a symbolic L D Lᵀ, with common subexpressions shared.
import os
import sys

import casadi as ca


def chain(n):
    q, v = ca.SX.sym("q", n), ca.SX.sym("v", n)
    vx = vy = y = 0
    T = V = 0
    for k in range(n):
        vx = vx + ca.cos(q[k]) * v[k]
        vy = vy + ca.sin(q[k]) * v[k]
        T = T + 0.5 * (vx * vx + vy * vy)
        y = y - ca.cos(q[k])
        V = V + 9.81 * y
    p = ca.gradient(T, v)
    M = ca.jacobian(p, v)
    r = ca.gradient(T - V, q) - ca.jacobian(p, q) @ v
    D, LT, order = ca.ldl(M, False)
    return ca.Function(f"chain_{n}", [q, v], [ca.cse(ca.ldl_solve(r, D, LT, order))])


output = sys.argv[1]
os.chdir(os.path.dirname(os.path.abspath(output)))
generator = ca.CodeGenerator(os.path.basename(output))
for n in sys.argv[2:]:
    generator.add(chain(int(n)))
generator.generate()
