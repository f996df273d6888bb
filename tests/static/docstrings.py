#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A public name of a user header has a docstring. What a public name is, is in docs/site/headers.py, which makes the pages of the site."""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "docs" / "site"))
import headers  # noqa: E402

violations, names = [], 0


def count(declarations):
    return sum(1 + count(d.members) for d in declarations)


for path, _ in headers.user_headers():
    header = headers.read(path)
    names += count(header.declarations)
    violations += [f"{path}:{line}: {name}" for name, line in headers.undocumented(header.declarations)]
if names < 1000:
    sys.exit(f"Only {names} public names in all headers that users include: does headers.py still read them?")
if violations:
    sys.exit("Public names without a docstring (///, or ///< behind):\n  " + "\n  ".join(violations))
print(f"{names} public names have docstrings")
