# SPDX-License-Identifier: MIT
#
# What the Python programs sensitivities_*.py share: Phi of sensitivities.hpp, and the clock.
import time

import numpy as np

expected = np.array([
    [0.42512535360011335, 0.32234325900511527, -0.11480303301727812, -0.32188377823700566],
    [0.35375523822508861, -0.12147143371945361, 0.03465925719707716, 0.61006975762812077],
    [3.55481773398585877, 2.52890401856926854, 0.87795461024674466, -0.09322081715396367],
    [2.95323559692079771, -0.59978990735865972, 0.20286440439106009, 1.95089499890557590],
])


def least_microseconds(work, repeats):
    best = 1e30
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        best = min(best, 1e6 * (time.perf_counter() - began))
    return best
