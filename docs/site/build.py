#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The site, from what is in the repository and from what the program says:

    docs/site/build.py --program build/run/qdot --out build/site

collects pages (those of docs/ in the rooms that docs/README.md gives them, a page for each example, scene and header) in OUT-pages, links
rewritten to where things are there, and has Sphinx make HTML of them. A link that leads nowhere and every warning of Sphinx is an error.
"""

import argparse
import html
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
sys.dont_write_bytecode = True
import api  # noqa: E402
import headers  # noqa: E402
import links  # noqa: E402

ROOT = headers.ROOT
SITE = ROOT / "docs" / "site"
ROOMS = {"Tutorials": "tutorials", "How-to": "how-to", "Reference": "reference", "Explanation": "explanation", "Measurements": "lab"}


def rooms():
    """The rooms of docs/README.md: heading → (what is said first, [(group, [(page, relative to docs/, without .md; what is said of it)])])."""
    text = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    found = {}
    for heading, body in re.findall(r"^## ([^\n]*)\n(.*?)(?=^## |\Z)", text, re.S | re.M):
        lead = re.split(r"^(?:- |### )", body, maxsplit=1, flags=re.M)[0].strip()
        groups = []
        for part in re.split(r"^(?=### )", body, flags=re.M):
            title = re.match(r"### ([^\n]*)", part)
            pages = re.findall(r"^- \[[^\]]*\]\(([\w/-]+)\.md\)(?:: )?([^\n]*)", part, re.M)
            if pages:
                groups.append((title[1] if title else "", pages))
        found[heading] = (lead, groups)
        if strangers := [name for _, pages in groups for name, _ in pages if not name.startswith(f"{ROOMS.get(heading)}/")]:
            sys.exit(f"docs/README.md has {', '.join(strangers)} under {heading}")
    if list(found) != list(ROOMS):
        sys.exit(f"docs/README.md has the rooms {', '.join(found)}; the site has {', '.join(ROOMS)}")
    return found


class Pages:
    """Pages in a folder, and where the files of the repository are among them."""

    def __init__(self, folder):
        self.folder = folder
        self.files = set()  # of the repository, which pages show as they are
        shutil.rmtree(folder, ignore_errors=True)
        (folder / "extra").mkdir(parents=True)
        (folder / "pictures").mkdir()
        self.user_headers = {path for path, _ in headers.user_headers()}
        self.rooms = rooms()
        self.named = {name for _, groups in self.rooms.values() for _, named in groups for name, _ in named}
        self.scenes = set()  # that have a page in the gallery

    def write(self, path, text):
        place = self.folder / path
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text.rstrip("\n") + "\n", encoding="utf-8")

    # The page, relative to the folder, that has a file of the repository; None for a folder.
    def page_of(self, file):
        relative = file.relative_to(ROOT).as_posix()
        if file.is_dir():
            return None
        if relative in ("README.md", "docs/README.md"):
            return "index.md" if relative.startswith("docs/") else "readme.md"
        if match := re.fullmatch(r"docs/([\w/-]+)\.md", relative):
            if match[1] not in self.named:
                sys.exit(f"docs/README.md does not name {relative}")
            return match[1] + ".md"
        if (match := re.fullmatch(r"src/scenes/(\w+)\.hpp", relative)) and match[1] in self.scenes:
            return f"gallery/{match[1]}.md"
        if match := re.fullmatch(r"include/qdot/(.*)\.hpp", relative):
            if match[1] + ".hpp" in self.user_headers:
                return f"api/{match[1]}.md"
            if match[1] == "qdot":
                return "api/index.md"
        if match := re.fullmatch(r"examples/(\d\d_\w+)\.(cpp|txt)", relative):
            return f"examples/{match[1]}.md"
        if relative in ("CONTRIBUTING.md", "CHANGELOG.md"):
            return relative.lower()
        if relative.endswith((".svg", ".png")) and relative.startswith("docs/"):
            shutil.copy(file, self.folder / "pictures")
            return "pictures/" + file.name
        self.files.add(file)
        return "files/" + relative + ".md"

    # A text of the repository as one of the page, its links led to pages.
    def moved(self, text, source, page):
        # Formulas as a code host has them, as MyST has them.
        text = re.sub(r"\$`([^`\n]+)`\$", r"{math}`\1`", text.replace("\n```math\n", "\n```{math}\n"))
        pieces, at = [], 0
        for start, end in links.links_of(text):
            target = text[start:end]
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            if not path:
                if anchor not in links.anchors_of(text):
                    sys.exit(f"{source.relative_to(ROOT)}: no heading '{anchor}' for the link {target}")
                continue
            file = (source.parent / path).resolve()
            if not file.exists():
                sys.exit(f"{source.relative_to(ROOT)}: the link {target} leads nowhere")
            there = self.page_of(file)
            if there is None:  # a folder: the words stay, the link goes
                opening = text.rindex("[", at, start)
                pieces += [text[at:opening], text[opening + 1:start - 2]]
                at = end + 1
                continue
            pieces += [text[at:start], os.path.relpath(there, pathlib.PurePath(page).parent) + ("#" + anchor if anchor else "")]
            at = end
        return "".join(pieces) + text[at:]

    def add(self, source, page, text=None):
        self.write(page, self.moved(source.read_text(encoding="utf-8") if text is None else text, source, page))


def toctree(entries, caption="", hidden=False, depth=1):
    options = f":maxdepth: {depth}\n" + (f":caption: {caption}\n" if caption else "") + (":hidden:\n" if hidden else "")
    return "```{toctree}\n" + options + "\n" + "\n".join(entries) + "\n```\n"


def add_examples(pages):
    shutil.copytree(ROOT / "examples", pages.folder / "include_only" / "examples")
    names = []
    for source in sorted((ROOT / "examples").glob("*.cpp")):
        name = source.stem
        opening = re.match(r"// SPDX[^\n]*\n//\n((?://[^\n]*\n)+)", source.read_text(encoding="utf-8"))[1]
        words = " ".join(line[2:].strip() for line in opening.splitlines())
        title = name[3:].replace("_", " ").capitalize()
        pages.write(f"examples/{name}.md", f"# {title}\n\n{api.markdown.prose(words)}\n\n```{{literalinclude}} /include_only/examples/{name}.cpp\n:language: cpp\n```\n\n"
                    f"It prints, and a test sees to it that it does,\n\n```{{literalinclude}} /include_only/examples/{name}.txt\n:language: text\n```\n")
        names.append(name)
    pages.write("examples/index.md", "# Examples\n\nEach is one file in `examples/` of 40 to 90 lines. They are compiled and run by every test of the project, and what they print "
                "is compared with what stands here.\n\n" + toctree(names))


def said(program, *arguments):
    run = subprocess.run([program, *arguments], capture_output=True, text=True, cwd=ROOT)
    return run.stdout if run.returncode == 0 else None


def add_gallery(pages, program):
    listed = said(program, "list").split("\n\n")[0].splitlines()[1:]
    motions = pages.folder / "extra" / "motions"
    motions.mkdir()
    cards, names, shown_scenes = [], [], set()
    for name in (line.split()[0] for line in listed):
        about = said(program, "list", name)
        title = about.splitlines()[0].partition(": ")[2] or name
        lead, _, _ = about.partition("\n\n")
        lead = " ".join(lead.splitlines()[1:])
        subprocess.run([program, "run", name, "--quiet", "--out", motions / name], check=True, capture_output=True)
        for ending in ("csv", "npz"):
            (motions / f"{name}.{ending}").unlink()
        (motions / f"{name}.svg").rename(pages.folder / "pictures" / f"{name}_motion.svg")
        shutil.copy(pages.folder / "pictures" / f"{name}_motion.svg", motions / f"{name}.svg")
        equations = said(program, "equations", name, "--mathml")
        plain = said(program, "equations", name)
        if equations:
            equations = re.sub(r">\s*\n\s*<", "><", equations)  # an empty line would end the block of HTML
            shown = f"## Equations\n\n<div class=\"equations\">{equations}</div>\n\nFrom `qdot equations {name}`; with `--latex` for a paper, with `--c FILE` as a C function."
        else:
            shown = f"## Equations\n\nThis scene has none that could be written as formulas without branches: see `qdot equations {name}`."
        source = ROOT / "src" / "scenes" / f"{name}.hpp"
        where = f" Its source is [src/scenes/{name}.hpp]({os.path.relpath(pages.page_of(source), 'gallery')})." if source.exists() else ""
        shown_scenes.add(name)
        body = about.partition("\n\n")[2]
        pages.write(f"gallery/{name}.md", f"""# {title}

