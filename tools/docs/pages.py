"""The repository's Markdown pages: their code blocks, their pictures, and the comments that say how either is kept true.

A comment stands on the line or lines before a block, or after a picture:
    <!-- prelude: NAME -->    the block is compiled and run with that prelude
    <!-- not run: why -->     a shell block, or one of C++ that is no program
    <!-- run by: TEST -->     another test compiles and runs it; both of these in a page's first lines: all its blocks
    <!-- theirs: PROGRAM -->  another program's language
    <!-- made by: COMMAND --> under a picture; "; from: PATH PATH" names its inputs where the command does not tell
"""

import pathlib
import re

FOLDERS = ("docs", "engine", "bodies", "joints", "integrators", "plugins", "examples", "tests", "tools")
LEFT_OUT = ("node_modules", "build", "results")
MARK = re.compile(r"<!--\s*(prelude|not run|run by|theirs|made by|goes on):?\s*(.*?)\s*-->", re.S)


class Block:
    def __init__(self, page, line, language, text, marks):
        self.page, self.line, self.language, self.text, self.marks = page, line, language, text, marks

    @property
    def place(self):
        return f"{self.page}:{self.line}"


class Picture:
    def __init__(self, page, line, path, command, inputs):
        self.page, self.line, self.path, self.command, self.inputs = page, line, path, command, inputs

    @property
    def place(self):
        return f"{self.page}:{self.line}"


def pages(root):
    """Every page, relative to the root: README.md, and those of the folders."""
    found = [pathlib.Path("README.md")]
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.md")):
            relative = path.relative_to(root)
            if not any(part in LEFT_OUT for part in relative.parts):
                found.append(relative)
    return found


def blocks(root, page):
    """The fenced blocks of a page; directives ({step}, {toctree}, ...) among them, with their name as language."""
    found, marks, of_page = [], {}, {}
    lines = (root / page).read_text().splitlines()
    i = 0
    while i < len(lines):
        line = lines[i]
        fence = re.match(r"\s*(`{3,}|:{3,})\s*(\S*)\s*(.*)$", line)
        if fence:
            start, end = i + 1, i + 1
            while end < len(lines) and lines[end].strip() != fence[1]:
                end += 1
            text = "\n".join(lines[start:end])
            block = Block(page, start + 1, fence[2], text, dict(marks))
            block.argument = fence[3]
            block.marks = of_page | block.marks
            found.append(block)
            marks, i = {}, end + 1
            continue
        comment = line
        while "<!--" in comment and "-->" not in comment and i + 1 < len(lines):
            i += 1
            comment += "\n" + lines[i]
        mark = MARK.search(comment)
        if mark:
            if mark[1] in ("prelude", "run by") and i < 3 and not found:
                of_page[mark[1]] = mark[2]
            else:
                marks[mark[1]] = mark[2]
        elif line.strip():
            marks = {}  # a mark belongs to what follows it directly
        i += 1
    return found


def pictures(root, page):
    """The pictures of a page, ![words](path), and the words of programs, ```{literalinclude} results/x.txt, with the
    command that a comment in the next two lines names."""
    text = (root / page).read_text()
    found = []
    shown = r"!\[[^\]]*\]\(([^)\s]+)\)|^```\{literalinclude\} (\S*results/\S+\.txt)\n(?::.*\n)*```$"
    for match in re.finditer(shown, text, re.M):
        target = match[1] or match[2]
        if target.startswith(("http:", "https:")):
            continue
        # Pictures that stand together share the comment below them.
        rest = text[match.end():]
        while (again := re.match(r"\s*!\[[^\]]*\]\([^)]*\)", rest)) is not None:
            rest = rest[again.end():]
        mark = re.match(r"\s*<!--\s*made by:\s*(.*?)\s*-->", rest, re.S)
        command, inputs = None, []
        if mark:
            command, _, given = (part.strip() for part in mark[1].partition("; from:"))
            inputs = given.split()
        path = (root / page).parent / target
        found.append(Picture(page, text[:match.start()].count("\n") + 1, path.resolve(), command, inputs))
    return found
