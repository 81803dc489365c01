"""The API reference's pages, one a topic, written for Breathe: reference.py ROOT OUT DOXYGEN_XML.

Which header belongs to which topic stands below; a public header that no topic names fails. What Doxygen finds without
a comment is listed in undocumented.md.
"""

import fnmatch
import pathlib
import re
import sys
from xml.etree import ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "catalogue"))
import headers

FOLDERS = ("engine", "bodies", "joints", "integrators", "models")

# (page, title, what it holds, headers)
TOPICS = [
    ("scene", "Drawing a scene", "The graph, its bodies, joints and markers, and what `assemble` makes of it.",
     ["engine/model/system_graph.h", "engine/model/marker.h", "engine/model/ground.h", "engine/model/element.h",
      "engine/assembly/system.h",
      "engine/observe/snapshot.h", "engine/model/state.h", "engine/base/math.h", "engine/base/rotations.h",
      "engine/model/world_placement.h", "engine/model/motion_law.h", "engine/model/joint_coordinate.h",
      "engine/simplify/simplification.h", "engine/model/deformable_body.h", "engine/base/error.h",
      "engine/base/checks.h", "engine/model/initial_pose.h",
      "engine/base/log.h", "engine/base/version.h"]),
    ("running", "Running it", "The loop, what watches it, what happens on the way.",
     ["engine/run/simulation.h", "engine/motion/integrator.h", "engine/observe/observer.h",
      "engine/observe/recorder.h", "engine/observe/event.h", "engine/run/event_finder.h",
      "engine/observe/observer_schedules.h", "engine/model/islands.h",
      "engine/run/sleeping_integrator.h",
      "engine/run/mode_freezing.h", "engine/motion/projection.h", "engine/base/interrupt.h",
      "engine/run/checkpoint.h", "engine/archive/*.h"]),
    ("sensors", "Sensors", "What is read off a state: pure functions of a snapshot.",
     ["engine/observe/sensors.h", "engine/observe/contact_sensors.h"]),
    ("bodies", "Bodies", "What has mass.", ["bodies/*.h"]),
    ("flexible", "Flexible bodies", "From a finite-element code's nodes, M and K to modes, motion and stress.",
     ["bodies/flexible/*.h", "bodies/fatigue/*.h"]),
    ("beam", "Beams", "Slender bodies with large displacements.", ["bodies/beam/*.h", "bodies/cable/*.h"]),
    ("joints", "Joints and drives", "What ties markers.", ["joints/*.h"]),
    ("forces", "Forces", "What pulls at markers and coordinates.", ["joints/forces/*.h", "joints/rope/*.h", "joints/gears/*.h", "joints/aerodynamics/*.h", "joints/bearings/*.h"]),
    ("contact", "Contact", "Shapes, laws and the element between them.",
     ["joints/contact/*.h", "engine/contact/*.h", "engine/cones/*.h", "engine/model/contact_*.h"]),
    ("integrators", "Integrators", "What advances time.", ["integrators/*.h"]),
    ("analysis", "Analyses", "Equilibrium, kinematics, linearization, Campbell diagrams, descriptions.",
     ["engine/analysis/*.h"]),
    ("study", "Studies", "Work against precision, sweeps, the doctor, `solve()` and its certificate.",
     ["engine/study/*.h"]),
    ("output", "Results", "Tables, charts, files; the run as one page.", ["engine/output/*.h", "engine/page/*.h"]),
    ("models", "Models of other programs", "Read, drawn, exported, compiled.", ["models/*.h"]),
    ("extending", "Interfaces for your own", "What a body, joint, force, integrator or plug-in implements.",
     ["engine/model/body.h", "engine/model/point_body.h", "engine/model/constraint.h",
      "engine/model/force_element.h", "engine/model/connector.h", "engine/assembly/batch.h",
      "engine/motion/equations_of_motion.h", "engine/plugin*.h",
      "engine/base/parameters.h"]),
    ("machinery", "Machinery", "What stands between a graph and an integrator; for those who work on the engine.",
     ["engine/*.h"]),
]
EXCLUDED = ["*_internal.h", "*/detail/*", "engine/plugin_abi.h", "engine/assembly/batch_of.h",
            "engine/factor/block_kernels.h", "engine/plugin/plugin_tables.h"]
# What readers and reductions are made of is not public (tools/cmake/package.cmake).
EXCLUDED += [f"*/{name}.h" for name in (
    "dof_table", "fixed_columns", "matrix_entries", "ansys_archive", "nastran_deck", "shape_functions",
    "elastic_problem", "static_modes", "general_inertia", "eigen_modes", "quadratic_deflection", "text_file")]
WITHIN_CONDITIONS = ["Export"]  # #ifdef LITHE_PLUGIN


def excluded(header):
    return any(fnmatch.fnmatch(header, pattern) for pattern in EXCLUDED)


