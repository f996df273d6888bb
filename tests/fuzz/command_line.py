#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Random and mutated argument lists for the program qdot. Whatever they are,

  - it ends by itself with status 0, 1 or 2, never by a signal;
  - 2 (bad arguments) says so in one line on stderr that begins with "qdot", leaves stdout empty and writes no file;
  - 1 (the run failed) says why: on stdout with the last good state, or on stderr;
  - 0 prints a result, which is JSON without NaN where --json was given;
  - files of --out are whole (tables with as many numbers in each row, archives that can be read, closed tags) or not there.

    tests/fuzz/command_line.py [--count N | --seconds S] [--seed N] PROGRAM

What fails is printed with its seed. A run that takes longer than --patience seconds is stopped and counted, no failure: to ask for
a long run is no bad argument.
"""

import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import zipfile

NUMBERS = ["0", "-0", "1", "2", "0.5", "-1", "1e-3", "1e-9", "1e-15", "1e-300", "1e-320", "1e300", "1e999", "-1e308", "nan", "-nan", "inf",
           "-inf", "0x10", "1e", "1.", ".5", "+1", "1_000", "1,5", " 1", "1 ", "", "½", "9" * 400, "--", "-", "1e5", "2.5", "3", "10", "pi", "-pi/2", "3*pi/4", "90deg", "pi/0",
           "2*", "pi*", "degpi"]
TEXTS = ["", " ", "=", "==", "a=b=c", "q0", "q0=", "=1", "q0=1", "l=0", "l=-1", "m=nan", "g=1e400", "qdot0=1e308", "n=0", "n=-1", "n=2.5", "n=3",
         "*", "../..", "/", "/dev/null", "/dev/full", "/proc/x", "--", "-", "-h", "--help", "--version", "%s%n", "$(false)", "`false`",
         "\n", "a\nb", "\t", "\x1b[31m", "\x7f", "é", "𝛉", "\udcff\udcfe", "x" * 5000, "pendulum", "PENDULUM", "pendulum ", "pend"]


def scenes_and_methods(program):
    """What `qdot list` prints: names, and the effects in brackets."""
    text = subprocess.run([program, "list"], capture_output=True, text=True, check=True).stdout
    tables = [[line for line in table.splitlines()[1:] if line and line[0] != " "] for table in text.split("\n\n")]
    effects = [word.strip("[]").split("=")[0] for line in tables[0] for word in line.split() if word.startswith("[")]
    names = [[line.split()[0] for line in table] for table in tables]
    return names[0], (names[1] if len(names) > 1 else ["bdf", "adams", "dop853"]), effects or ["damping"]


class Arguments:
    """Makes argument lists, most of them nearly right."""

    def __init__(self, generator, program, directory):
        self.random, self.directory = generator, directory
        self.scenes, self.methods, self.effects = scenes_and_methods(program)

    def any_of(self, *choices):
        return self.random.choice(choices)

    def number(self):
        return self.random.choice(NUMBERS) if self.random.random() < 0.6 else repr(self.random.uniform(-3, 3))

    def option(self):
        pick = self.random.random()
        path = str(self.directory / self.any_of("x", "x.csv", "y/z", ".", "x" * 300))
        name = self.any_of("q0", "q1", "qdot0", "m", "l", "g", "k", "e", "M", "I1", "q9", "Q0")
        return (["--t-end", self.any_of("0.01", "0.02", "0.3", "-1", "0", "nan", "x", "1e-300")] if pick < 0.15 else
                ["--rtol", self.number()] if pick < 0.22 else
                ["--atol", self.number()] if pick < 0.29 else
                ["--step", self.any_of("0.01", "0", "-1", "nan", "1e-3", "10")] if pick < 0.34 else
                ["--method", self.random.choice(self.methods + ["", "adam", "gauss"])] if pick < 0.50 else
                ["--accuracy", self.any_of("1e-6", "1e-3", "0", "-1", "nan", "1e-20", "x")] if pick < 0.53 else
                ["--samples", self.any_of("2", "5", "1", "0", "-5", "2.5", "x", "99999999999999999999")] if pick < 0.60 else
                ["--set", f"{name}={self.number()}"] if pick < 0.72 else
                ["--set", self.random.choice(TEXTS)] if pick < 0.75 else
                ["--with", self.random.choice(self.effects) + self.any_of("", f"={self.number()}")] if pick < 0.82 else
                ["--without", self.random.choice(self.effects + TEXTS)] if pick < 0.86 else
                ["--out", path] if pick < 0.94 else
                [self.any_of("--json", "--quiet", "--quick", "--help", "--jsno", "--", "-x")])

    def listed(self):
        command = self.random.choices(["run", "list", "effects", "accuracy", "bench", "rnu", ""], [80, 4, 2, 2, 2, 2, 1])[0]
        if command == "bench":
            return [command, self.any_of("foo", "eom2", "--x", "")]
        scene = [] if command == "list" else [self.random.choice(self.scenes)]
        arguments = [command, *scene, "--t-end", "0.05", "--samples", "5"] if command in ("run", "accuracy") else [command, *scene]
        if command == "accuracy":
            arguments += ["--quick", "--method", "dop853"]
        for _ in range(self.random.randrange(4)):
            arguments += self.option()
        return self.mutated(arguments) if self.random.random() < 0.4 else arguments

    def mutated(self, arguments):
        arguments = list(arguments)
        for _ in range(self.random.randrange(1, 3)):
            i = self.random.randrange(len(arguments) + 1)
            kind = self.random.randrange(5)
            if kind == 0 or i == len(arguments):
                arguments.insert(i, self.random.choice(TEXTS + NUMBERS))
            elif kind == 1:
                del arguments[i]
            elif kind == 2:
                arguments.insert(self.random.randrange(len(arguments)), arguments[i])
            elif kind == 3:
                arguments[i] = self.random.choice(TEXTS + NUMBERS)
            else:
                text = list(arguments[i] or "x")
                text[self.random.randrange(len(text))] = chr(self.random.randrange(1, 0x250))
                arguments[i] = "".join(text)
        return arguments


def fault_of_file(path):
    """What is wrong with a file of --out, or None."""
    if path.suffix == ".npz":
        return None if zipfile.is_zipfile(path) and zipfile.ZipFile(path).testzip() is None else "no whole archive"
    text = path.read_text()
    if path.suffix == ".csv":
        rows = [line.count(",") for line in text.splitlines() if not line.startswith("#")]
        return None if text.endswith("\n") and len(set(rows)) == 1 else "rows of different length, or cut off"
    if path.suffix in (".html", ".svg"):
        return None if text.rstrip().endswith(f"</{path.suffix[1:]}>") else "not closed"
    return "nobody asked for it"


def refuse_constant(name):
    raise ValueError(f"{name} is no JSON")


def faults(arguments, status, out, err, directory):
    """Everything that is wrong with how a call ended."""
    if status not in (0, 1, 2):
        yield f"status {status}"
    if any(word in err for word in ("terminate called", "Sanitizer", "runtime error", "Assertion")):
        yield "crash on stderr"
    files = [path for path in directory.rglob("*") if path.is_file()]
    if status == 2:
        if out:
            yield "bad arguments, but something on stdout"
        if err.count("\n") != 1 or not err.endswith("\n") or not err.startswith("qdot") or len(err) < 12:
            yield "bad arguments need one line on stderr"
        if any((ord(c) < 32 or ord(c) == 127) and c != "\n" for c in err):
            yield "control characters on stderr"
        if files:
            yield f"bad arguments, but {files[0].name} was written"
    if status == 1 and not err.strip() and not out.strip():
        yield "failed without a word"
    if status == 0 and not out:
        yield "nothing on stdout"
    if status == 0 and "--json" in arguments and out.lstrip().startswith("{"):
        try:
            json.loads(out, parse_constant=refuse_constant)
        except ValueError as error:
            yield f"JSON: {error}"
    for path in files:
        fault = fault_of_file(path)
        if fault:
            yield f"{path.name}: {fault}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--seconds", type=float, help="go on for so long, instead of --count")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=10.0)
    asked = parser.parse_args()
    asked.program = str(pathlib.Path(asked.program).resolve())

    wrong = long = done = 0
    ended = {}
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="qdot-fuzz-") as parent:
        while time.monotonic() - began < asked.seconds if asked.seconds else done < asked.count:
            seed = asked.seed * 1000003 + done
            done += 1
            directory = pathlib.Path(parent) / str(done)
            directory.mkdir()
            if done == 1:
                maker = Arguments(random.Random(), asked.program, directory)
            maker.random.seed(seed)
            maker.directory = directory
            arguments = maker.listed()
            if any("\0" in argument for argument in arguments):
                continue
            raw = [argument.encode("utf-8", "surrogateescape") for argument in arguments]
            try:
                call = subprocess.run([asked.program, *raw], capture_output=True, timeout=asked.patience, cwd=directory, stdin=subprocess.DEVNULL)
            except subprocess.TimeoutExpired:
                long += 1
                continue
            ended[call.returncode] = ended.get(call.returncode, 0) + 1
            out, err = call.stdout.decode(errors="replace"), call.stderr.decode(errors="replace")
            for fault in faults(arguments, call.returncode, out, err, directory):
                wrong += 1
                print(f"{fault}\n  seed {seed}: qdot {' '.join(map(repr, arguments))}\n  status {call.returncode}, stderr: {err[:300]!r}")
    print(f"{done} calls: " + ", ".join(f"{n} with status {s}" for s, n in sorted(ended.items())) +
          f", {long} stopped after {asked.patience:g} s, {wrong} faults")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
