#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""No header includes itself through others: the one circle is a face with its own work (CONTRIBUTING.md), name.hpp and name.ipp."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2] / "include"


def included_by(path, names):
    """The headers of ours that one includes."""
    return [name for name in re.findall(r'(?m)^\s*#\s*include\s*[<"]([^>"\n]+)[>"]', path.read_text(encoding="utf-8")) if name in names]


def way(graph, start, end):
    """The files from one to another that it includes, directly or not, both of them in it; the fewest, or none."""
    before, waiting = {start: None}, [start]
    for name in waiting:
        if name == end:
            files = [name]
            while before[files[-1]]:
                files.append(before[files[-1]])
            return files[::-1]
        for each in graph[name]:
            if each not in before:
                before[each] = name
                waiting.append(each)
    return []


def are_face_and_work(one, other):
    return one != other and pathlib.PurePath(one).with_suffix("") == pathlib.PurePath(other).with_suffix("")


paths = {str(path.relative_to(ROOT)): path for ending in ("hpp", "ipp") for path in sorted((ROOT / "qdot").rglob(f"*.{ending}"))}
graph = {name: included_by(path, paths) for name, path in paths.items()}
circles = [[name] + back for name in graph for included in graph[name] if not are_face_and_work(name, included)
           for back in [way(graph, included, name)] if back]
trouble, named = False, set()
for circle in sorted(circles, key=len):
    files = set(circle)
    if not files & named:  # of many circles through one file the shortest says enough
        named |= files
        print("\n    includes ".join(circle))
        trouble = True
if trouble:
    print("Put the definitions into a .ipp that its face includes at its end, or the type that both need into a header of its own.")
print(f"{len(paths)} files")
sys.exit(1 if trouble or not paths else 0)
