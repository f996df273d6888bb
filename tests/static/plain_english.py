#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Comments and pages are plain English: no banned words, and no sentence of more than 30 words beyond those in long_sentences.txt.

long_sentences.txt holds one line a file: its name and how many long sentences its comments have. A file may have fewer, never more.
`tests/static/plain_english.py --lower` writes the numbers of today where they are lower; no option raises them.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BASELINE = pathlib.Path(__file__).with_name("long_sentences.txt")
LONGEST = 30  # words

BANNED = [
    (r"\b(?:some|no|any)body\b(?!'s law)", "say which code or which user"),
    (r"(?<!users )(?<!user )(?<!readers )(?<!reader )(?<!people )(?<!engineers )(?<!someone )\bwho\b|\bwho(?:m|m?ever|soever)\b", "'who' is for people: name the code, or write 'a caller that', 'users that', 'which'"),
    (r"(?-i:^The same(?:[.,:]| (?:after|along|as|at|by|for|from|in|into|near|of|reduced|to|where|with|without)\b))", "say what it does"),
    (r"\bknows? of (?:it|them)sel(?:f|ves)\b", "say what it computes or holds"),
    (r"\bsays? so\b", "say which value is returned or which error is thrown"),
    (r"\bbeyond all numbers\b", "write 'infinite' or 'overflowed'"),
]
BANNED = [(re.compile(pattern, re.IGNORECASE), remedy) for pattern, remedy in BANNED]
CODE_OR_STRING = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|//')
RAW_STRING = re.compile(r'R"(\w*)\(.*?\)\1"', re.DOTALL)
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
SENTENCE_END = re.compile(r"(?<=[.!?])[)\"”]?\s+")
INITIAL, SURNAME = re.compile(r"(?:^|[\s(])[A-Z]\.$"), re.compile(r"[A-Z]\.$|[A-Z][\w-]+(?:,|\s+(?:and|et)\s|\s*\()")
ABBREVIATION = re.compile(r"\b(?:e\.g|i\.e|cf|eq|Eq|eqs|Sec|Ch|ch|vol|Vol|no|p|pp|Fig|vs)\.$")


def comment_of(line):
    """(where its comment begins, its text with the indentation that stands behind the slashes); none where a line has no comment."""
    for match in CODE_OR_STRING.finditer(line):
        if match[0] == "//":
            return match.start(), re.sub(r"^/*<?", "", line[match.start():])
    return None


def paragraphs_of_code(text):
    """(first line, text, whether it is sentences) of each paragraph of the comments, and of each line of formulas, tables and code, which are indented."""
    text = RAW_STRING.sub(lambda raw: '""' + "\n" * raw[0].count("\n"), text)
    paragraph, first, place = [], 0, None
    for number, line in enumerate(text.split("\n"), 1):
        found = comment_of(line)
        begin, content = found if found else (None, "")
        display = re.match(r"\s{4,}|\s*$|\s*#include ", content) is not None
        new = begin != place or display or not line[:begin].isspace() and begin > 0 or re.match(r"\s*(?:@\w+|[-*•]\s|\d\.\s|(?<=\s)\S+(?: \S+)?\s{2,}\S)", content)
        if new and paragraph:
            yield first, " ".join(paragraph), True
            paragraph = []
        if found and display:
            yield number, content.strip(), False
        elif found:
            if not paragraph:
                first = number
            paragraph.append(content.strip())
        place = begin
    if paragraph:
        yield first, " ".join(paragraph), True


def paragraphs_of_page(text):
    """(first line, text, False) of each paragraph of a page, without its blocks of code; how long its sentences are is not asked."""
    paragraph, first, fenced = [], 0, False
    for number, line in enumerate(text.split("\n") + [""], 1):
        fence = re.match(r"\s*(```|~~~)", line)
        fenced = fenced != bool(fence)
        if fence or fenced or not line.strip() or re.match(r"\s*(?:[-*+]\s|\d+\.\s|[|#])", line):
            if paragraph:
                yield first, " ".join(paragraph), False
            paragraph = []
        if not fence and not fenced and line.strip():
            if not paragraph:
                first = number
            paragraph.append(LINK.sub(r"\1", line).strip())


def newest_section(text):
    """The changelog to the end of its first section."""
    headings = [match.start() for match in re.finditer(r"^## ", text, re.MULTILINE)]
    return text[:headings[1]] if len(headings) > 1 else text


def sentences_of(paragraph):
    parts = []
    for part in SENTENCE_END.split(paragraph):
        if parts and (ABBREVIATION.search(parts[-1]) or INITIAL.search(parts[-1]) and SURNAME.match(part)):
            parts[-1] += " " + part
        else:
            parts.append(part)
    return parts


def words_of(sentence):
    """How many words a sentence has; formulas, numbers and names of files count as none."""
    return len(re.findall(r"(?<![\w/.`(:])[A-Za-z][A-Za-z'’-]*(?![\w(/])", sentence))


def main(arguments):
    if arguments not in ([], ["--lower"], ["--list"]):
        sys.exit("tests/static/plain_english.py [--lower | --list]")
    violations, counts, where = [], {}, {}
    code = sorted(f for folder in ("include", "src", "examples") for ending in ("hpp", "ipp", "cpp", "h") for f in (ROOT / folder).rglob(f"*.{ending}"))
    pages = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if len(code) < 500:
        sys.exit(f"Only {len(code)} files of code: where are the others?")
    for file in [*code, *pages]:
        name, text = str(file.relative_to(ROOT)), file.read_text(encoding="utf-8")
        page = file.suffix == ".md"
        text = newest_section(text) if file.name == "CHANGELOG.md" else text
        for line, paragraph, is_prose in paragraphs_of_page(text) if page else paragraphs_of_code(text):
            for pattern, remedy in BANNED:
                if match := pattern.search(paragraph):
                    violations.append(f"{name}:{line}: “{paragraph[max(match.start() - 40, 0):match.end() + 40]}”: {remedy}")
            for sentence in sentences_of(paragraph) if is_prose else []:
                if words_of(sentence) > LONGEST:
                    counts[name] = counts.get(name, 0) + 1
                    where.setdefault(name, []).append(f"{name}:{line}: {words_of(sentence)} words: {sentence}")
    if arguments == ["--list"]:
        print("\n".join(each for name in where for each in where[name]))
    allowed = {}
    if BASELINE.exists():
        allowed = {name: int(number) for name, number in (line.rsplit(" ", 1) for line in BASELINE.read_text(encoding="utf-8").splitlines())}
    if arguments == ["--lower"]:
        allowed = {name: min(number, allowed.get(name, number)) if BASELINE.exists() else number for name, number in counts.items()}
        BASELINE.write_text("".join(f"{name} {number}\n" for name, number in sorted(allowed.items())), encoding="utf-8")
    for name, found in where.items():
        if len(found) > allowed.get(name, 0):
            violations.append(f"{name}: {len(found)} sentences have more than {LONGEST} words, {allowed.get(name, 0)} are allowed; one of these is new:")
            violations += ["  " + each for each in found]
    if violations:
        sys.exit("\n".join(violations) + f"\nPlain English: short sentences, the field's terms ({BASELINE.name} says how many long ones each file may have)")
    print(f"{len(code)} files of code and {len(pages)} pages; {sum(counts.values())} sentences have more than {LONGEST} words")


main(sys.argv[1:])
