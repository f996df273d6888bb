#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The lines of docs/reference/functions.md, and the members that are named of what comes back.

    lines.py                      each member is declared in a header that its row names, or in one that this header brings along
    lines.py COMPILER OPTIONS…    all lines compile, and what they give has the members that are named first in their rows
"""

import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "site"))
import headers  # noqa: E402

PAGE = ROOT / "docs" / "reference" / "functions.md"
MEMBER = re.compile(r"`\.(\w+)(\([^`]*\))?`")
# Bases and members of the results, of headers that those of the row bring along.
COMMON = ["integrate/run.hpp", "integrate/ensemble.hpp", "mechanics/system.hpp", "analysis/fit/best_parameters.hpp"]


def rows():
    """(line of the page, code, what comes back, headers) of each row with code."""
    for number, line in enumerate(PAGE.read_text(encoding="utf-8").split("\n"), 1):
        cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if len(cells) == 4 and re.fullmatch(r"`\w+ = .*`", cells[1]):
            yield number, cells[1].strip("`"), cells[2], re.findall(r"\(\.\./\.\./include/qdot/([\w/]+\.hpp)", cells[3])


def members_of_headers():
    """For each user header the names of members of its classes, and of the classes of the rooms that it brings along."""
    found = {}
    for header, _, rooms in headers.pages():
        declared = [*header.declarations, *(d for room in rooms for d in room.declarations)]
        found[header.path] = {member.name for declaration in declared for member in declaration.members}
    return found


def undeclared():
    known = members_of_headers()
    everywhere = set().union(*(known.get(path, set()) for path in COMMON))
    for number, code, back, paths in rows():
        named = everywhere.union(*(known[path] for path in paths))
        for match in MEMBER.finditer(back):
            if match[1] not in named:
                yield f"docs/reference/functions.md:{number}: no header of the row declares {match[1]}"


# What comes back is asked for the members that are named before the first word, which may be about something else.
def statements():
    for number, code, back, paths in rows():
        name = code.partition(" = ")[0]
        lead = re.match(r"(?:`\.\w+(?:\([^`]*\))?`(?:, |$))*", back)[0]
        asked = []
        for match in MEMBER.finditer(lead):
            call = match[2] or ""
            if not re.search(r"\((?:t|k|t, y|saved|f|x)\)", call):
                asked.append(f"static_cast<void>({name}.{match[1]}{call});")
        yield number, f"  {{\n#line {number} \"docs/reference/functions.md\"\n    auto {code};\n    static_cast<void>({name});\n    {' '.join(asked)}\n  }}\n"


def program():
    included = sorted({path for _, _, _, paths in rows() for path in paths})
    return ('#include "names.hpp"\n' + "".join(f"#include <qdot/{path}>\n" for path in included) +
            "#include <qdot/integrate/runge_kutta.hpp>\n\nnamespace of_the_page {\n\nvoid lines() {\n" + "".join(text for _, text in statements()) + "}\n\n}  // namespace of_the_page\n")


def main():
    count = sum(1 for _ in rows())
    if count < 60:
        sys.exit(f"docs/reference/functions.md has {count} lines that are found; it had 66")
    if len(sys.argv) == 1:
        wrong = list(undeclared())
        if wrong:
            sys.exit("\n".join(wrong))
        print(f"the members that {count} lines name are declared")
        return
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder) / "lines.cpp"
        source.write_text(program(), encoding="utf-8")
        sys.exit(subprocess.run([*sys.argv[1:], "-std=c++20", "-fsyntax-only", "-I", str(ROOT / "tests" / "functions"),
                                 "-I", str(ROOT / "include"), str(source)], check=False).returncode)


main()
