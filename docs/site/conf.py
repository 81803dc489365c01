"""The site's settings. tools/docs.sh runs Sphinx on build/docs/source, a mirror of the repository by links: pages keep
the places, and so the links among each other, that they have in the repository."""

import gc
import os
import subprocess
import sys

gc.set_threshold(1000000, 20, 100)  # a quarter of the time went into looking for garbage among nodes that stay
source = os.path.abspath(os.environ.get("LITHE_DOCS_SOURCE", "."))
sys.path.insert(0, os.path.join(source, "tools", "docs"))

project = "Lithe"
author = "the authors of Lithe"
copyright = author
html_title = "Lithe"
html_show_copyright = False
html_show_sphinx = False
root_doc = "docs/site/index"
include_patterns = [
    "README.md", "CHANGELOG.md", "docs/**.md", "reference/**.md", "*/README.md",
    "engine/*/README.md", "examples/*/README.md", "plugins/*/README.md", "tools/*/README.md", "tools/bench/peers/README.md",
]
exclude_patterns = ["**/node_modules/**", "tools/viewer/node_modules", "docs/site/static/**"]

extensions = ["myst_parser", "breathe", "sphinx.ext.mathjax", "lithe_site"]
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_update_mathjax = False  # it writes settings for MathJax 3
myst_dmath_double_inline = True

# Debian's MathJax 2, copied beside the pages: formulas are drawn as SVG, with no font and no network.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
mathjax2_config = {
    "showMathMenu": False, "messageStyle": "none", "extensions": [],
    "SVG": {"linebreaks": {"automatic": False}, "scale": 95},
    "tex2jax": {"inlineMath": [["\\(", "\\)"]], "displayMath": [["\\[", "\\]"]]},
}

breathe_projects = {"lithe": os.environ.get("LITHE_DOXYGEN_XML", "../doxygen/xml")}
breathe_default_project = "lithe"
breathe_default_members = ("members",)
breathe_show_include = False
cpp_id_attributes = []
primary_domain = "cpp"
highlight_language = "none"
# One name declared in two headers (a forward declaration beside the class) is no mistake.
suppress_warnings = ["duplicate_declaration.cpp", "duplicate_declaration", "myst.header"]

html_theme = "furo"
html_static_path = [os.path.join(source, "docs/site/static")]
html_css_files = ["lithe.css"]
html_copy_source = False
html_show_search_summary = False  # fetched from the pages, which browsers refuse to pages opened as files
html_show_sourcelink = False
html_additional_pages = {"index": "redirect.html"}
templates_path = [os.path.join(source, "docs/site/templates")]
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b5d8a", "color-brand-content": "#0b5d8a"},
    "dark_css_variables": {"color-brand-primary": "#6cc0ee", "color-brand-content": "#6cc0ee"},
}
pygments_style = "tango"
pygments_dark_style = "native"
nitpicky = False
