#!/usr/bin/env python3
"""Checks the catalogue (docs/site/catalogue) against the headers: tools/docs/catalogue/check.py [--blocks FILE.cpp]

It fails where a public type has no page, a table lacks a parameter or names one that does not exist or tells another type
or default, a page counts other markers and rows than the class, a coordinate, sensor, shape or motion law goes
unnamed, a file that a page names is not there, or a picture is missing or of no use.
--blocks writes all code blocks as one translation unit with a main() that runs each in a scene of its own.
"""

import argparse
import pathlib
import re
import sys

import headers

ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGES = ROOT / "docs/site/catalogue"
PICTURES = ROOT / "docs/pictures/catalogue"

FOLDERS = ["joints", "joints/forces", "joints/contact", "joints/rope", "joints/gears", "joints/sliding", "bodies", "bodies/beam", "bodies/cable", "bodies/flexible", "bodies/flexible/readers", "joints/aerodynamics", "bodies/fatigue", "joints/bearings", "joints/tyre", "joints/control", "joints/hydraulics"]
FOLDERS += ["bodies/flexible/elements", "integrators", "plugins/massless_rod", "plugins/cam_follower"]
FOLDERS += ["plugins/inertial_body", "engine/cones", "engine/contact"]
FILES = ["engine/model/ground.h", "engine/model/input.h", "engine/model/adjustable.h", "engine/analysis/state_space.h", "engine/model/contact_element.h", "engine/model/contact_memory.h"]
FILES += ["engine/model/contact_point.h", "engine/observe/contact_sensors.h", "engine/run/mode_freezing.h"]
FILES += ["engine/run/sleeping_integrator.h", "engine/analysis/kinematics.h"]
FILES += ["engine/analysis/campbell.h", "engine/analysis/linearization.h", "engine/analysis/equilibrium.h", "engine/observe/event.h"]

# What is derived from one of these is a thing of the catalogue: it has a heading and a picture of its own.
BASES = r"\b(Joint<|Constraint|Force<|ForceElement|ContactElement|Body|DeformableBody|PointBody|Integrator|MomentumBalance)"
BASES += r"|\b(GeneralizedAlpha|Observer|ConeSolver)\b"
BASES_THEMSELVES = {"ContactElement": "the engine's side of Contact", "MomentumBalance": "what two integrators share"}

# Functions of which every one is named on a page.
FUNCTIONS = [
    ("engine/observe/sensors.h", "Sensor", "sensors.md"),
    ("engine/observe/contact_sensors.h", "Sensor", "sensors.md"),
    ("engine/analysis/kinematics.h", "Sensor", "sensors.md"),
    ("engine/model/motion_law.h", "MotionLaw", "drives.md"),
    ("engine/model/tension_law.h", "TensionLaw", "forces.md"),
    ("joints/rope/rope.h", "Sensor", "sensors.md"),
    ("joints/bearings/rolling_bearing.h", "Sensor", "sensors.md"),
    ("joints/bearings/journal_bearing.h", "Sensor", "sensors.md"),
    ("joints/sliding/sliding_joint.h", "Sensor", "sensors.md"),
    ("joints/aerodynamics/airfoil_strip.h", "Sensor", "sensors.md"),
    ("joints/aerodynamics/airfoil.h", "AirfoilLaw", "forces/airfoil.md"),
    ("bodies/flexible/cut_load.h", "Sensor", "sensors.md"),
    ("bodies/beam/section_load.h", "Sensor", "sensors.md"),
    ("joints/tyre/tyre.h", "Sensor", "tyres.md"),
    ("joints/contact/shapes.h", "Shape", "contact/shapes.md"),
    ("bodies/shapes.h", "MassProperties", "bodies/rigid_body.md"),
]


def catalogued_headers():
    for folder in FOLDERS:
        ending = "*.cpp" if folder in ("plugins/massless_rod", "plugins/cam_follower") else "*.h"
        for path in sorted((ROOT / folder).glob(ending)):
            if not path.stem.endswith("_internal"):
                yield path
    for name in FILES:
        yield ROOT / name


def types():
    found = {}
    for path in catalogued_headers():
        for type_ in headers.types_of(path, str(path.relative_to(ROOT))):
            found[type_.name] = type_
    return found


