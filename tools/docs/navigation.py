"""The tree of pages beside each page, resolved and marked up once: done anew for each page it is a quarter of the
site's time. Pages differ by their links, which are relative, and by what is open and marked as current."""

import posixpath
import re

from furo.navigation import get_navigation_tree

# Of furo's tree: a list or entry, its box, a link, an end.
PIECE = re.compile(r'<(ul|li)(?: class="([^"]*)")?>|<input ([^>]*)/>|<a class="([^"]*)" href="([^"]*)">|</(?:ul|li)>')

CHECKED = 'checked="" '


class Tree:
    def __init__(self, html, page):
        """`html`: Sphinx's, as on the page of this address."""
        html = re.sub(r' class="current"|(?<=toctree-l\d) current', "", html)
        own = f'"reference internal" href="{posixpath.basename(page)}"'
        html = html.replace('"current reference internal" href="#"', own)
        self.pieces = []  # text, or a piece's kind and what it holds
        self.ways = {}  # address -> places of the lists and entries around its link with their boxes, and of the link
        around, at = [], 0
        html = get_navigation_tree(html)
        for match in PIECE.finditer(html):
            self.pieces.append(html[at : match.start()])
            at, place = match.end(), len(self.pieces)
            element, classes, box, link_classes, href = match.groups()
            if element:
                around.append([place])
                self.pieces.append((element, classes))
            elif box:
                around[-1].append(place)
                self.pieces.append(("input", box))
            elif href:
                target = href if ":" in href else posixpath.normpath(posixpath.join(posixpath.dirname(page), href))
                self.pieces.append(("a", link_classes, target))
                self.ways.setdefault(target, (list(around), place))
            else:
                around.pop()
                self.pieces.append(match[0])
        self.pieces.append(html[at:])

    def on(self, page):
        """The tree on the page of this address."""
        around, own = self.ways.get(page, ([], None))
        here = around[-1][0] if around else None
        way = {place for places in around for place in places}
        return "".join(
            piece if isinstance(piece, str) else self.drawn(piece, page, place in way, place == here, place == own)
            for place, piece in enumerate(self.pieces)
        )

    @staticmethod
    def drawn(piece, page, is_open, is_here, is_own):
        kind, attributes, *target = piece
        if kind == "input":
            return f"<input {CHECKED if is_open else ''}{attributes}/>"
        if kind == "a":
            if is_own:
                return f'<a class="current {attributes}" href="#">'
            href = target[0] if ":" in target[0] else posixpath.relpath(target[0], posixpath.dirname(page) or ".")
            return f'<a class="{attributes}" href="{href}">'
        classes = (attributes or "").split()
        if is_open:
            classes.insert(1, "current")
        if is_here:
            classes.append("current-page")
        return f'<{kind} class="{" ".join(classes)}">' if classes else f"<{kind}>"


class Navigation:
    """Before and after furo's own handler."""

    tree = None

    def before(self, app, pagename, templatename, context, doctree):
        if self.tree is None and "toctree" in context:
            whole = context["toctree"](collapse=False, titles_only=True, maxdepth=-1, includehidden=True)
            self.tree = Tree(whole, app.builder.get_target_uri(pagename))
        context.pop("toctree", None)

    def after(self, app, pagename, templatename, context, doctree):
        context["furo_navigation_tree"] = self.tree.on(app.builder.get_target_uri(pagename)) if self.tree else ""
