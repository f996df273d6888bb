# SPDX-License-Identifier: MIT
"""The reference: a page for each header that users include, its essay first, then its public names as they are declared, with their docstrings."""

import re

import headers
import markdown

LAYERS = {"": "Errors and version", "ad": "Differentiation", "mechanics": "Mechanics", "effects": "Effects", "integrate": "Motion", "analysis": "Analysis", "report": "Report"}
KINDS = {"class": "class", "enum": "enumeration", "function": "function", "variable": "variable", "alias": "type", "concept": "concept"}


def label_of(path, name, kind):
    group = "type" if kind in ("class", "enum", "alias", "concept") else "name"
    return "api-" + re.sub(r"[^a-z0-9]+", "-", f"{path[:-4]} {group} ".lower()) + re.sub(r"[^a-z0-9]+", lambda m: "-".join(str(ord(c)) if c not in " _:" else "" for c in m[0]) or "-", name.lower())


def header_label(path):
    return "api-" + re.sub(r"[^a-z0-9]+", "-", path[:-4].lower())


# A declaration in one line, for members.
def line_of(signature):
    return re.sub(r"\s+", " ", signature).strip()


class Reference:
    def __init__(self, pages):
        self.pages = pages
        self.headers = headers.pages()
        self.labels = {}  # of names at namespace level: name → {label}
        self.paths = {header.path for header, _, _ in self.headers}
        for header, _, rooms in self.headers:
            for declaration in self.shown(header, rooms):
                self.labels.setdefault(declaration.name, set()).add(label_of(header.path, declaration.scope + declaration.name, declaration.kind))

    # Names of rooms are shown where they are in namespace qdot itself and say something: they reach users by this header.
    def shown(self, header, rooms):
        declared = [d for d in header.declarations if not d.is_special]
        for room in rooms:
            declared += [d for d in room.declarations if not d.is_special and d.scope in ("", "inertia::", "report::") and d.kind in KINDS and d.doc]
        return declared

    def link_from(self, page):
        def link(word):
            if word.endswith(".hpp"):
                word = word.removeprefix("qdot/")
                here = word if word in self.paths else next((p for p in self.paths if p.endswith("/" + word)), None)
                return header_label(here) if here else None
            name = re.match(r"[\w:]+", word.removeprefix("qdot::"))
            found = self.labels.get(name[0], ()) if name else ()
            return next(iter(found)) if len(found) == 1 else None

        return link

    # Overloads one under the other; the first docstring is that of all which have none.
    def member(self, members, link):
        first, entries = members[0], []
        doc = next((m.doc for m in members if m.doc), "")
        for member in members:
            if member.doc or (doc and member is first):
                said = markdown.docstring(member.doc or doc, link)
            elif doc:
                said = "As above, for these arguments."
            else:
                said = headers.role_of(first.name, first.in_class) or ("Constructor." if first.is_special else "…")
            entries.append(f"`` {line_of(member.signature)} ``\n\n:   " + said.replace("\n", "\n    ") + "\n")
        return "\n".join(entries)

    def group(self, path, declarations, link):
        first = declarations[0]
        name = first.scope + first.name
        kinds = {d.kind for d in declarations}
        lines = [f"```{{index}} single: {name}\n```\n" if not name.startswith("operator") else "", f"({label_of(path, name, first.kind)})=", f"### {markdown.escaped(name)}\n"]
        shown = 0
        for declaration in declarations:
            lines.append(f"```{{code-block}} cpp\n{declaration.signature}\n```\n")
            if declaration.doc:
                lines.append(markdown.docstring(declaration.doc, link) + "\n")
            members, groups = [m for m in declaration.members if not m.name.startswith("~")], {}
            for member in members:
                member.in_class = declaration.name
                together = member.line if member.kind == "variable" else 0  # "std::string hits, rests" is one entry
                groups.setdefault((together, "" if together else member.name), []).append(member)
            for group in groups.values():
                lines.append(self.member(group[:1] if group[0].kind == "variable" else group, link))
                shown += len(group)
        return "\n".join(lines), shown + 1

    def page(self, header, title, rooms):
        page = f"api/{header.path[:-4]}.md"
        link = self.link_from(page)
        lines = [f"({header_label(header.path)})=", f"# {markdown.escaped(header.path)}\n", f"{markdown.prose((title[0].upper() if title[0].isascii() else title[0]) + title[1:])}.\n", f"```{{code-block}} cpp\n#include <qdot/{header.path}>\n```\n"]
        lines.append(markdown.essay(header.essay, link) + "\n")
        groups = {}
        for declaration in self.shown(header, rooms):
            groups.setdefault((declaration.scope + declaration.name, declaration.kind in ("class", "enum", "alias", "concept")), []).append(declaration)
        if groups:
            lines.append("## Names\n")
        count = 0
        for group in groups.values():
            text, shown = self.group(header.path, group, link)
            lines.append(text)
            count += shown
        self.pages.write(page, "\n".join(lines))
        return [d[0].scope + d[0].name for d in groups.values()], count


def add_to(pages):
    """Writes all pages; the number of names on them."""
    reference = Reference(pages)
    total, layers = 0, {}
    for header, title, rooms in reference.headers:
        names, count = reference.page(header, title, rooms)
        total += count
        layer = header.path.rpartition("/")[0]
        layers.setdefault(layer, []).append((header.path, title, names))
    for layer, rows in layers.items():
        table = ["| header | |", "|---|---|"]
        for path, title, names in rows:
            table.append(f"| [`{path.rpartition('/')[2]}`]({path.rpartition('/')[2][:-4]}.md) | {markdown.prose(title)} |")
        folder = f"api/{layer}/" if layer else "api/"
        entries = [f"{path.rpartition('/')[2]} <{path.rpartition('/')[2][:-4]}>" for path, _, _ in rows]
        if layer:
            pages.write(f"{folder}index.md", f"# {LAYERS[layer]}: {layer}/\n\n" + "\n".join(table) + "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(entries) + "\n```\n")
    essay = [line for line in headers.essay_of((headers.INCLUDE / "qdot.hpp").read_text(encoding="utf-8"))]
    top = [path[:-4] for path, _, _ in layers.get("", [])] + [f"{layer}/index" for layer in layers if layer]
    pages.write("api/index.md", "# Headers\n\nA page for each header that a user includes, in the order of the theory: what it is about, and then each public name with its docstring.\n\n"
                "```{code-block} cpp\n#include <qdot/qdot.hpp>\n```\n\n" + markdown.essay(essay) + "\n\n```{toctree}\n:maxdepth: 2\n\n" + "\n".join(top) + "\n```\n\nAll names: {ref}`genindex`.\n")
    return total
