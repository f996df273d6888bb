# SPDX-License-Identifier: MIT
"""Links of Markdown pages: where they are, what they lead to, and which headings a page has, as GitHub names them."""

import re

# [text](target), also of pictures; not in code, which is blanked out first.
LINK = re.compile(r"(?<!\\)\]\(\s*<?([^()\s<>]+(?:\([^()\s]*\))?)>?(?:\s+\"[^\"]*\")?\s*\)")
FENCE = re.compile(r"^(?P<fence>```+|~~~+).*?^(?P=fence)[ \t]*$", re.S | re.M)
INLINE_CODE = re.compile(r"(?<!`)(`+)(?!`).*?(?<!`)\1(?!`)", re.S)


def without_code(text):
    """The text with all code replaced by blanks, so that places stay where they are."""
    blank = lambda match: re.sub(r"[^\n]", " ", match.group())
    return INLINE_CODE.sub(blank, FENCE.sub(blank, text))


def links_of(text):
    """Places of targets in the text."""
    return [match.span(1) for match in LINK.finditer(without_code(text))]


def slug(heading):
    """What GitHub makes of a heading, and MyST too."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors_of(text):
    """Slugs of all headings; what occurs again is numbered."""
    found = []
    for heading in re.findall(r"^#{1,6}[ \t]+(.*?)[ \t#]*$", FENCE.sub("", text), re.M):
        name = slug(heading)
        again = found.count(name)
        while again and f"{name}-{again}" in found:
            again += 1
        found.append(f"{name}-{again}" if again else name)
    return found
