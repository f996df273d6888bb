#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The moving picture of README, docs/pictures/double_pendulum.svg: what the program draws, with its rods, bobs and a cursor set in motion.

    docs/site/moving.py PROGRAM
"""

import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile

PICTURE = pathlib.Path(__file__).resolve().parents[1] / "pictures" / "double_pendulum.svg"
SECONDS, FRAMES = 8.0, 20  # of the motion; in a second


def angles(path):
    """θ₁ and θ₂ at each frame, linear between the rows of the table."""
    rows = [[float(cell) for cell in row[:3]] for row in list(csv.reader(path.open(encoding="utf-8")))[1:]]
    k = 0
    for frame in range(int(SECONDS * FRAMES) + 1):
        t = min(frame / FRAMES, rows[-1][0])
        while rows[k + 1][0] < t:
            k += 1
        share = (t - rows[k][0]) / (rows[k + 1][0] - rows[k][0])
        yield tuple(a + share * (b - a) for a, b in zip(rows[k][1:], rows[k + 1][1:]))


def animate(attribute, values):
    return f'<animate attributeName="{attribute}" dur="{SECONDS:g}s" repeatCount="indefinite" values="{";".join(values)}"/>'


def main():
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "motion"
        subprocess.run([sys.argv[1], "run", "double_pendulum", "--t-end", f"{SECONDS:g}", "--quiet", "--out", out], check=True, stdout=subprocess.DEVNULL)
        svg, frames = out.with_suffix(".svg").read_text(encoding="utf-8"), list(angles(out.with_suffix(".csv")))
    # A pivot, and behind it the bobs, which end the rods.
    (pivot, inner, _) = circles = list(re.finditer(r'<circle cx="([\d.]+)" cy="([\d.]+)"[^>]*/>', svg))
    x, y = float(pivot[1]), float(pivot[2])
    length = math.hypot(float(inner[1]) - x, float(inner[2]) - y)
    places = []
    for first, second in frames:
        a = (x + length * math.sin(first), y + length * math.cos(first))
        places.append((a, (a[0] + length * math.sin(second), a[1] + length * math.cos(second))))
    for bob in (1, 2):
        moving = animate("cx", (f"{p[bob - 1][0]:.1f}" for p in places)) + animate("cy", (f"{p[bob - 1][1]:.1f}" for p in places))
        svg = svg.replace(circles[bob][0], circles[bob][0][:-2] + f">{moving}</circle>")
    rods = re.search(r'<path d="[^"]*" style="[^"]*stroke:var\(--ink\)"/>', svg)[0]
    svg = svg.replace(rods, rods[:-2] + ">" + animate("d", (f"M{x:.1f} {y:.1f}L{a[0]:.1f} {a[1]:.1f}L{b[0]:.1f} {b[1]:.1f}" for a, b in places)) + "</path>")
    left, right, above, below = re.search(r'data-time="([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) ', svg).groups()
    cursor = f'<path class="cursor" d="M{left} {above}V{below}"><animateTransform attributeName="transform" type="translate" from="0" to="{float(right) - float(left):g}" ' \
             f'dur="{SECONDS:g}s" repeatCount="indefinite"/></path>'
    frame = re.search(r'<path class="frame"', svg)
    PICTURE.write_text(svg[:frame.start()] + cursor + "\n" + svg[frame.start():], encoding="utf-8")


main()
