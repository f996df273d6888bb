#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of the lists `./run …` of README and docs/reference/commands.md as they stand there, one after the other, in a directory that is empty at first.

    commands.py PROGRAM

Each must end with status 0, and what `--out PATH` promises must be there. Those that take longer than a moment are ended after it: what a command refuses, it
refuses at once. Left out are the site and the benchmarks, which are programs of their own. What README and the tutorials show as printed by `./run equations SCENE` or
`./run list`, in the block behind it, is compared with what is printed.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import unicodedata

ROOT = pathlib.Path(__file__).resolve().parents[2]
LISTS = {"README.md": 8, "docs/reference/commands.md": 24}  # pages with a list, and how many commands it has at least
SECONDS = 0.3  # of a command that computes, once the program has started: MPI, which newer SUNDIALS bring along, waits for half a second
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
    # What is compiled stays beside the program, as for its other tests, and is found there again by the place and the text of its source.
    environment = dict(os.environ, XDG_CACHE_HOME=str(program.parent / "scene-cache"))
    directory = program.parent / "readme-commands"
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir()
    failures, ran, ended = [], 0, 0
    began = time.monotonic()
    subprocess.run([program, "--version"], env=environment, stdout=subprocess.DEVNULL, check=True)
    moment = SECONDS + time.monotonic() - began
    listed = {page: list(commands((ROOT / page).read_text(encoding="utf-8"))) for page in LISTS}
    failures += [f"The list of {page} has {len(listed[page])} commands that can be run; where is the rest?" for page in LISTS if len(listed[page]) < LISTS[page]]
    for command in dict.fromkeys(command for page in LISTS for command in listed[page]):
        ran += 1
        process = subprocess.Popen(["sh", "-c", command.replace("./run", f"exec '{program}'", 1)], cwd=directory, env=environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            output, _ = process.communicate(timeout=COMPILES if ".cpp" in command else moment)
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
    compared = 0
    for page in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))):
        for shown in re.finditer(r"`\./run (equations \w+|list)`[^`\n]*\n\n```text\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            compared += 1
            printed = subprocess.run([program, *shown[1].split()], capture_output=True, text=True, check=False).stdout
            if unicodedata.normalize("NFC", shown[2]).strip() not in unicodedata.normalize("NFC", printed):
                failures.append(f"./run {shown[1]} no longer prints what {page.relative_to(ROOT)} shows, but\n{printed}")
    if compared < 2:
        failures.append(f"README and the tutorials show the equations or the list of scenes {compared} times; they did 2 times")
    for failure in failures:
        print(failure)
    print(f"{ran} commands of README and docs/reference/commands.md, {ended} of them ended after {SECONDS:g} s: {len(failures)} failed")
    return 1 if failures else 0


sys.exit(main())
