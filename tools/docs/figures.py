"""Every picture of every page was made by a command that its page names, from inputs that have not changed since:
docs/figures.json keeps, for each, the command, its inputs and a hash of these, noted when the picture was made.

    figures.py check                 fails for a picture without a command, a command that does not exist, inputs that
                                     have changed, a file that is missing, and one that no page shows
    figures.py note [PATH ...]       notes the present inputs of all pictures below the paths (all pages' by default).
                                     Refuses where inputs have changed and the picture has not: make it again first
    figures.py note --same [PATH]    it was made again, and came out the same
    figures.py redraw                runs the commands of the pictures whose inputs have changed, and notes these pictures
"""

import fnmatch
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

import pages

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOOK = ROOT / "docs/figures.json"

# What a command draws from, if the page does not say; {0} is its first argument. Not the engine: a picture is stale when
# its scene, its data or the program that draws it has changed; that the engine still gives the same answers is what the
# other tests are for.
INPUTS = {
    "tools/docs/results.sh": ["examples/{0}_*.cpp"],
    "tools/demo.sh": ["examples/{0}_*.cpp"],
    "tools/charts.sh": ["examples/studies/{0}.cpp", "tools/charts/{0}.cpp"],
    "tools/bench.sh": ["tools/bench/chain.cpp", "tools/bench/chain_benchmark.cpp", "tools/bench/chains.py",
                       "tools/bench/charts.py", "tools/bench/scenes.cpp"],
    "tools/certify.sh": ["tools/certify/scenes*.cpp", "tools/certify/report.cpp"],
    "tools/stability.sh": ["tools/stability/scenes/*.cpp", "tools/stability/methods/*.cpp"],
    "tools/docs/catalogue/draw.py": ["tools/docs/catalogue/canvas.py", "tools/docs/catalogue/*_pictures.py"],
    "tests/page/run.sh": ["tests/page/pictures.mjs", "tools/pages/pages.cpp", "examples/21_page.cpp"],
    "tools/contact.sh": ["tools/contact/contact_chart.cpp", "tools/contact/known_motions.cpp"],
}
PICTURES = (".png", ".svg", ".jpg", ".gif")


def inputs_of(picture):
    """Paths relative to the root, sorted; what an example includes of examples/support and reads of examples/data too."""
    if picture.inputs:
        patterns = picture.inputs
    else:
        script, *arguments = picture.command.split()
        patterns = [pattern.format(*arguments) for pattern in INPUTS.get(script, [script])
                    if "{0}" not in pattern or arguments]
    found = {path for pattern in patterns for path in ROOT.glob(pattern) if path.is_file()}
    if picture.command.startswith("tools/docs/catalogue/draw.py "):  # the one script that draws it
        name = re.compile(rf"\b{re.escape(picture.command.split()[1])}\b")
        found = {path for path in found if not path.name.endswith("_pictures.py") or name.search(path.read_text())}
    for source in list(found):
        if source.suffix == ".cpp" and source.is_relative_to(ROOT / "examples"):
            text = source.read_text()
            for subject in set(re.findall(r"examples/support/([a-z]+)_", text)):  # pendulum_study.h: pendulum_*
                helpers = set((ROOT / "examples/support").glob(f"{subject}_*.[ch]*"))
                found |= helpers
                text += "".join(path.read_text() for path in helpers if path.suffix == ".cpp")
            for name in (folder.name for folder in (ROOT / "examples/data").iterdir() if folder.is_dir()):
                if f"/{name}" in text:
                    found.add(ROOT / "examples/data" / name)  # a folder counts as one
    return sorted(path.relative_to(ROOT).as_posix() for path in found)


_hashes = {}


def content_of(path):  # where headers lie changes no picture
    text = path.read_bytes()
    if path.suffix not in (".h", ".cpp"):
        return text
    return b"\n".join(line for line in text.split(b"\n") if not line.startswith(b'#include "'))


def file_hash(path):  # or of a folder's files
    if path not in _hashes:
        whole = hashlib.sha256()
        for part in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if part.is_file():
                whole.update(content_of(part))
        _hashes[path] = whole.hexdigest()
    return _hashes[path]


def inputs_hash(paths):
    whole = hashlib.sha256()
    for path in paths:
        whole.update(f"{path} {file_hash(ROOT / path)}\n".encode())
    return whole.hexdigest()[:16]


def shown_pictures():
    """Path relative to the root -> pictures of that file, by place."""
    shown = {}
    for page in pages.pages(ROOT):
        for picture in pages.pictures(ROOT, page):
            if picture.path.is_relative_to(ROOT):
                shown.setdefault(picture.path.relative_to(ROOT).as_posix(), []).append(picture)
    return shown


def command_of(pictures):
    """The picture whose comment tells the command: any page that shows it may."""
    return next((picture for picture in pictures if picture.command), None)


def read_book():
    return json.loads(BOOK.read_text()) if BOOK.exists() else {}


