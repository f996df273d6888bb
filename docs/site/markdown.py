# SPDX-License-Identifier: MIT
"""Comments of headers as MyST: prose, formulas that stand apart, code, and what @param and its kind say."""

import re

# Words that look like code where they stand in prose: headers, calls, snake_case, two::names, Options{.rtol = 1e-9}.
CODE = re.compile(r"""
    `[^`\n]+`
  | \b(?:qdot/)?(?:[a-z]\w*/)*[a-z]\w*\.hpp\b
  | \b[A-Za-z]\w{2,}(?:::\w+)*(?:<\w*>)?\([^()\s]*\)
  | \b(?:\w+::)+\w+\b(?:\(\))?
  | \b[a-z]\w*[a-z0-9]_[a-z0-9]\w+\b(?:\(\))? | \b[a-z]_[a-z]{3,}\b
  | \b[A-Z][a-z0-9]+(?:[A-Z][a-z0-9]*)+\b(?:\{[^{}\n]*\})?
  | \b[A-Z][a-z]\w+\{[^{}\n]*\}
  | \b[a-z]\w*\.[a-z]\w*_\w+\b
  | \[\[\w+\]\]
""", re.X)
EMPHASIS = re.compile(r"(?<![\w*])\*[^\s*][^*\n]*\*(?![\w*])")
SPECIAL = re.compile(r"([\\`*_{}\[\]<>|&#$])")
CODE_LINE = re.compile(r"^\s*(?://|const |auto |#include|struct |return |template |\}|\w+\(.*\);?$)|[;{]\s*(?://.*)?$|::\w+[({]|\{\.\w+ =|\bconst auto\b")


def escaped(text):
    return SPECIAL.sub(r"\\\1", text)


def prose(text, link=lambda word: None):
    """One paragraph. link(word) says where a word of code leads, or None."""
    result, at = [], 0
    for match in re.finditer(f"{CODE.pattern}|(?P<emphasis>{EMPHASIS.pattern})", text, re.X):
        result.append(escaped(text[at:match.start()]))
        word = match.group()
        at = match.end()
        if match.group("emphasis"):
            result.append("*" + escaped(word[1:-1]) + "*")
            continue
        word = word.strip("`")
        target = link(word)
        result.append(f"[`{word}`]({target})" if target else f"`{word}`")
    result.append(escaped(text[at:]))
    joined = "".join(result)
    return re.sub(r"^(\d+)([.)])(?=\s)|^([-+%>=~])", lambda m: f"{m[1]}\\{m[2]}" if m[1] else "\\" + m[3], joined)


def block(lines):
    """What stands apart: a formula, a table, or code."""
    indent = min(len(line) - len(line.lstrip()) for line in lines if line.strip())
    text = "\n".join(line[indent:] for line in lines).strip("\n")
    fence = "`" * (3 + text.count("```"))
    said = [line for line in text.split("\n") if line.strip()]
    is_code = 2 * sum(1 for line in said if CODE_LINE.search(line)) > len(said)
    return f"{fence}{{code-block}} {'cpp' if is_code else 'text'}\n{text}\n{fence}"


def essay(lines, link=lambda word: None, level=2):
    """A comment: paragraphs, headings that are underlined, lists, and blocks that are indented."""
    result, paragraph, apart = [], [], []

    def end_paragraph():
        if paragraph:
            result.append(prose(" ".join(line.strip() for line in paragraph), link))
            paragraph.clear()

    def end_apart():
        while apart and not apart[-1].strip():
            apart.pop()
        if apart:
            result.append(block(apart))
            apart.clear()

    i = 0
    while i < len(lines):
        line = lines[i]
        if i + 1 < len(lines) and line.strip() and re.fullmatch(r"[=-]{3,}", lines[i + 1].strip()):
            end_paragraph()
            end_apart()
            result.append("#" * level + " " + prose(line.strip(), link))
            i += 2
            continue
        item = re.match(r"(?:[-•]|\d+\.) ", line)
        if item:
            end_paragraph()
            end_apart()
            width = item.end()
            words = [line[width:]]
            while i + 1 < len(lines) and lines[i + 1].startswith(" " * width):
                i += 1
                words.append(lines[i].strip())
            mark = "- " if not line[0].isdigit() else item.group()
            result.append(mark + prose(" ".join(words), link))
        elif not line.strip():
            end_paragraph()
            if apart:
                apart.append(line)
        elif line.startswith("  "):
            end_paragraph()
            apart.append(line)
        else:
            end_apart()
            paragraph.append(line)
        i += 1
    end_paragraph()
    end_apart()
    return "\n\n".join(result)


TAG = re.compile(r"@(t?param|return|throws)\b\s*(.*)")


def docstring(text, link=lambda word: None):
    """Prose, and then a list of parameters, result and errors."""
    lines, tagged = [], []
    for line in text.split("\n"):
        match = TAG.match(line.strip())
        if match:
            tagged.append((match[1], [match[2]]))
        elif tagged and line.strip():
            tagged[-1][1].append(line.strip())
        else:
            lines.append(line)
    result = [essay(lines, link)] if any(line.strip() for line in lines) else []
    items = []
    for tag, words in tagged:
        words = " ".join(words)
        if tag in ("param", "tparam"):
            names, _, said = words.partition("  ") if "  " in words else words.partition(" ")
            items.append(f"- {', '.join('`' + name.strip() + '`' for name in names.split(','))} — {prose(said.strip(), link)}")
        elif tag == "return":
            items.append(f"- **returns** {prose(words.strip(), link)}")
        else:
            match = re.match(r"((?:[A-Z]\w+)(?:, [A-Z]\w+)*)\s+(.*)", words)
            names = ", ".join(f"[`{n}`]({link(n)})" if link(n) else f"`{n}`" for n in match[1].split(", ")) if match else ""
            items.append(f"- **throws** {names + ' — ' if names else ''}{prose((match[2] if match else words).strip(), link)}")
    if items:
        result.append("\n".join(items))
    return "\n\n".join(result)
