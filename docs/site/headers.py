# SPDX-License-Identifier: MIT
"""What a header says to its users: its essay, and each public name with its signatures and docstring.

Doxygen was the other choice. It is not needed for this: the headers are plain text of one style, the rule "a public name has a docstring"
(tests/static/docstrings.py) and the pages of the site must agree on what a public name is, and the rule is to run in a second on a machine
that has nothing but Python. So one reader of tokens serves both. It knows declarations, not types: namespaces, classes with their public
members, functions, variables, aliases, concepts and enumerators, and `///` in front of them or `///<` behind.

Public is what lies in namespace qdot or a namespace below it that is not called detail. A name that has several overloads, or a
specialization, is one name: one docstring will do for all of them.
"""

import dataclasses
import functools
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
INCLUDE = ROOT / "include" / "qdot"

TOKEN = re.compile(r"""
    (?P<after>///<[^\n]*) | (?P<doc>///[^\n]*) | (?P<comment>//[^\n]*|/\*.*?\*/)
  | (?P<directive>^[ \t]*\#[^\n]*(?:\\\n[^\n]*)*)
  | (?P<string>(?:u8|[uUL])?R"(?P<fence>[^(\s]*)\(.*?\)(?P=fence)"|"(?:\\.|[^"\\])*")
  | (?P<number>\.?\d(?:[eEpP][+-]|'(?=\w)|[\w.])*)
  | (?P<character>'(?:\\.|[^'\\])+')
  | (?P<word>[^\W\d]\w*)
  | (?P<mark>\.\.\.|<=>|::|->\*|->|==|!=|<=|>=|&&|\|\||[-+*/%^&|]=|\+\+|--|[^\s\w])
""", re.X | re.S | re.M)

OPENING, CLOSING = "([{", ")]}"


@dataclasses.dataclass
class Token:
    kind: str
    text: str
    start: int
    end: int
    line: int
    last_line: int


@dataclasses.dataclass
class Declaration:
    """One declaration; a class has members, an enumeration enumerators."""
    kind: str  # class, enum, enumerator, function, variable, alias, concept
    name: str
    signature: str
    doc: str
    line: int
    members: list = dataclasses.field(default_factory=list)
    scope: str = ""  # of namespaces below qdot: "inertia::"
    is_special: bool = False  # a constructor, a destructor, an assignment, a forward declaration: nobody looks for these by name


@dataclasses.dataclass
class Header:
    path: str  # "mechanics/system.hpp"
    essay: list  # of lines, without "// "
    declarations: list
    includes: list  # of qdot's headers


def tokens_of(text):
    found, line, at = [], 1, 0
    for match in TOKEN.finditer(text):
        line += text.count("\n", at, match.start())
        at = match.start()
        last = line + text.count("\n", match.start(), match.end())
        kind = match.lastgroup if match.lastgroup != "fence" else "string"
        found.append(Token(kind, match.group(), match.start(), match.end(), line, last))
    return found


