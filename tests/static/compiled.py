#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What headers leave to the library qdot::compiled is what src/compiled/ has, and nothing else."""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parents[2]


def instantiations(text, keyword):
    """(namespace, declaration) of each line that begins with `keyword template`."""
    found, names = set(), []
    for line in text.splitlines():
        opens = re.match(r"namespace ([\w:]+) \{", line)
        if opens:
            names.append(opens[1])
        elif line.startswith("}  // namespace"):
            names.pop()
        declares = re.match(keyword + r"(template (?!<).*;)", line)
        if declares:
            found.add(("::".join(names), declares[1]))
    return found


declared = set()
for header in (root / "include").rglob("*.hpp"):
    for block in re.finditer(r"(?s)#ifdef QDOT_COMPILED\n(.*?)#endif", text := header.read_text()):
        here = instantiations(text[: block.end()], "extern ")
        if not here:
            sys.exit(f"{header.relative_to(root)}: nothing between #ifdef QDOT_COMPILED and #endif is an extern template")
        declared |= here
defined = set()
for source in (root / "src/compiled").glob("*.cpp"):
    defined |= instantiations(source.read_text(), "")
for what, missing in (("src/compiled/ lacks", declared - defined), ("no header leaves to the library", defined - declared)):
    for namespace, declaration in sorted(missing):
        print(f"{what}: namespace {namespace}: {declaration}")
print(f"{len(declared)} of them")
sys.exit(0 if declared and declared == defined else 1)
