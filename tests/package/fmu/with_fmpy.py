# SPDX-License-Identifier: MIT
"""FMPy (PyPI: fmpy) on the FMU of hopper.cpp: it finds nothing wrong with the description, and its motions, by both interfaces, are those of `qdot run`.

usage: with_fmpy.py HOPPER.fmu SCENE.cpp QDOT

Exits with 77 where there is no FMPy, neither here nor in the Python that QDOT_FMPY_PYTHON names.
"""

import json
import os
import subprocess
import sys

try:
    import fmpy
    from fmpy.validation import validate_fmu
except ImportError:
    other = os.environ.pop("QDOT_FMPY_PYTHON", "")
    if os.access(other, os.X_OK):
        os.execv(other, [other, *sys.argv])
    print("there is no FMPy: pip install fmpy")
    sys.exit(77)

fmu, scene, program = sys.argv[1:]
TOLERANCE = {"CoSimulation": 1e-8, "ModelExchange": 1e-6}  # the second is that of FMPy's CVode, which begins at order one behind each impact
problems = validate_fmu(fmu)
assert problems == [], problems


def motion_of_program(*settings):
    command = [program, "run", scene, "--set", "g=10", "--with", "drag=0.25", "--json", *settings]
    result = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    return result["q"] + result["qdot"]


def motion_of_fmu(interface, start_values, **how):
    result = fmpy.simulate_fmu(fmu, fmi_type=interface, stop_time=1.9, relative_tolerance=1e-10, start_values=start_values, **how)
    return [result[name][-1] for name in ("h", "x", "hdot", "xdot")]


for settings, start_values in (
    ((), {}),
    (("--set", "m=3", "--set", "e=0.7", "--set", "q0=2"), {"m": 3.0, "e": 0.7, "h": 2.0}),
    (("--without", "drag"), {"drag.on": False}),
):
    expected = motion_of_program("--t-end", "1.9", *settings)
    for interface, how in (
        ("CoSimulation", {}),
        ("CoSimulation", {"early_return_allowed": True}),
        ("CoSimulation", {"early_return_allowed": True, "use_event_mode": True}),
        ("ModelExchange", {}),
    ):
        found = motion_of_fmu(interface, start_values, **how)
        error = max(abs(a - b) for a, b in zip(found, expected))
        print(interface, how, start_values, f"differs by {error:.2g}")
        assert error <= TOLERANCE[interface], (found, expected)