def errors():
    book, shown = read_book(), shown_pictures()
    for name, pictures in sorted(shown.items()):
        place, told = pictures[0].place, command_of(pictures)
        if not (ROOT / name).exists():
            yield f"there is no {name}", place, "make it, or take it out of the page"
        elif told is None:
            yield f"nothing says how {name} was made", place, "put <!-- made by: COMMAND --> below it"
        elif not (ROOT / told.command.split()[0]).exists():
            yield f"{name} was made by {told.command.split()[0]}, which does not exist", place, "name the command"
        elif not inputs_of(told):
            yield f"'{told.command}' of {name} has no inputs", place, "is its argument right?"
        elif name not in book:
            yield f"{name} is not in docs/figures.json", place, f"tools/docs/figures.py note {name}"
        elif book[name]["command"] != told.command:
            yield f"{name} was noted as made by '{book[name]['command']}'", place, f"tools/docs/figures.py note {name}"
        elif book[name]["hash"] != inputs_hash(inputs_of(told)):
            yield (f"{name} is stale: {', '.join(changed(book[name], told)) or 'its inputs'} changed since it was made",
                   place, f"{told.command}; tools/docs/figures.py note {name}")
    twins = {name.rsplit(".", 1)[0] for name in shown}
    for path in sorted((ROOT / "docs").rglob("*")):
        name = path.relative_to(ROOT).as_posix()
        if path.suffix in PICTURES and name.rsplit(".", 1)[0] not in twins and not any(
                part in pages.LEFT_OUT for part in path.relative_to(ROOT).parts):
            yield f"no page shows {name}", name, "show it or delete it"
    for name in sorted(set(book) - set(shown)):
        yield f"docs/figures.json has {name}, which no page shows", "docs/figures.json", "tools/docs/figures.py note"


def changed(entry, told):
    """Inputs that came, went or changed since the note."""
    now = {path: file_hash(ROOT / path)[:8] for path in inputs_of(told)}
    then = entry["inputs"]
    return sorted(path for path in now.keys() | then.keys() if now.get(path) != then.get(path))[:3]


def note(below, same):
    book, shown, refused = read_book(), shown_pictures(), []
    for name in set(book) - set(shown):
        del book[name]
    for name, pictures in sorted(shown.items()):
        told = command_of(pictures)
        if not told or not (ROOT / name).exists():
            continue
        if below and not any(name == path or name.startswith(path.rstrip("/") + "/") for path in below):
            continue
        inputs = inputs_of(told)
        entry = {"command": told.command, "hash": inputs_hash(inputs), "picture": file_hash(ROOT / name)[:16],
                 "inputs": {path: file_hash(ROOT / path)[:8] for path in inputs}}
        old = book.get(name)
        if old and old["hash"] != entry["hash"] and old["picture"] == entry["picture"] and not same:
            refused.append((name, told))
            continue
        book[name] = entry
    lines = ",\n".join(f"{json.dumps(name)}: {json.dumps(book[name], sort_keys=True)}" for name in sorted(book))
    BOOK.write_text("{\n" + lines + "\n}\n")
    for name, told in refused[:5]:
        print(f"error: the inputs of {name} have changed, the picture has not: "
              f"{', '.join(changed(book[name], told)) or 'fewer or more of them'}\n"
              f"  fix:  {told.command}; if it came out the same: tools/docs/figures.py note --same {name}",
              file=sys.stderr)
    if len(refused) > 5:
        print(f"error: and {len(refused) - 5} more", file=sys.stderr)
    print(f"{len(book)} pictures are in docs/figures.json")
    return 1 if refused else 0


def stale():
    """Path -> picture, of those whose inputs have changed since they were noted."""
    book = read_book()
    told = {name: command_of(pictures) for name, pictures in shown_pictures().items()}
    return {name: picture for name, picture in told.items()
            if picture and name in book and book[name]["hash"] != inputs_hash(inputs_of(picture))}


def redraw():
    failed = set()
    found = stale()
    if found:
        subprocess.run(["tools/install_packages.sh", "tools/docs/pictures_packages.txt"], cwd=ROOT, check=True)
    environment = os.environ | {"PATH": f"/usr/bin:{os.environ['PATH']}"}  # Debian's Python has numpy
    for command in sorted({picture.command for picture in found.values()}):
        print(f"== {command}", flush=True)
        if subprocess.run(command.split(), cwd=ROOT, env=environment, check=False).returncode != 0:
            failed.add(command)
            print(f"error: '{command}' fails\n  fix:  run it by hand; its pictures are not noted", file=sys.stderr)
    _hashes.clear()  # pictures are new
    drawn = [name for name, picture in found.items() if picture.command not in failed]
    return (note(drawn, same=True) if drawn else 0) or (1 if failed else 0)


def main():
    command, *paths = sys.argv[1:] or ["check"]
    if command == "redraw":
        return redraw()
    if command == "note":
        return note([path for path in paths if path != "--same"], "--same" in paths)
    found = list(errors())
    for what, where, fix in found[:10]:
        print(f"error: {what}\n  at:   {where}\n  fix:  {fix}", file=sys.stderr)
    if len(found) > 10:
        print(f"error: and {len(found) - 10} more", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
