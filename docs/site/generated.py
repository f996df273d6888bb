#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pages of the reference that repeat what stands elsewhere: docs/reference/results.md (from the headers that qdot.hpp names and their docstrings), and, of the
program, docs/reference/options.md (from `--help`) and docs/reference/scenes.md (from `list`).

    docs/site/generated.py [PROGRAM]            writes them; without a program the first
    docs/site/generated.py --check [PROGRAM]    status 1 where they differ from what it would write
"""

import os
import pathlib
import re
import subprocess
import sys
import textwrap

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import headers  # noqa: E402

ROOT = headers.ROOT
LAYERS = {"ad": "Differentiation", "mechanics": "Mechanics", "effects": "Effects", "integrate": "Motion", "analysis": "Analysis", "report": "Report"}
NOTE = "Written by `docs/site/generated.py build/run/qdot`; a test compares."


def said(program, *arguments):
    environment = dict(os.environ, COLUMNS="160", LC_ALL="C.UTF-8")
    return subprocess.run([program, *arguments], capture_output=True, text=True, encoding="utf-8", check=True, env=environment, cwd=ROOT).stdout.rstrip("\n")


def wrapped(text):
    """Lines of at most 116 columns; what goes on is indented as the words of an option are."""
    lines = []
    for line in text.split("\n"):
        words = re.match(r"( {2}\S.*? {2,})\S|( *)", line)
        indent = " " * min(len(words[1]) if words[1] else len(words[2]) + 4, 40)
        lines += textwrap.wrap(line, 116, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False, replace_whitespace=False) or [line]
    return "\n".join(lines)


def options(program):
    """One section for each command."""
    help_text = said(program, "--help")
    commands = re.findall(r"^  ([a-z_]+) {2,}", help_text.partition("Subcommands:")[2], re.M)
    if len(commands) < 10:
        sys.exit(f"Only {len(commands)} commands in `qdot --help`")
    sections = [f"# Options of the commands\n\n{NOTE} What the commands are for: [commands](commands.md).\n\n```text\n{wrapped(help_text)}\n```\n"]
    for command in commands:
        if command != "bench":  # the project's own, which another program runs
            sections.append(f"## {command}\n\n```text\n{wrapped(said(program, command, '--help'))}\n```\n")
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
        about.append(f"### {name}\n\n{summary}\n" + ("\n```text\n" + wrapped("\n".join(energies)) + "\n```\n" if energies else ""))
    if len(rows) < 20:
        sys.exit(f"Only {len(rows)} scenes in `qdot list`")
    return (f"# Scenes and methods\n\n{NOTE} `qdot list NAME` prints units, ranges and meanings of the parameters too; the gallery of the site has the motions.\n\n"
            "| scene | is | coordinates | parameters, `--set NAME=VALUE` | effects, `--with NAME=VALUE` |\n|---|---|---|---|---|\n" + "\n".join(rows) + "\n\n"
            "## Methods\n\nWhich to take: [how to choose](../explanation/choose.md).\n\n```text\n" + methods + "\n```\n\n## What they are\n\n" + "\n".join(about))


def cell(text):
    return re.sub(r"\s+", " ", text).replace("|", "\\|").strip()


def sentence(doc):
    """The first sentence of a docstring, and what it returns."""
    lines = [line.strip() for line in doc.split("\n")]
    prose = " ".join(lines[:next((i for i, line in enumerate(lines) if line.startswith("@") or not line), len(lines))])
    returned = re.search(r"@return\s+(.*?)(?=\n\s*@|\n\s*\n|\Z)", doc, re.S)
    return re.split(r"(?<=[a-z0-9)²])\.\s", prose + " ", maxsplit=1)[0].strip().rstrip("."), returned[1] if returned else ""


def returned_type(declaration):
    signature = re.sub(r"\s+", " ", declaration.signature)
    match = re.search(r"([\w:]+(?:<.*>)?(?: const)?[&*]?) " + re.escape(declaration.name) + r"\(", re.sub(r"^template <.*?> (?=[\w\[])", "", signature))
    found = match[1].removeprefix("constexpr ").removeprefix("inline ") if match else "auto"
    return "" if found.startswith(("auto", "decltype")) else found


def said_of_lines():
    """What functions.md says that comes back, by the function that its line calls."""
    found = {}
    for line in (ROOT / "docs" / "reference" / "functions.md").read_text(encoding="utf-8").splitlines():
        cells = re.split(r"(?<!\\)\|", line)
        if len(cells) == 6 and (match := re.match(r" `\w+ = ([\w:]+?)(?:<[^()]*>)?\(", cells[2])):
            found.setdefault(match[1].rpartition("::")[2], cells[3].strip())
    return found


def results():
    """For each user header its functions, each with what comes back: its type, and the members of that."""
    pages = headers.pages()
    members, lines = {}, said_of_lines()
    for header, _, rooms in pages:
        for declaration in [*header.declarations, *(d for room in rooms for d in room.declarations)]:
            if declaration.kind == "class":
                names = [m.name for m in declaration.members if m.kind == "variable" and not m.name.endswith("_") and "static" not in m.signature]
                members[declaration.name] = members.get(declaration.name) or names
    text, rows = ["# Functions and what comes back, by header\n", f"Written by `docs/site/generated.py` from the headers; a test compares. Lines of code to begin with are in "
                  "[functions](functions.md). Members are those of the type that comes back; methods are on the pages of the headers.\n"], 0
    for layer, title in LAYERS.items():
        text.append(f"## {title}\n\n| function | is | comes back | header |\n|---|---|---|---|")
        for header, about, _ in pages:
            if header.path.split("/")[0] != layer or about.startswith("deprecated"):
                continue
            seen = {}
            for d in header.declarations:
                if d.kind == "function" and re.match(r"[a-z]\w*$", d.name) and "[[deprecated" not in d.signature and "= delete" not in d.signature and not returned_type(d) == "void":
                    seen.setdefault(d.scope + d.name, []).append(d)
            if layer == "ad" and header.path != "ad/derivatives.hpp":  # the functions of <cmath>, for other numbers
                continue
            for name, overloads in seen.items():
                is_, back = next((sentence(d.doc) for d in overloads if d.doc), ("", ""))
                types = list(dict.fromkeys(t for t in map(returned_type, overloads) if t))
                shown = ", ".join(f"`{t}`" for t in types[:2])
                listed = next((members[t] for t in (re.match(r"[\w:]*", t)[0].rpartition("::")[2] for t in types) if members.get(t)), [])
                shown += (": " if shown and listed else "") + ", ".join(f"`.{m}`" for m in listed)
                if back:
                    shown += (("; " if listed else ", ") if shown else "") + back.strip().rstrip(".")
                shown = cell(shown)
                if not listed and name in lines:  # auto, or a type whose members a base has
                    shown = lines[name] if not types else f"`{cell(types[0])}`: {lines[name]}" if lines[name].startswith("`.") else shown
                text.append(f"| `{name}` | {cell(is_)} | {shown} | [`{header.path}`](../../include/qdot/{header.path}) |")
                rows += 1
        text.append("")
    if rows < 150:
        sys.exit(f"Only {rows} functions in the headers: where are the others?")
    return "\n".join(text)


def words_of(text):
    """What is compared: tables and what is indented, without spaces, for versions of CLI11 differ in headings and in where they break lines."""
    return re.sub(r"\s", "", "".join(re.findall(r"^(?:\||  ).*", text, re.M)))


def main():
    check = "--check" in sys.argv
    programs = [pathlib.Path(argument).resolve() for argument in sys.argv[1:] if argument != "--check"]
    made = {"results": results()}
    if programs:
        made |= {"options": options(programs[0]), "scenes": scenes(programs[0])}
    differ = []
    for name, text in made.items():
        page, text = ROOT / "docs" / "reference" / f"{name}.md", text.rstrip("\n") + "\n"
        if not check:
            page.write_text(text, encoding="utf-8")
        elif not page.exists() or words_of(page.read_text(encoding="utf-8")) != words_of(text):
            differ.append(f"docs/reference/{name}.md")
    if differ:
        sys.exit(f"{', '.join(differ)}: not what docs/site/generated.py writes; run it, with the program where it is one of its pages")
    print(f"{', '.join(made)} {'are up to date' if check else 'written'}")


main()
