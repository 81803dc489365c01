"""Checks that the site works as files, without a server or a network: site_check.py SITE

Whatever its pages load is a file of the site. The search finds known names, in headless Chromium whose every look-up of a
host fails; where there is no Chromium (CHROMIUM=/usr/bin/chromium), only the index is looked at.
"""

import html.parser
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.parse

# word -> a page that the search must find, and one that it must not
SEARCHES = {
    "RevoluteJoint": ("docs/site/catalogue/joints/revolute_joint", "docs/site/catalogue/tyres"),
    "find_equilibrium": ("docs/site/catalogue/analyses", "docs/page"),
    "thrust": ("docs/site/tutorial/26_flutter", "docs/restart"),
}
NOTHING = "zzyzxqq"  # finds nothing
LOADED = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src"}


class Loads(html.parser.HTMLParser):
    """What a page loads by itself; links that a reader may follow are none of it."""

    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag == "link" and attributes.get("rel") not in ("stylesheet", "icon", "preload", "shortcut icon"):
            return
        address = attributes.get(LOADED.get(tag, ""))
        if address and not address.startswith("data:"):
            self.found.append(address)


def loads_errors(site):
    for page in sorted(site.rglob("*.html")):
        loads = Loads()
        loads.feed(page.read_text())
        for address in loads.found:
            parts = urllib.parse.urlsplit(address)
            if parts.scheme or parts.netloc:
                yield f"{page.relative_to(site)} asks the network for {address}"
            elif not (page.parent / urllib.parse.unquote(parts.path)).exists():
                yield f"{page.relative_to(site)} loads {address}, which is not there"
    for sheet in sorted(site.rglob("*.css")):
        for address in re.findall(r"(?:url\(|@import )[\"']?((?:https?:)?//[^\"')]+)", sheet.read_text(errors="replace")):
            yield f"{sheet.relative_to(site)} asks the network for {address}"


def index_errors(site):
    text = (site / "searchindex.js").read_text()
    pages = json.loads(re.match(r"Search.setIndex\((.*)\)", text, re.S)[1])["docnames"]
    for word, (page, _) in SEARCHES.items():
        if page not in pages:
            yield f"the search knows no page {page}, where '{word}' is"


def found_by(browser, site, word, profile):
    """Pages that the search page lists for a word. A busy machine may show the page before the list is complete."""
    address = (site / "search.html").resolve().as_uri() + "?q=" + urllib.parse.quote(word)
    for budget in (30000, 60000, 120000, 240000):  # ms
        done = subprocess.run(
            [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
             "--disable-component-update", "--disable-sync", f"--user-data-dir={profile}",
             "--host-resolver-rules=MAP * ~NOTFOUND", f"--virtual-time-budget={budget}", "--dump-dom", address],
            capture_output=True, text=True, timeout=300)
        list_ = re.search(r'<div id="search-results">(.*?)</div>', done.stdout, re.S)
        if done.returncode != 0 or not list_:
            raise RuntimeError(f"{browser} did not show {address}: {done.stderr[-500:]}")
        if re.search(r"Search finished|did not match any documents", list_[1]):
            break
    else:
        raise RuntimeError(f"{browser} did not finish the search of {address}")
    return {re.sub(r"\.html.*", "", target) for target in re.findall(r'<li[^>]*><a href="([^"]+)"', list_[1])}


def search_errors(browser, site):
    with tempfile.TemporaryDirectory() as profile:
        for word, (page, other) in SEARCHES.items():
            found = found_by(browser, site, word, profile)
            if page not in found:
                yield f"a search for '{word}' does not find {page}, but {sorted(found)}"
            if other in found:
                yield f"a search for '{word}' finds {other}"
        if found_by(browser, site, NOTHING, profile):
            yield f"a search for '{NOTHING}' finds something"


def main():
    site = pathlib.Path(sys.argv[1])
    errors = [*loads_errors(site), *index_errors(site)]
    browser = os.environ.get("CHROMIUM", "/usr/bin/chromium")
    if os.access(browser, os.X_OK):
        errors += search_errors(browser, site)
        how = "in Chromium without a network"
    else:
        how = "by its index alone: no Chromium here (apt-get install chromium)"
    for error in errors[:20]:
        print(f"error: {error}", file=sys.stderr)
    print(f"{len(list(site.rglob('*.html')))} pages load files alone; the search was checked {how}")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
