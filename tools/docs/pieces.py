"""Pieces of source files that pages show: the numbered steps of the examples."""

import re
import textwrap


def step(text, number):
    """The lines of step `number` ("// 3. ..."), dedented: to the next step, or to where its block closes. None without
    such a step."""
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if re.match(rf"\s*// {number}\. ", line)]
    if not starts:
        return None
    indent = len(lines[starts[0]]) - len(lines[starts[0]].lstrip())
    piece = []
    for i in range(starts[0], len(lines)):
        line = lines[i]
        if i > starts[0] and re.match(r"\s*// \d+\. ", line):
            break
        if line.strip() and len(line) - len(line.lstrip()) < indent:
            break
        piece.append(line)
    while piece and not piece[-1].strip():
        piece.pop()
    return textwrap.dedent("\n".join(piece))
