#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Relative links of the pages lead to files that are there, and to headings that they have; docs/README.md leads to all pages of docs/."""

import pathlib
import re
import sys

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "site"))
import links  # noqa: E402

violations, checked = [], 0
for page in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]:
    text = page.read_text(encoding="utf-8")
    for start, end in links.links_of(text):
        target = text[start:end]
        if re.match(r"[a-z]+:", target):
            continue
        checked += 1
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        place = f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, start) + 1}: {target}"
        if not file.exists():
            violations.append(f"{place}: no such file")
        elif anchor and file.suffix == ".md" and anchor not in links.anchors_of(file.read_text(encoding="utf-8")):
            violations.append(f"{place}: no such heading")
index = ROOT / "docs" / "README.md"
text = index.read_text(encoding="utf-8")
named = {(index.parent / text[start:end].partition("#")[0]).resolve() for start, end in links.links_of(text)}
violations += [f"{page.relative_to(ROOT)}: docs/README.md does not name it" for page in sorted(index.parent.rglob("*.md")) if page not in named and page != index]
if checked < 100:
    sys.exit(f"Only {checked} links in all pages: does links.py still find them?")
if violations:
    sys.exit("Links that lead nowhere:\n  " + "\n  ".join(violations))
print(f"{checked} links lead somewhere")
