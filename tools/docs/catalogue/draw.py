#!/usr/bin/env python3
"""Draws the pictures of the catalogue into docs/pictures/catalogue: tools/docs/catalogue/draw.py [--check] [name ...]

--check draws nothing and fails where a file is not what this script draws, is too large, or is of no use here.
"""

import argparse
import importlib
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
FOLDER = ROOT / "docs/pictures/catalogue"
LARGEST = 8000  # bytes
MODULES = [
    "joints_pictures",
    "transmissions_pictures",
    "gears_pictures",
    "bearings_pictures",
    "forces_pictures",
    "friction_pictures",
    "ropes_pictures",
    "control_pictures",
    "bodies_pictures",
    "cable_pictures",
    "primitives_pictures",
    "tyre_pictures",
    "contact_pictures",
    "integrators_pictures",
    "loads_pictures",
]


def alike(a, b):
    """The same text, its numbers to 0.2: other machines round other digits."""
    number = r"-?\d+\.?\d*"
    return re.split(number, a) == re.split(number, b) and all(
        abs(float(x) - float(y)) < 0.2 for x, y in zip(re.findall(number, a), re.findall(number, b))
    )


def pictures():
    sys.path.insert(0, str(HERE))
    found = {}
    for module in MODULES:
        found.update(importlib.import_module(module).PICTURES)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    complaints = []
    all_pictures = pictures()
    for name, draw in all_pictures.items():
        if arguments.names and name not in arguments.names:
            continue
        path, text = FOLDER / f"{name}.svg", draw().svg()
        if len(text.encode()) > LARGEST:
            complaints.append(f"{path.name} has {len(text.encode())} bytes; at most {LARGEST} are meant")
        if arguments.check:
            if not path.exists() or not alike(path.read_text(), text):
                complaints.append(f"{path.name} is not what draw.py draws: run tools/docs/catalogue/draw.py")
        else:
            path.write_text(text)
    for path in FOLDER.glob("*.svg"):
        if path.stem not in all_pictures:
            complaints.append(f"{path.name} is drawn by no script")
    for complaint in complaints:
        print(complaint)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
