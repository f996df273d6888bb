#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Shape of the pages: one heading at the top, lines of prose of at most 160 columns, how-to pages of at most 60 lines, no page of more than 60 lines of prose without
a picture, a table or code; measurements have no column for what was before."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
WRITTEN = {"docs/lab/hard-cases.md", "docs/reference/options.md", "docs/reference/results.md", "docs/reference/scenes.md"}  # by programs, one line a paragraph
LONGEST_LINE, LONGEST_HOW_TO, LONGEST_PROSE = 160, 60, 60
ROOMS = {"tutorials": 10, "how-to": 40, "reference": 5, "explanation": 5, "lab": 10}  # and the least number of pages

violations = []
for room, least in ROOMS.items():
    pages = sorted((ROOT / "docs" / room).glob("*.md"))
    if len(pages) < least:
        sys.exit(f"docs/{room} has {len(pages)} pages; it had {least}")
    for page in pages:
        name, fenced, prose, shown = page.relative_to(ROOT), False, 0, False
        lines = page.read_text(encoding="utf-8").splitlines()
        headings = 0
        for number, line in enumerate(lines, 1):
            fence = re.match(r"\s*```", line)
            fenced = fenced != bool(fence)
            displayed = fence or fenced or re.match(r"\s*\||    |!\[", line)
            shown = shown or bool(displayed)
            prose += not displayed and bool(line.strip())
            headings += not fenced and line.startswith("# ")
            if not displayed and len(line) > LONGEST_LINE and str(name) not in WRITTEN:
                violations.append(f"{name}:{number}: {len(line)} columns; {LONGEST_LINE} are the most")
            if room == "lab" and re.match(r"\|.*\|\s*(?:before|earlier|then)\s*\|", line):
                violations.append(f"{name}:{number}: a column for what was before")
        if headings != 1 or not lines[0].startswith("# "):
            violations.append(f"{name}: {headings} headings of the first order; one, at the top, is wanted")
        if room == "how-to" and len(lines) > LONGEST_HOW_TO:
            violations.append(f"{name}: {len(lines)} lines; a page of how-to has at most {LONGEST_HOW_TO}")
        if prose > LONGEST_PROSE and not shown:
            violations.append(f"{name}: {prose} lines of prose without a picture, a table or code")
if {path.name for path in (ROOT / "docs").iterdir() if path.is_dir()} != {*ROOMS, "pictures", "site"}:
    violations.append(f"docs/ has other folders than {', '.join(ROOMS)}, pictures and site")
if violations:
    sys.exit("\n".join(violations))
print("pages have the shape of their rooms")
