"""What the site asks of Sphinx beyond its extensions.

```{step} examples/01_rigid_pendulum.cpp 2
```
shows step 2 of an example, and `<!-- made by: COMMAND -->` under a picture becomes its caption. Types in signatures are linked
by a dictionary: Sphinx's own search goes through the namespace for each, which takes a quarter of an hour.
"""

import pathlib
import re

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.domains.cpp import CPPDomain
from sphinx.transforms import SphinxTransform
from sphinx.util.nodes import make_refnode

import navigation
import pieces

MADE_BY = re.compile(r"<!--\s*made by:\s*(.*?)\s*-->", re.S)


class Step(Directive):
    required_arguments = 2

    def run(self):
        environment = self.state.document.settings.env
        path, number = self.arguments
        file = pathlib.Path(environment.srcdir) / path
        environment.note_dependency(str(file))
        code = pieces.step(file.read_text(), int(number)) if file.exists() else None
        if code is None:
            raise self.error(f"{path} has no step {number}")
        return [nodes.literal_block(code, code, language="cpp")]


class CommandsShown(SphinxTransform):
    """The command that made a figure, shown under it."""

    default_priority = 500

    def apply(self, **kwargs):
        for raw in list(self.document.findall(nodes.raw)):
            match = MADE_BY.match(raw.astext().strip())
            if match:
                caption = nodes.paragraph("", "", nodes.Text("made by "), nodes.literal(text=match[1].split("; from:")[0]),
                                          classes=["made-by"])
                raw.replace_self(caption)


class LinkedTypes(CPPDomain):
    places = None  # full name -> (page, anchor)

    def resolve_xref(self, env, fromdocname, builder, typ, target, node, contnode):
        if self.places is None:
            self.places = {name.split("(")[0]: (page, anchor) for name, _, _, page, anchor, _ in self.get_objects()}
        name = target.split("<")[0].split("(")[0].strip().removeprefix("lithe::")
        page, anchor = self.places.get(f"lithe::{name}", (None, None))
        return make_refnode(builder, fromdocname, page, anchor, contnode, name) if page else None

    def resolve_any_xref(self, env, fromdocname, builder, target, node, contnode):
        return []


def setup(app):
    app.add_domain(LinkedTypes, override=True)
    app.add_directive("step", Step)
    app.add_transform(CommandsShown)
    tree = navigation.Navigation()
    app.connect("html-page-context", tree.before, priority=400)
    app.connect("html-page-context", tree.after, priority=600)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
