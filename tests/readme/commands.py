#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of README's list `./run …` as they stand there, one after the other, in a directory that is empty at first.

    commands.py PROGRAM

Each must end with status 0, and what `--out PATH` promises must be there. Those that take longer than a moment are ended after it: what a command refuses, it
refuses at once. Left out are the site and the benchmarks, which are programs of their own. What README shows as the equations of a scene is compared with what is printed.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import unicodedata

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"
SECONDS = 0.3  # of a command that computes
COMPILES = 300.0  # seconds for one that compiles a scene first


def commands(text):
    """The command lines of the list, without what is said about them."""
    for line in re.findall(r"^    (\./run .*)$", text, re.MULTILINE):
        command = re.split(r" {2,}", line)[0]
        if re.match(r"\./run (site|bench)\b", command) or command == "./run" or "…" in command or "ARGS" in command:
            continue
        yield command


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    text = README.read_text(encoding="utf-8")
    # What is compiled stays beside the program, as for its other tests, and is found there again by the place and the text of its source.
    environment = dict(os.environ, XDG_CACHE_HOME=str(program.parent / "scene-cache"))
    directory = program.parent / "readme-commands"
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir()
    failures, ran, ended = [], 0, 0
    for command in commands(text):
        ran += 1
        process = subprocess.Popen(["sh", "-c", command.replace("./run", f"exec '{program}'", 1)], cwd=directory, env=environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            output, _ = process.communicate(timeout=COMPILES if ".cpp" in command else SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            ended += 1
            continue
        if process.returncode != 0:
            failures.append(f"{command}\n    ended with {process.returncode}: {output[-600:]}")
        for path in re.findall(r"--out (\S+)", command):
            if not (directory / (path + ".html")).is_file():
                failures.append(f"{command}\n    wrote no {path}.html")
    shown = re.search(r"`\./run (equations \w+)` prints.*?```text\n(.*?)```", text, re.DOTALL)
    printed = subprocess.run([program, *shown[1].split()], capture_output=True, text=True, check=False).stdout
    if unicodedata.normalize("NFC", shown[2]).strip() not in unicodedata.normalize("NFC", printed):
        failures.append(f"./run {shown[1]} no longer prints what README shows, but\n{printed}")
    if ran < 15:
        failures.append(f"README's list has {ran} commands that can be run; where is the rest?")
    for failure in failures:
        print(failure)
    print(f"{ran} commands of README, {ended} of them ended after {SECONDS:g} s: {len(failures)} failed")
    return 1 if failures else 0


sys.exit(main())