def public_headers(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.h")):
            header = path.relative_to(root).as_posix()
            if not excluded(header):
                yield header


def topic_of(header):
    """The topic that names a header, else that of its folder, else that of a folder above."""
    for fits in (lambda pattern: pattern == header,
                 lambda pattern: fnmatch.fnmatch(header, pattern) and pattern.count("/") == header.count("/"),
                 lambda pattern: pattern.endswith("/*.h") and header.startswith(pattern[:-3])):
        for page, _, _, patterns in TOPICS:
            if any(map(fits, patterns)):
                return page
    sys.exit(f"error: no topic has {header}\n  fix:  name it in tools/docs/reference.py")


def plain(element):
    return "".join(element.itertext()).strip() if element is not None else ""


class Declarations:
    """What Doxygen's XML says of each header's declarations: which have no comment."""

    def __init__(self, xml, root):
        self.undocumented = {}  # header -> names
        self.root = root
        for path in sorted(xml.glob("*.xml")):
            compound = ElementTree.parse(path).getroot().find("compounddef")
            kind = compound.get("kind") if compound is not None else None
            if kind in ("class", "struct") and compound.get("prot") != "private":
                self.add_class(compound)
            elif kind == "namespace":
                self.add_namespace(compound)

    def header(self, element):
        file = element.find("location").get("file")
        path = pathlib.Path(file)
        return (path.relative_to(self.root) if path.is_absolute() else path).as_posix()

    def told(self, element, header, name):
        if not plain(element.find("briefdescription")) and not plain(element.find("detaileddescription")):
            self.undocumented.setdefault(header, []).append(name)

    def add_class(self, compound):
        name = plain(compound.find("compoundname"))
        if not name.startswith("lithe") or "anonymous" in name or "@" in name or compound.get("prot") != "public":
            return
        header = self.header(compound)
        self.told(compound, header, name.removeprefix("lithe::"))
        for section in compound.findall("sectiondef"):
            for member in section.findall("memberdef"):
                if member.get("prot") == "public" and member.find("reimplements") is None:
                    self.told(member, header, name.removeprefix("lithe::") + "::" + plain(member.find("name")))

    def add_namespace(self, compound):
        space = plain(compound.find("compoundname"))
        if not space.startswith("lithe") or "detail" in space or "@" in space:
            return
        for member in (m for section in compound.findall("sectiondef") for m in section.findall("memberdef")):
            kind, name = member.get("kind"), plain(member.find("name"))
            if kind not in ("function", "enum", "typedef", "variable") or not name or "@" in name:
                continue
            header = self.header(member)
            self.told(member, header, name)


def lost(root, xml):
    """Public types that Doxygen did not see: what was done to their header for its sake spoilt it."""
    seen = (xml / "index.xml").read_text()
    for header in public_headers(root):
        for type_ in headers.types_of(root / header, header):
            found = re.search(rf"<name>(\w+::)*{type_.name}(&lt;.*)?</name>", seen)
            if not found and type_.name not in WITHIN_CONDITIONS:
                yield f"{header}: {type_.name}"


def write_topics(root, out):
    of_topic = {page: [] for page, *_ in TOPICS}
    for header in public_headers(root):
        of_topic[topic_of(header)].append(header)
    for page, title, words, _ in TOPICS:
        (out / f"{page}.md").write_text("\n".join([
            f"# {title}", "", words, "", "From " + ", ".join(f"`{header}`" for header in of_topic[page]) + ".", "",
            f"```{{doxygengroup}} {page}", ":content-only:", ":members:", ":undoc-members:", "```", ""]))
    toc = "\n".join(page for page, *_ in TOPICS)
    rows = "\n".join(f"| [{title}]({page}.md) | {words} | {len(of_topic[page])} |" for page, title, words, _ in TOPICS)
    (out / "index.md").write_text(
        "# API reference\n\nThe public headers of `engine/`, `bodies/`, `joints/`, `integrators/` and `models/`, by topic, from "
        "their own comments. `#include \"lithe/lithe.h\"` has them all; namespace `lithe`.\n\n"
        f"| topic | what | headers |\n|---|---|---|\n{rows}\n\n"
        "Not here: `engine/plugin_abi.h`, the C border of plug-ins, which is read as it stands. What has no comment yet "
        "is [listed](undocumented.md).\n\n"
        f"```{{toctree}}\n:hidden:\n\n{toc}\nundocumented\n```\n")


def write_undocumented(root, out, declared):
    public = set(public_headers(root))
    found = {header: sorted(set(names)) for header, names in declared.undocumented.items() if header in public}
    total = sum(map(len, found.values()))
    lines = ["# Without a comment", "",
             f"{total} public names without a comment of their own: mostly those that their name and type explain, and "
             "parameters with a comment behind them. A name that should have one is a defect.", ""]
    for name in sorted(found):
        lines += [f"**{name}**: {', '.join(f'`{text}`' for text in found[name])}", ""]
    (out / "undocumented.md").write_text("\n".join(lines))
    return total


def main():
    root, out, xml = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    out.mkdir(parents=True, exist_ok=True)
    missing = list(lost(root, xml))
    if missing:
        sys.exit(f"error: Doxygen lost {', '.join(missing)}\n  fix:  tools/docs/doxygen_headers.py")
    declared = Declarations(xml, root)
    write_topics(root, out)
    print(f"reference: {len(TOPICS)} topics, "
          f"{write_undocumented(root, out, declared)} names without a comment")


if __name__ == "__main__":
    main()