class Checker:
    def __init__(self):
        self.pages = {str(p.relative_to(PAGES)): p.read_text() for p in sorted(PAGES.rglob("*.md"))}
        self.types = types()
        self.complaints = []
        self.tables = set()

    def complain(self, page, text):
        self.complaints.append(f"{page}: {text}")

    # ---- every type has its place ----
    def check_types(self):
        everything = "\n".join(self.pages.values())
        words = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`\n]*)`", everything))))
        words.update(re.findall(r"\w+", " ".join(self.tables)))
        headings = {}
        for page, text in self.pages.items():
            for line in re.findall(r"^#+ (.*)$", text, re.M):
                for word in re.findall(r"\w+", line):
                    headings.setdefault(word, page)
        for type_ in self.types.values():
            if type_.name in BASES_THEMSELVES:
                continue
            if re.search(BASES, type_.bases):
                names = {type_.name, re.sub(r"(?<!^)([A-Z])", r"_\1", type_.name).lower()}
                page = next((headings[n] for n in names if n in headings), None)
                if not page:
                    self.complain(type_.header, f"'{type_.name}' has no heading in the catalogue")
                elif "![" not in self.pages[page]:
                    self.complain(page, f"has no picture of '{type_.name}'")
                if type_.nested("Parameters") is not None and type_.name + "::Parameters" not in self.tables:
                    self.complain(type_.header, f"the parameters of '{type_.name}' stand in no table")
            elif type_.name not in words:
                self.complain(type_.header, f"'{type_.name}' is named on no page of the catalogue")

    def check_machinery(self):
        """Every type named on the page of what stands behind is of the header beside it."""
        for line in self.pages.get("machinery.md", "").split("\n"):
            cells = [c.strip() for c in line.split("|")[1:-1]]
            if len(cells) == 3 and cells[0].startswith("`"):
                for name in re.findall(r"`(\w+)`", cells[1]):
                    if name not in self.types or self.types[name].header != cells[0].strip("`"):
                        self.complain("machinery.md", f"'{name}' is not of {cells[0]}")

    # ---- tables of parameters ----
    def check_tables(self):
        pattern = r"<!-- parameters: ([\w:]+) (\S+) -->\n((?:\|.*\n?)+)"
        for page, text in self.pages.items():
            for name, header, table in re.findall(pattern, text):
                self.tables.add(name)
                self.check_table(page, name, header, table)

    def check_table(self, page, name, header, table):
        owner = name.split("::")[0]
        type_ = next((t for t in headers.types_of(ROOT / header, header) if t.name == owner), None)
        body = type_ and (type_.nested(name.split("::")[1]) if "::" in name else type_.body)
        if body is None:
            return self.complain(page, f"{header} has no '{name}'")
        fields = headers.fields(body)
        told = {}
        for line in table.strip().split("\n")[2:]:
            cells = [c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]]
            told[cells[0].strip("`")] = cells
        for field in fields:
            if field not in told:
                self.complain(page, f"the table of {name} lacks '{field}'")
        for field, cells in told.items():
            if field not in fields:
                self.complain(page, f"the table of {name} names '{field}', which does not exist")
                continue
            if len(cells) != 6:
                self.complain(page, f"the row '{field}' of {name} has {len(cells)} cells, not 6")
                continue
            type_text, default = fields[field]
            if cells[1] != f"`{type_text}`":
                self.complain(page, f"'{field}' of {name} is a {type_text}, not {cells[1]}")
            if not re.match(re.escape(f"`{default}`" if default else "none") + r"(:|$)", cells[3]):
                self.complain(page, f"'{field}' of {name} is by default '{default or 'none'}', not {cells[3]}")

    # ---- what a page says of a class ----
    def check_facts(self):
        for page, text in self.pages.items():
            for title, part in self.sections(text):
                type_ = next((self.types[w] for w in re.findall(r"\w+", title) if w in self.types), None)
                if not type_:
                    continue
                facts = re.search(r"\*\*Markers\*\*.*?(?=\n\n)", part, re.S)
                if facts and type_.shape():
                    rows = re.search(r"\*\*(?:Rows|Compliant rows)\*\* (\d+)", facts[0])
                    if not rows or int(rows[1]) != type_.shape()[1]:
                        self.complain(page, f"'{type_.name}' has {type_.shape()[1]} rows")
                    free = re.search(r"\*\*Freedoms left\*\* (\d+)(?! v)", facts[0])
                    markers, count = type_.shape()
                    if free and markers == 2 and int(free[1]) != 6 - count:
                        self.complain(page, f"'{type_.name}' leaves {6 - count} freedoms")
                    if f"`{type_.header}`" not in " ".join(facts[0].split()):
                        self.complain(page, f"'{type_.name}' is of {type_.header}")
                for coordinate in type_.coordinates():
                    if f"`{coordinate}()`" not in text:
                        self.complain(page, f"the coordinate {coordinate}() of '{type_.name}' is not told")

    @staticmethod
    def sections(text):
        """(heading, text up to the next heading of a type or the end)."""
        places = [m.start() for m in re.finditer(r"^# |^## (?=[A-Z]\w+: )", text, re.M)] + [len(text)]
        return [(text[a : text.index("\n", a)], text[a:b]) for a, b in zip(places, places[1:])]

    def check_functions(self):
        for header, result, page in FUNCTIONS:
            text = self.pages.get(page, "")
            for name in headers.functions_returning(ROOT / header, result):
                if not re.search(rf"`[^`]*\b{name}\b[^`]*`", text):
                    self.complain(page, f"does not name {name}() of {header}")

    # ---- files, links, pictures ----
    def check_files(self):
        used = set()
        for page, text in self.pages.items():
            here = PAGES / page
            for alt, target in re.findall(r"!\[([^\]]*)\]\(([^)]+)\)", text):
                path = (here.parent / target).resolve()
                used.add(path)
                if not path.exists():
                    self.complain(page, f"the picture {target} is not there")
                if not alt.strip():
                    self.complain(page, f"the picture {target} has no words for those who do not see it")
            for target in re.findall(r"(?<!!)\[[^\]]*\]\(([^)#:]+\.md)(?:#[\w-]+)?\)", text):
                if not (here.parent / target).exists():
                    self.complain(page, f"the link {target} leads nowhere")
            plain = re.sub(r"```.*?```", "", text, flags=re.S)
            for name in re.findall(r"`((?:examples|tests|joints|engine|bodies|integrators|plugins|tools|docs)/[\w./]+)`", plain):
                if not (ROOT / name).exists():
                    self.complain(page, f"'{name}' does not exist")
        for path in PICTURES.glob("*.svg"):
            if path.resolve() not in used:
                self.complain(path.name, "is shown on no page")

    def check_trees(self):
        """Every page but the first is in a toctree of the catalogue."""
        listed = set()
        for page, text in self.pages.items():
            for tree in re.findall(r"```{toctree}\n(.*?)```", text, re.S):
                for line in tree.split("\n"):
                    if line and not line.startswith(":"):
                        listed.add(str((PAGES / page).parent.joinpath(line.strip() + ".md").resolve()))
        for page in self.pages:
            if page != "index.md" and str((PAGES / page).resolve()) not in listed:
                self.complain(page, "is in no toctree")

    def run(self):
        self.check_tables()
        self.check_types()
        self.check_machinery()
        self.check_facts()
        self.check_functions()
        self.check_files()
        self.check_trees()
        return self.complaints


