#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a header offers and nobody asks for is not compiled: a decomposition of Eigen's stands in templates only.

A compiler writes out what a function names, and all that this names in turn, when it has read the function, called or not; of a template it does so where
it is called. Eigen's decompositions are seconds each, so including a header with one in a plain function would cost them.
"""
import pathlib
import re
import sys

include = pathlib.Path(__file__).parents[2] / "include" / "qdot"
costly = re.compile(
    r"Eigen::(?:FullPivLU|PartialPivLU|ColPivHouseholderQR|FullPivHouseholderQR|HouseholderQR|CompleteOrthogonalDecomposition|JacobiSVD|BDCSVD|LLT|LDLT"
    r"|ComplexSchur|RealSchur|EigenSolver|ComplexEigenSolver|SelfAdjointEigenSolver|GeneralizedSelfAdjointEigenSolver|LevenbergMarquardt|HybridNonLinearSolver)<[^;{]*[({]"
    r"|\.(?:llt|ldlt|lu|fullPivLu|partialPivLu|colPivHouseholderQr|householderQr|jacobiSvd|bdcSvd|eigenvalues)\(\)|\b(?:exponents_of|shortest_step)\(")
trouble = []
for path in sorted([*include.rglob("*.hpp"), *include.rglob("*.ipp")]):
    beginning, is_template = 0, False  # of the declaration at namespace scope
    for number, line in enumerate(path.read_text().split("\n"), 1):
        code = line.split("//")[0]
        if re.match(r"[A-Za-z\[]", code) and not re.match(r"(namespace|using|public|private|protected|requires)\b", code):
            if code.startswith("template"):
                beginning, is_template = number, True
            elif not (is_template and number - beginning <= 4):
                beginning, is_template = number, False
        elif re.match(r"\}", code):
            beginning, is_template = number, False
        if costly.search(code) and not is_template:
            trouble.append(f"{path.relative_to(include.parent)}:{number}: {line.strip()[:120]}")
for each in trouble:
    print(each)
if trouble:
    print("Let what holds these be a template, `template <class = void>  // compiled only where it is called`, and what calls it as well.")
sys.exit(1 if trouble else 0)