class Reader:
    def __init__(self, text):
        self.text = text
        self.tokens = [token for token in tokens_of(text) if token.kind not in ("comment", "directive")]

    # The index behind what closes the bracket at i.
    def behind_bracket(self, i):
        depth = 0
        while True:
            if self.tokens[i].text in OPENING and self.tokens[i].kind == "mark":
                depth += 1
            elif self.tokens[i].text in CLOSING and self.tokens[i].kind == "mark":
                depth -= 1
            i += 1
            if depth == 0:
                return i

    # The same of <…>, where "<" is known to open a list.
    def behind_angles(self, i):
        depth = 0
        while True:
            text = self.tokens[i].text
            if text in OPENING:
                i = self.behind_bracket(i)
                continue
            depth += (text == "<") - (text == ">")
            i += 1
            if depth == 0:
                return i

    # Behind the condition of "requires", which stands at i.
    def behind_requires(self, i):
        i += 1
        while True:
            if self.tokens[i].text == "requires":
                i += 1
                if self.tokens[i].text == "(":
                    i = self.behind_bracket(i)
                i = self.behind_bracket(i)
            elif self.tokens[i].text == "(":
                i = self.behind_bracket(i)
            else:
                while self.tokens[i].kind == "word" or self.tokens[i].text in ("::", "!"):
                    i += 1
                    if self.tokens[i].text == "<":
                        i = self.behind_angles(i)
                        if self.tokens[i].text != "::":
                            break
                    elif self.tokens[i].text not in ("::",) and self.tokens[i - 1].kind == "word":
                        break
            if self.tokens[i].text not in ("&&", "||"):
                return i
            i += 1

    # Declarations from i to the closing brace of the scope, and the index of that.
    def scope(self, i, where, of_class, visible):
        found, doc, last = [], [], []
        while i < len(self.tokens) and self.tokens[i].text != "}":
            token = self.tokens[i]
            if token.kind == "doc":
                if doc and doc[-1].line + 1 != token.line:
                    doc = []
                doc.append(token)
                i += 1
            elif token.kind == "after":
                for declaration in last:
                    if not declaration.doc:
                        declaration.doc = token.text[4:].strip()
                i += 1
            elif token.text == ";":
                i += 1
            elif token.text in ("public", "private", "protected") and self.tokens[i + 1].text == ":":
                visible = token.text == "public"
                i += 2
            else:
                said = "\n".join(line.text[3:].removeprefix(" ") for line in doc) if doc and doc[-1].line + 1 == token.line else ""
                declared, i = self.declaration(i, said, where, of_class)
                doc = []
                if visible:
                    line = self.tokens[i - 1].last_line
                    last = [d for d in found if getattr(d, "ends", 0) == line] + declared
                    for declaration in declared:
                        declaration.ends = line
                    found += declared
                else:
                    last = []
        return found, i

    def declaration(self, i, doc, where, of_class):
        first = i
        while self.tokens[i].text in ("template", "[", "extern", "inline", "export") or self.tokens[i].text == "requires":
            text = self.tokens[i].text
            if text == "template" and self.tokens[i + 1].text == "<":
                i = self.behind_angles(i + 1)
            elif text == "requires":
                i = self.behind_requires(i)
            elif text == "[":
                i = self.behind_bracket(i)
            else:
                i += 1
        word = self.tokens[i].text
        if word == "namespace":
            return self.namespace(i, where)
        if word in ("static_assert", "using") and (word == "static_assert" or self.tokens[i + 1].text == "namespace" or self.tokens[i + 2].text != "="):
            return [], self.behind_statement(i)
        if word == "friend" and self.tokens[i + 1].text in ("class", "struct"):
            return [], self.behind_statement(i)
        if word == "using":
            end = self.behind_statement(i)
            return [self.made("alias", self.tokens[i + 1].text, first, end - 1, doc, where)], end
        if word == "concept":
            end = self.behind_statement(i)
            return [self.made("concept", self.tokens[i + 1].text, first, end - 1, doc, where)], end
        if word == "enum":
            return self.enumeration(i, first, doc, where)
        if word in ("struct", "class", "union"):
            return self.class_(i, first, doc, where)
        return self.function_or_variables(i, first, doc, where, of_class)

    def behind_statement(self, i):
        while self.tokens[i].text != ";":
            i = self.behind_bracket(i) if self.tokens[i].text in OPENING else i + 1
        return i + 1

    def made(self, kind, name, first, end, doc, where):
        piece = self.text[self.tokens[first].start:self.tokens[end - 1].end]
        start = self.text.rfind("\n", 0, self.tokens[first].start) + 1
        indent = self.tokens[first].start - start
        piece = re.sub(r"[ \t]*//[^\n]*", "", piece)
        signature = "\n".join(line[indent:] if line[:indent].isspace() else line for line in piece.split("\n"))
        return Declaration(kind, name, signature, doc, self.tokens[first].line, scope=where or "")

    def namespace(self, i, where):
        name = ""
        i += 1
        while self.tokens[i].text not in ("{", "="):
            name += self.tokens[i].text
            i += 1
        if self.tokens[i].text == "=":
            return [], self.behind_statement(i)
        if "detail" in name or name == "" or name == "std" or name == "Eigen":
            return [], self.behind_bracket(i)
        if where is None:
            inner = name.removeprefix("qdot").removeprefix("::")
            inner += "::" if inner else ""
        else:
            inner = where + name + "::"
        found, i = self.scope(i + 1, inner, None, True)
        return found, i + 1

    def class_(self, i, first, doc, where):
        name, j = "", i + 1
        while self.tokens[j].text not in ("{", ";", ":"):
            if self.tokens[j].text == "[" or self.tokens[j].text == "(":
                j = self.behind_bracket(j)
                continue
            if self.tokens[j].text == "<":
                j = self.behind_angles(j)
                continue
            if self.tokens[j].kind == "word" and self.tokens[j].text not in ("final", "alignas"):
                name = name + "::" + self.tokens[j].text if self.tokens[j - 1].text == "::" else self.tokens[j].text
            j += 1
        head = j
        if self.tokens[j].text == ";":
            made = self.made("class", name, first, j, doc, where)
            made.is_special = True
            return [made], j + 1
        while self.tokens[j].text != "{":
            j = self.behind_angles(j) if self.tokens[j].text == "<" else j + 1
        made = self.made("class", name, first, head, doc, where)
        made.members, j = self.scope(j + 1, "", name, self.tokens[i].text != "class")
        return ([made] if "::" not in name else []), self.behind_statement(j + 1)

    def enumeration(self, i, first, doc, where):
        j = i + 1
        while self.tokens[j].text in ("class", "struct"):
            j += 1
        name = self.tokens[j].text
        while self.tokens[j].text not in ("{", ";"):
            j += 1
        if self.tokens[j].text == ";":  # its enumerators stand elsewhere
            return [], j + 1
        made = self.made("enum", name, first, j, doc, where)
        j += 1
        said, on_line = [], []
        while self.tokens[j].text != "}":
            token = self.tokens[j]
            if token.kind == "doc":
                said.append(token.text[3:].strip())
            elif token.kind == "after":
                for enumerator in on_line:
                    enumerator.doc = enumerator.doc or token.text[4:].strip()
            elif token.kind == "word":
                enumerator = Declaration("enumerator", token.text, token.text, "\n".join(said), token.line)
                on_line = [e for e in on_line if e.line == token.line] + [enumerator]
                made.members.append(enumerator)
                said = []
                while self.tokens[j + 1].text not in (",", "}") and self.tokens[j + 1].kind != "after":
                    j = self.behind_bracket(j + 1) - 1 if self.tokens[j + 1].text in OPENING else j + 1
            j += 1
        return [made], self.behind_statement(j + 1)

    def function_or_variables(self, i, first, doc, where, of_class):
        special = False
        name, before, j = "", first, i
        while True:
            token = self.tokens[j]
            if token.text == "operator" and token.kind == "word":
                name, j = "operator", j + 1
                while self.tokens[j].text != "(" or name == "operator":
                    name += (" " if self.tokens[j].kind == "word" else "") + self.tokens[j].text
                    j += 1
                    if name == "operator(":
                        name, j = "operator()", j + 1
                name = name.replace(" new", " new")
                break
            if token.text == "<" and self.tokens[j - 1].kind == "word":
                j = self.behind_angles(j)
                continue
            if token.text == "[" or (token.text == "(" and self.tokens[j - 1].text in ("decltype", "alignas", "explicit", "noexcept")):
                j = self.behind_bracket(j)
                continue
            if token.text in ("(", "=", ";", "{", ",", ":"):
                break
            if token.kind == "word":
                name, before = token.text, j
            j += 1
        if self.tokens[j].text != "(":
            return self.variables(i, first, doc, where)

        behind = self.behind_bracket(j)
        if self.tokens[before - 1].text == "~":
            name, special = "~" + name, True
        if name == of_class or name == "operator=":
            special = True
        # The body, or the end. In a constructor's list a brace behind a name is a number's; "requires" may have one, too.
        in_list, k, end = False, behind, behind
        guide = of_class is None and before == i
        while True:
            token = self.tokens[k]
            if token.text == ";":
                end, k = (k if not in_list else end), k + 1
                break
            if token.text == "{":
                if in_list and (self.tokens[k - 1].kind == "word" or self.tokens[k - 1].text == ">"):
                    k = self.behind_bracket(k)
                    continue
                if not in_list:
                    end = k
                k = self.behind_bracket(k)
                break
            if token.text == "requires" and token.kind == "word":
                k = self.behind_requires(k)
                continue
            if token.text == ":" and not in_list:
                in_list, end = True, k
            k = self.behind_bracket(k) if token.text in OPENING else k + 1
        qualified = self.tokens[before - 1].text == "::" and not name.startswith("operator")
        if guide or qualified:
            return [], k
        made = self.made("function", name, first, end, doc, where)
        made.signature = re.sub(r"\s*=\s*(default|delete)$", r" = \1", made.signature)
        made.is_special = special
        return [made], k

    # One or several, with what they begin as.
    def variables(self, i, first, doc, where):
        names, name, j, awaiting, depth = [], "", i, True, 0
        while self.tokens[j].text != ";":
            token = self.tokens[j]
            if token.text == "<" and self.tokens[j - 1].kind == "word" and awaiting:
                j = self.behind_angles(j)
                continue
            if token.text in OPENING:
                if awaiting and name:
                    names.append(name)
                    awaiting = False
                j = self.behind_bracket(j)
                continue
            if token.text == "<" and not awaiting and self.tokens[j - 1].kind == "word" and self.tokens[j - 1].end == token.start:
                j = self.behind_angles(j)
                continue
            if token.text in ("=", ":") and awaiting:
                names.append(name)
                awaiting = False
            elif token.text == "," and awaiting:
                names.append(name)
            elif token.text == "," and self.begins_another(j):
                awaiting = True
            elif token.kind == "word" and awaiting:
                name = token.text
            j += 1
        if awaiting:
            names.append(name)
        return [self.made("variable", n, first, j, doc, where) for n in names], j + 1

    # Whether a comma in an initial value is one between variables: "double a = f<1, 2>(), b = 3".
    def begins_another(self, j):
        return self.tokens[j + 1].kind == "word" and self.tokens[j + 2].text in ("=", ";", ",", "{", "[")


