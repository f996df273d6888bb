#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""No function is longer than 60 lines, from the first line of its signature to its closing brace; tables, scripts and dispatchers are named here. No header's essay,
the comment at its head, is longer than 15."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONGEST = 60
LONGEST_ESSAY = 15
EXCEPTED = {
    "include/qdot/ad/formula/lines.hpp": "one label for each operation, in each of two loops",
    "include/qdot/report/html_player.hpp": "a script as one string",
    "include/qdot/report/heat_map.hpp": "a script as one string",
    "src/fmi/fmi3.hpp": "the declarations of the standard",
}


def without_text(line):
    """The line without comments, strings and characters, whose braces are none."""
    line = re.sub(r'"(\\.|[^"\\])*"', '""', line)
    line = re.sub(r"'(\\.|[^'\\])'", "''", line)
    return re.sub(r"//.*", "", line)


def head_of(lines, row):
    """(first line, text) of what stands before a brace in a line, back to the end of the statement before."""
    text, first = lines[row], row
    while first > 0 and row - first < 8:
        before = lines[first - 1].strip()
        if not before or re.search(r"[;{}]$", before) or re.match(r"(public|private|protected):$", before):
            break
        first -= 1
        text = before + " " + text
    return first, text


def long_functions(path):
    """(lines, line number, head) of each function that is too long."""
    lines = [without_text(line) for line in path.read_text(encoding="utf-8").splitlines()]
    stack = []
    for row, line in enumerate(lines):
        for place, sign in enumerate(line):
            if sign == "{":
                stack.append((row, line[: place + 1]))
            elif sign == "}" and stack:
                opened, text = stack.pop()
                first, head = head_of(lines[:opened] + [text], opened)
                is_function = "(" in head and not re.search(r"\b(namespace|class|struct|enum|union|concept)\b[^()]*\{$", head)
                if is_function and row - first + 1 > LONGEST:
                    yield row - first + 1, first + 1, head.strip()


def essay(path):
    """The number of lines of the first comment behind the licence."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = 0
    while first < len(lines) and (not lines[first].strip() or lines[first].startswith(("#", "// SPDX"))):
        first += 1
    last = first
    while last < len(lines) and lines[last].startswith("//"):
        last += 1
    while first < last and lines[first] == "//":
        first += 1
    return last - first


trouble, count = False, 0
for folder in ("include", "src"):
    for path in sorted(p for ending in ("hpp", "ipp", "cpp") for p in (ROOT / folder).rglob(f"*.{ending}")):
        name = str(path.relative_to(ROOT))
        count += 1
        if folder == "include" and essay(path) > LONGEST_ESSAY:
            print(f"{name}: an essay of {essay(path)} lines, more than {LONGEST_ESSAY}; say what it does, the formula, and why this way")
            trouble = True
        found = list(long_functions(path))
        if name in EXCEPTED:
            if not found:
                print(f"{name}: has no long function any more, and needs no exception")
                trouble = True
            continue
        for length, line, head in found:
            print(f"{name}:{line}: {length} lines, more than {LONGEST}: {head[:100]}")
            trouble = True
print(f"{count} files")
sys.exit(1 if trouble else 0)
