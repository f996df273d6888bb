# SPDX-License-Identifier: MIT
"""Formulas as MathML, which browsers draw themselves: nothing to download, no script. docutils brings the translator from LaTeX."""

from docutils import nodes
from docutils.utils.math import latex2mathml


def _mathml(tex, inline):
    try:
        return latex2mathml.tex2mathml(tex, inline=inline)
    except TypeError:  # docutils 0.21 renamed it
        return latex2mathml.tex2mathml(tex, as_block=not inline)


def visit_inline(self, node):
    self.body.append(_mathml(node.astext(), True))
    raise nodes.SkipNode


def visit_display(self, node):
    self.body.append('<div class="formula">' + _mathml(node.astext(), False) + "</div>")
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