def essay_of(text):
    lines = []
    for line in text.split("\n")[2:]:
        if not line.startswith("//"):
            break
        lines.append(line[2:].removeprefix(" ").rstrip())
    while lines and not lines[0]:
        lines.pop(0)
    return lines


@functools.cache
def read(path):
    """The header at include/qdot/<path>."""
    text = (INCLUDE / path).read_text(encoding="utf-8")
    declarations, _ = Reader(text).scope(0, None, None, True)
    return Header(path, essay_of(text), declarations, re.findall(r'^#include "qdot/([^"]+)"', text, re.M))


def user_headers():
    """Paths of what users include, in the order of qdot.hpp, with what it says of each; and the headings between."""
    return re.findall(r'^(?://\s*)?#include "qdot/([^"]+)"\s*//\s*(.*)$', (INCLUDE / "qdot.hpp").read_text(encoding="utf-8"), re.M)


def is_room(path):
    return path.count("/") > 1


def pages():
    """Each user header with the rooms that it is the first to include, whose public names are therefore its own."""
    seen, result = set(), []

    def rooms_of(path):
        for included in read(path).includes:
            if is_room(included) and included not in seen:
                seen.add(included)
                yield from rooms_of(included)
                yield read(included)

    for path, title in user_headers():
        result.append((read(path), title, list(rooms_of(path))))
    return result