def blocks():
    """(name, page, code) of every C++ block."""
    for path in sorted(PAGES.rglob("*.md")):
        page = path.relative_to(PAGES)
        for i, code in enumerate(re.findall(r"^```cpp\n(.*?)^```", path.read_text(), re.S | re.M)):
            yield f"{re.sub(r'[^a-z0-9]', '_', str(page.with_suffix('')))}_{i + 1}", str(page), code


def translation_unit():
    parts = ['#include "docs/site/catalogue/prelude.h"', "", "namespace lithe::catalogue {", ""]
    names = []
    for name, page, code in blocks():
        names.append(name)
        indented = "".join("    " + line + "\n" if line else "\n" for line in code.rstrip("\n").split("\n"))
        parts += [f"// {page}", f"struct {name} : Scene {{", "  void run() {", indented + "  }", "};", ""]
    parts += ["}  // namespace lithe::catalogue", "", "int main() {", "  using namespace lithe::catalogue;"]
    parts += [f'  std::puts("{name}"), {name}{{}}.run();' for name in names]
    return "\n".join([*parts, "}", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--blocks", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.blocks:
        arguments.blocks.write_text(translation_unit())
        return 0
    complaints = Checker().run()
    for complaint in complaints:
        print(complaint)
    print(f"{len(complaints)} complaints" if complaints else "the catalogue is complete and true to the headers")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