{api.markdown.prose(lead)}

<iframe class="motion" src="../motions/{name}.html" title="{html.escape(title)}: the motion" loading="lazy"></iframe>

<a href="../motions/{name}.html">The same on a page of its own</a>, made by

```console
$ ./run run {name} --out out/{name}
```

{shown}

## What can be set

```text
{body.strip(chr(10))}
```

{where}
""")
        cards.append(f'<a href="{name}.html"><img src="../motions/{name}.svg" alt="" loading="lazy"><span>{html.escape(title)}</span></a>')
        names.append(name)
    pages.write("gallery/index.md", "# Gallery\n\nThe scenes of the catalogue, each simulated by the program while this site was built. `./run list` names them, too.\n\n"
                f"<div class=\"gallery\">{''.join(cards)}</div>\n\n" + toctree(names, hidden=True))
    pages.scenes = shown_scenes  # from now on links to sources of scenes lead to their pages
    return len(names)


def add_docs(pages):
    for source in sorted((ROOT / "docs").rglob("*.md")):
        if source != ROOT / "docs" / "README.md":
            pages.add(source, pages.page_of(source))
    hidden = []
    for heading, (lead, groups) in pages.rooms.items():
        folder = ROOMS[heading]
        parts = [f"# {heading}\n", lead + "\n" if lead else ""]
        for title, named in groups:
            parts.append(f"## {title}\n" if title else "")
            parts.append(toctree([name.rpartition("/")[2] for name, _ in named]))
        pages.write(f"{folder}/index.md", "\n".join(parts))
        hidden.append(f"{folder}/index")
        if heading == "Tutorials":
            hidden += ["examples/index"]
        if heading == "Reference":
            hidden += ["api/index", "gallery/index"]
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    pages.add(ROOT / "docs" / "README.md", "index.md", re.sub(r"^# .*", "# qdot", index, count=1)
              + "\nThe {doc}`gallery <gallery/index>` shows the scenes of the program, each with its animation, its equations and the command that made it.\n\n"
              + toctree(["readme", *hidden, "files/index", "contributing", "changelog"], hidden=True))
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        pages.add(ROOT / name, name.lower())
    for name in ("conf.py", "mathml.py"):
        shutil.copy(SITE / name, pages.folder)
    shutil.copytree(SITE / "static", pages.folder / "static")


def add_files(pages):
    shown = []
    for file in sorted(pages.files):
        relative = file.relative_to(ROOT).as_posix()
        language = {".cpp": "cpp", ".hpp": "cpp", ".py": "python", ".sh": "bash", ".cmake": "cmake"}.get(file.suffix, "text")
        copied = pages.folder / "include_only" / "files" / relative
        copied.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, copied)
        pages.write(f"files/{relative}.md", f"# {api.markdown.escaped(relative)}\n\n```{{literalinclude}} /include_only/files/{relative}\n:language: {language}\n```\n")
        shown.append(relative)
    pages.write("files/index.md", "# Files\n\nFiles of the repository that pages refer to.\n\n" + toctree(shown))


# A Python that has what apt-get installs need not be the first on the path.
def python_with_sphinx():
    for python in (sys.executable, "python3", "/usr/bin/python3"):
        if shutil.which(python) and subprocess.run([python, "-c", "import sphinx, myst_parser, furo"], capture_output=True).returncode == 0:
            return python
    sys.exit("The site needs Sphinx, MyST and furo: sudo apt-get install python3-sphinx python3-myst-parser furo, or pip install sphinx myst-parser furo")


def version():
    numbers = re.findall(r"int version_[a-z]+ = ([0-9]+);", (ROOT / "include/qdot/version.hpp").read_text())
    return ".".join(numbers)


# Debian's furo comes with its scripts as they were written, not as they are bundled: a page's script cannot import another.
def bundle_theme(out):
    script, imported = out / "_static/scripts/furo.js", out / "_static/scripts/gumshoe-patched.js"
    if script.exists() and imported.exists():
        text = script.read_text(encoding="utf-8")
        bundled = re.sub(r'^import Gumshoe from "\./gumshoe-patched\.js";\n', lambda _: imported.read_text(encoding="utf-8"), text)
        script.write_text(bundled, encoding="utf-8")


# What is read without a network may ask for nothing from one.
def foreign(out):
    for file in [*out.rglob("*.html"), *out.rglob("*.css")]:
        text = file.read_text(encoding="utf-8")
        for match in re.finditer(r"<(?:script|img|iframe|source)\b[^>]*\bsrc=[\"']?(?:https?:)?//[^\"'> ]+|<link\b[^>]*rel=[\"']?(?:stylesheet|preload|icon)[^>]*href=[\"']?(?:https?:)?//[^\"'> ]+"
                                 r"|@import[^;]*//[^;]*|url\([\"']?(?:https?:)?//[^)]*\)", text):
            yield f"{file.relative_to(out)}: {match.group()[:100]}"


def main():
    parser = argparse.ArgumentParser(description="builds the site")
    parser.add_argument("--program", required=True, type=pathlib.Path, help="qdot, which draws the gallery")
    parser.add_argument("--out", required=True, type=pathlib.Path, help="folder to be made")
    given = parser.parse_args()
    python = python_with_sphinx()
    out, begun = given.out.resolve(), time.monotonic()
    pages = Pages(out.with_name(out.name + "-pages"))
    add_examples(pages)
    scenes = add_gallery(pages, given.program.resolve())
    add_docs(pages)
    names = api.add_to(pages)
    add_files(pages)
    count = len(list(pages.folder.rglob("*.md")))

    shutil.rmtree(out, ignore_errors=True)
    environment = dict(os.environ, QDOT_SITE_SOURCE=str(pages.folder), QDOT_VERSION=version())
    environment.pop("PYTHONHOME", None)
    result = subprocess.run([python, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q", "-j", "2", "-d", str(pages.folder / "doctrees"),
                             str(pages.folder), str(out)], env=environment)
    if result.returncode != 0:
        sys.exit("The site has warnings, which are errors.")
    shutil.rmtree(pages.folder / "doctrees", ignore_errors=True)
    bundle_theme(out)
    needs = list(foreign(out))
    if needs:
        sys.exit("Pages need a network:\n  " + "\n  ".join(needs[:20]))
    print(f"{count} pages ({scenes} scenes, {names} public names) in {time.monotonic() - begun:.0f} s: {out / 'index.html'}")


if __name__ == "__main__":
    main()