# Members that play a role which a header describes for all who play it; they need no docstring of their own.
EFFECT_ROLES = {"potential_term", "lagrangian_term", "force", "state_rate", "initial_state", "phi", "velocity_constraint", "is_active", "takes_time", "require_fit"}
STEPPER_ROLES = {"reset", "step", "failure", "t", "t_previous", "time_point", "moment", "y", "order", "statistics", "polynomial", "interpolate", "correct", "has_fixed_step",
                 "projects_itself"}
# Arithmetic and comparison of numbers of another kind mean what they mean for numbers.
ARITHMETIC = re.compile(r"operator(?:[-+*/]=?|[=!<>]=|[<>]|&&|\|\||!)")


# So do functions of <cmath>.
CMATH = set("""abs fabs sqrt cbrt exp exp2 expm1 log log2 log10 log1p erf erfc sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh floor ceil pow atan2 hypot
copysign fmax fmin max min fma isnan isfinite isinf signbit""".split())


def role_of(name, of_class=""):
    if name in EFFECT_ROLES and not of_class.endswith("Stepper"):
        return "A role of an effect: [`effects/effect.hpp`](api-effects-effect)."
    if name in STEPPER_ROLES and of_class.endswith("Stepper"):
        return "As every stepper has it: [`integrate/stepper.hpp`](api-integrate-stepper)."
    if ARITHMETIC.fullmatch(name):
        return "As for plain numbers."
    if not of_class and name in CMATH:
        return "As in `<cmath>`."
    return None


def undocumented(declarations, inside=""):
    """Names without any docstring, as (name, line); of a class, those of its public members."""
    groups = {}
    for declaration in declarations:
        groups.setdefault(declaration.scope + declaration.name, []).append(declaration)
    for name, group in groups.items():
        if all(d.is_special for d in group):
            continue
        if not any(d.doc for d in group) and not role_of(name.rpartition("::")[2], inside.removesuffix("::").rpartition("::")[2]):
            yield inside + name, group[0].line
        yield from undocumented([member for d in group for member in d.members], inside + name + "::")
