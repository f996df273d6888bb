#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Spaces and indentation are those that clang-format 16 writes by .clang-format; lines break where their sense does.

A formatter that may move line breaks tears tables of one-line functions apart and joins sentences of errors to lines of 300 columns. So the
breaks stay the author's: what is compared is, between two characters that are not spaces, how many spaces there are (where neither text
breaks the line; columns of a table may be wider) and how far a line is indented (where both do, and the statement is broken alike up to
there). A line may stand as far in as clang-format has it, as far in from the line before it as there, or two or four columns further in
than the line that opens a bracket. No line has more than LONGEST columns, unless it is one string.

`tests/static/format.py --fix` mends spaces and indentation. Without clang-format 16 there is nothing to compare with: exit status 77,
which ctest takes for skipped.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["include", "src", "examples", "tests"]
LONGEST = 160
RAW_STRING = re.compile(r'R"(\w*)\(.*?\)\1"', re.DOTALL)
ONE_STRING = re.compile(r'^\s*(".*"[,;:)}]*|#error .*)$')
# What clang-format 16 takes for something else: "(a || b) && c" in a constraint for an rvalue reference, a label of an address for a case,
# the references of a lambda's arguments before an attribute for products.
MISREAD = re.compile(r"\)\s*&&|^\w+\s*: \{|__attribute__")


def clang_format():
    for name in ["clang-format-16", "clang-format"]:
        if path := shutil.which(name):
            said = subprocess.run([path, "--version"], capture_output=True, text=True, check=False).stdout
            if re.search(r"version 16\.", said):
                return path
    return None


def spaces(text):
    """The characters of a text that are not spaces, and the spaces before each of them and after the last."""
    parts = re.split(r"(\S)", text)
    return parts[1::2], parts[0::2]


def indentation(run):
    return len(run) - run.rfind("\n") - 1


def mended(text, formatted):
    """The text with clang-format's spaces and indentation and its own line breaks."""
    if formatted == text:
        return text
    characters, own = spaces(text)
    same, other = spaces(formatted)
    if characters != same:
        return formatted
    runs = []
    last = ""        # the character before
    before = (0, 0)  # the indentation of the line before, here and in clang-format's text
    alike = True     # whether both break the statement at the same places, as far as it was read
    for mine, its, character in zip(own, other, characters + [""]):
        if "\n" in mine:
            alike = alike or last in ";{}"
            here = indentation(mine)
            if "\n" in its:
                there = indentation(its)
                opened = [before[0] + 2, before[0] + 4] if last in "([{" else []
                fits = here in [there, there - before[1] + before[0], *opened]
                if alike and not fits:
                    mine = re.sub(r"[^\n]", "", mine) + " " * there
                before = (here, there)
            else:
                alike = False
                before = (here, here)
        elif "\n" in its:
            alike = False
        elif min(len(mine), len(its)) < 1 or character == "/":  # (other numbers of spaces: columns of a table)
            mine = its
        runs.append(mine)
        last = character
    return "".join(run + character for run, character in zip(runs, characters + [""]))


def main(arguments):
    if arguments not in ([], ["--fix"]):
        sys.exit("tests/static/format.py [--fix]")
    tool = clang_format()
    if tool is None:
        print("Skipped: the code is compared with clang-format 16, which is not installed (Debian: apt-get install clang-format-16)")
        sys.exit(77)
    files = sorted(f for folder in FOLDERS for ending in ["hpp", "ipp", "cpp"] for f in (ROOT / folder).rglob(f"*.{ending}"))
    if len(files) < 500:
        sys.exit(f"Only {len(files)} files of code: where are the others?")
    with tempfile.TemporaryDirectory() as folder:
        # One process for many files: starting takes as long as formatting.
        copies = [pathlib.Path(folder) / str(file.relative_to(ROOT)).replace("/", "+") for file in files]
        shutil.copy(ROOT / ".clang-format", folder)
        for file, copy in zip(files, copies):
            shutil.copy(file, copy)
        halves = [subprocess.Popen([tool, "-i", *map(str, copies[k::2])]) for k in range(2)]
        if any(half.wait() for half in halves):
            sys.exit("clang-format failed")
        formatted = [copy.read_text(encoding="utf-8") for copy in copies]
    wrong = []
    for file, said in zip(files, formatted):
        text = file.read_text(encoding="utf-8")
        mine, its = text.split("\n"), mended(text, said).split("\n")
        if len(mine) == len(its):
            its = [m if MISREAD.search(m) else i for m, i in zip(mine, its)]
        if arguments and mine != its:
            file.write_text("\n".join(its), encoding="utf-8")
            mine = its
        name = file.relative_to(ROOT)
        code = RAW_STRING.sub(lambda raw: "\n" * raw[0].count("\n"), "\n".join(mine)).split("\n")
        wrong += [f"{name}:{k}: {len(line)} columns; {LONGEST} are the most" for k, line in enumerate(code, 1)
                  if len(line) > LONGEST and not ONE_STRING.match(line)]
        wrong += [f"{name}:{k}: is\n{m}\nclang-format has\n{i}" for k, (m, i) in enumerate(zip(mine, its), 1) if m != i]
        if len(mine) != len(its):
            wrong.append(f"{name}: clang-format has other lines")
    if wrong:
        sys.exit("\n".join(wrong) + f"\n{len(wrong)} lines; `tests/static/format.py --fix` mends spaces and indentation")
    print(f"{len(files)} files have clang-format's spaces and indentation")


main(sys.argv[1:])
