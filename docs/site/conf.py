# SPDX-License-Identifier: MIT
"""What Sphinx is told. The pages themselves are collected by build.py, which calls it."""

import os
import pathlib
import sys

site = pathlib.Path(os.environ["QDOT_SITE_SOURCE"])
sys.path.insert(0, str(site))

project = "qdot"
copyright = "the authors of qdot"
version = release = os.environ["QDOT_VERSION"]
extensions = ["myst_parser", "mathml"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["include_only/**"]
myst_enable_extensions = ["deflist", "html_image"]
myst_heading_anchors = 4
# Headings may skip a level where a page of docs/ does, and formulas in code blocks are no C++.
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
smartquotes = False
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "qdot"
html_static_path = ["static"]
html_css_files = ["qdot.css"]
html_js_files = ["theme.js"]
html_extra_path = ["extra"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_last_updated_fmt = None
highlight_language = "text"  # of blocks without a language: outputs and formulas
pygments_style = "friendly"
pygments_dark_style = "github-dark"
html_theme_options = {"navigation_with_keys": True}
