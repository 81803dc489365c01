"""Every relative link of every page leads to a file or folder of the repository (or to a page of the generated reference);
a part of a page that it names is there."""

import pathlib
import re
import sys

import pages

ROOT = pathlib.Path(__file__).resolve().parents[2]


def anchors(path):
    """The headings of a page as links name them, and its targets, (name)= above a heading."""
    text = path.read_text()
    headings = re.findall(r"^#+ (.*)$", text, re.M)
    return set(re.findall(r"^\(([\w-]+)\)=$", text, re.M)) | {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def main():
    wrong = 0
    for page in pages.pages(ROOT):
        text = re.sub(r"^(`{3,}|:{3,}).*?^\1\s*$", "", (ROOT / page).read_text(), flags=re.M | re.S)
        text = re.sub(r"`[^`\n]*`", "", text)
        for match in re.finditer(r"\]\(([^)\s]+)\)", text):
            target, _, part = match[1].partition("#")
            if re.match(r"[a-z]+:", target):
                continue
            path = (ROOT / page).parent / target if target else ROOT / page
            why = None
            if path.resolve().is_relative_to(ROOT / "reference"):
                continue
            if not path.exists():
                why = f"there is no {match[1]}"
            elif part and path.suffix == ".md" and part not in anchors(path):
                why = f"{target or page} has no part '{part}'"
            if why:
                wrong += 1
                print(f"error: a link leads nowhere: {why}\n  at:   {page}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
