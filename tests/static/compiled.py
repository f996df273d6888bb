#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What headers leave to the libraries qdot::compiled and qdot::compiled_analysis is what src/compiled/ has for them, and nothing else."""
import pathlib
import re
import sys

root = pathlib.Path(__file__).resolve().parents[2]


def instantiations(text, keyword):
    """(namespace, declaration) of each declaration that begins with `keyword template`."""
    found, names = set(), []
    whole = re.sub(r"(?m)^((?:extern )?template (?!<)[^;]*;)", lambda m: re.sub(r"\s*\n\s*", " ", m[0]), text)
    for line in whole.splitlines():
        opens = re.match(r"namespace ([\w:]+) \{", line)
        if opens:
            names.append(opens[1])
        elif line.startswith("}  // namespace"):
            names.pop()
        declares = re.match(keyword + r"(template (?!<).*;)", line)
        if declares:
            found.add(("::".join(names), declares[1]))
    return found


trouble, count = False, 0
for macro, sources in (("QDOT_COMPILED", ("equations", "effects", "runs_1_to_4", "runs_5_to_8", "cvode")), ("QDOT_COMPILED_ANALYSIS", ("analysis",))):
    declared = set()
    for header in (root / "include").rglob("*.hpp"):
        text = header.read_text()
        others = re.sub(r"(?s)#ifdef QDOT_COMPILED\w*\n(.*?)#endif", lambda m: m[0] if m[0].startswith(f"#ifdef {macro}\n") else "", text)
        for block in re.finditer(rf"(?s)#ifdef {macro}\n(.*?)#endif", others):
            here = instantiations(others[: block.end()], "extern ")
            if not here:
                sys.exit(f"{header.relative_to(root)}: nothing between #ifdef {macro} and #endif is an extern template")
            declared |= here
    defined = set()
    for source in sources:
        defined |= instantiations((root / f"src/compiled/{source}.cpp").read_text(), "")
    for what, missing in ((f"src/compiled/{'|'.join(sources)}.cpp lacks", declared - defined), (f"no header leaves it to the library ({macro})", defined - declared)):
        for namespace, declaration in sorted(missing):
            print(f"{what}: namespace {namespace}: {declaration}")
    trouble = trouble or not declared or declared != defined
    count += len(declared)
print(f"{count} of them")
sys.exit(1 if trouble else 0)
