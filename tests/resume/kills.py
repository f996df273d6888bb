#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""kills.py PROGRAM [--kills N] [--seed S] [--mpirun MPIRUN]: a sweep that is killed again and again ends in the bytes of one that nobody disturbed.

The same command is started until it comes to its end, by 1, 2 and 4 workers. N times for each it meets SIGKILL, at a random time such that about an N-th of
the sweep is done in each turn: all of its processes together, or first one worker that the others survive. With --mpirun the workers are processes of MPI."""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

parser = argparse.ArgumentParser()
parser.add_argument("program")
parser.add_argument("--kills", type=int, default=50)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--mpirun")
given = parser.parse_args()
given.program = os.path.abspath(given.program)
chance = random.Random(given.seed)
environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1",
                   PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe")
endings = (".csv", ".npz", ".html")


def command(out, *more, motions=40):
    return [given.program, "sweep", "double_pendulum", "--over", f"q0=-3:3:{motions}", "--over", "q1=-3:3:20", "--record", "q0", "--record",
            "t(|q1|=3.14159)", "--t-end", "10", "--quiet", "--out", out, *more]


def started(arguments):
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, env=environment)


def finished(arguments):
    process = started(arguments)
    out, err = process.communicate(timeout=600)
    if process.returncode != 0:
        sys.exit(f"{' '.join(arguments)} ended with status {process.returncode}: {err}")
    return out + err


def seconds(arguments):
    begin = time.monotonic()
    finished(arguments)
    return time.monotonic() - begin


def children(process):
    try:
        return [int(child) for child in pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
    except OSError:  # not Linux, or gone
        return []


def killed(arguments, after):
    """Whether the processes lived long enough to be killed."""
    process = started(arguments)
    time.sleep(after)
    alive = process.poll() is None
    workers = children(process)
    try:
        if workers and chance.random() < 0.5 and not given.mpirun:
            os.kill(chance.choice(workers), signal.SIGKILL)
            time.sleep(after / 4)
        os.killpg(process.pid, signal.SIGKILL)
        if given.mpirun:  # its processes are groups of their own
            for child in workers:
                os.kill(child, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.communicate()
    return alive


with tempfile.TemporaryDirectory(prefix="qdot-kills-") as folder:
    os.chdir(folder)
    start = seconds(command("small", motions=1))
    whole = seconds(command("undisturbed", "--threads", "1"))
    expected = {ending: pathlib.Path("undisturbed" + ending).read_bytes() for ending in endings}
    for workers in (1, 2, 4):
        out = f"by{workers}"
        arguments = command(out, "--processes", str(workers)) if workers > 1 else command(out, "--resume", "--threads", "2")
        if given.mpirun:
            arguments = [given.mpirun, "-n", str(workers)] + command(out, "--shard", "auto")
            start = max(start, seconds([given.mpirun, "-n", str(workers)] + command(f"small{workers}", "--shard", "auto", motions=1)))
        hits = sum(killed(arguments, chance.uniform(0.5 * start, 1.2 * start + 1.6 * whole / given.kills)) for _ in range(given.kills))
        recorded = len(list(pathlib.Path(out + ".sweep").glob("*.records")))
        said = finished(arguments)
        for ending in endings:
            if pathlib.Path(out + ending).read_bytes() != expected[ending]:
                sys.exit(f"{workers} workers, seed {given.seed}: {out}{ending} is not what an undisturbed run writes")
        print(f"{workers} workers: {hits} of {given.kills} kills hit, {recorded} processes had recorded something; the same bytes. {said.splitlines()[0]}")
