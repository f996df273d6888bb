#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pages of the reference that repeat what the program says: docs/reference/options.md (from `--help`) and docs/reference/scenes.md (from `list`).

    docs/site/generated.py PROGRAM            writes them
    docs/site/generated.py --check PROGRAM    status 1 where they differ from what it would write
"""

import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
NOTE = "Written by `docs/site/generated.py build/run/qdot`; a test compares."


def said(program, *arguments):
    environment = dict(os.environ, COLUMNS="160", LC_ALL="C.UTF-8")
    return subprocess.run([program, *arguments], capture_output=True, text=True, encoding="utf-8", check=True, env=environment, cwd=ROOT).stdout.rstrip("\n")


def options(program):
    """One section for each command."""
    help_text = said(program, "--help")
    commands = re.findall(r"^  ([a-z_]+) {2,}", help_text.partition("Subcommands:")[2], re.M)
    if len(commands) < 10:
        sys.exit(f"Only {len(commands)} commands in `qdot --help`")
    sections = [f"# Options of the commands\n\n{NOTE} What the commands are for: [commands](commands.md).\n\n```text\n{help_text}\n```\n"]
    for command in commands:
        if command != "bench":  # the project's own, which another program runs
            sections.append(f"## {command}\n\n```text\n{said(program, command, '--help')}\n```\n")
    return "\n".join(sections)


def scenes(program):
    """A table of the catalogue, what each scene is, and the methods by name."""
    catalogue, methods = said(program, "list").split("\n\n")[:2]
    rows, about = [], []
    for line in catalogue.splitlines()[1:]:
        name, dof, rest = re.fullmatch(r"(\w+) +(\S+) *(.*)", line).groups()
        parameters, _, effects = rest.partition("[")
        found = said(program, "list", name)
        head, _, body = found.partition("\n\n")
        title, summary = head.splitlines()[0].partition(": ")[2] or name, " ".join(head.splitlines()[1:])
        energies = [text.strip() for text in body.partition("parameters,")[0].splitlines() if text.strip()]
        rows.append(f"| [`{name}`](#{name}) | {title} | {dof} | `{parameters.strip()}` | {', '.join(f'`{e.strip(chr(91) + chr(93))}`' for e in effects.split()) if effects else ''} |")
        about.append(f"### {name}\n\n{summary}\n" + ("\n```text\n" + "\n".join(energies) + "\n```\n" if energies else ""))
    if len(rows) < 20:
        sys.exit(f"Only {len(rows)} scenes in `qdot list`")
    return (f"# Scenes\n\n{NOTE} `qdot list NAME` prints units, ranges and meanings of the parameters too; the gallery of the site has the motions.\n\n"
            "| scene | is | coordinates | parameters, `--set NAME=VALUE` | effects, `--with NAME=VALUE` |\n|---|---|---|---|---|\n" + "\n".join(rows) + "\n\n"
            "## Methods\n\nWhich to take: [how to choose](../explanation/choose.md).\n\n```text\n" + methods + "\n```\n\n## What they are\n\n" + "\n".join(about))


def words_of(text):
    """What is compared: tables and what is indented, without spaces, for versions of CLI11 differ in headings and in where they break lines."""
    return re.sub(r"\s", "", "".join(re.findall(r"^(?:\||  ).*", text, re.M)))


def main():
    check = "--check" in sys.argv
    program = pathlib.Path([argument for argument in sys.argv[1:] if argument != "--check"][0]).resolve()
    differ = []
    for name, make in (("options", options), ("scenes", scenes)):
        page, text = ROOT / "docs" / "reference" / f"{name}.md", make(program).rstrip("\n") + "\n"
        if not check:
            page.write_text(text, encoding="utf-8")
        elif not page.exists() or words_of(page.read_text(encoding="utf-8")) != words_of(text):
            differ.append(f"docs/reference/{name}.md")
    if differ:
        sys.exit(f"{', '.join(differ)} differ from what the program says: docs/site/generated.py PROGRAM writes them")
    print("pages that repeat the program are what it says" if check else "written")


main()
