"""The API reference's pages, one a topic, written for Breathe: reference.py PUBLIC_HEADER_ROOT OUT WARNINGS.

Which header belongs to which topic stands below; a public header that no topic names fails. What Doxygen finds without
a comment is listed in undocumented.md.
"""

import fnmatch
import pathlib
import re
import sys

# (page, title, what it holds, headers)
TOPICS = [
    ("scene", "Drawing a scene", "The graph, its bodies, joints and markers, and what `assemble` makes of it.",
     ["engine/system_graph.h", "engine/marker.h", "engine/ground.h", "engine/element.h", "engine/system.h",
      "engine/snapshot.h", "engine/state.h", "engine/math.h", "engine/motion_law.h", "engine/joint_coordinate.h",
      "engine/simplification.h", "engine/deformable_body.h", "engine/error.h", "engine/checks.h", "engine/drawn.h",
      "engine/log.h", "engine/located.h", "engine/version.h"]),
    ("running", "Running it", "The loop, what watches it, what happens on the way.",
     ["engine/simulation.h", "engine/integrator.h", "engine/observer.h", "engine/recorder.h", "engine/event*.h",
      "engine/watches.h", "engine/lean_simulation.h", "engine/islands.h", "engine/sleeping_integrator.h",
      "engine/mode_freezing.h", "engine/projection.h", "engine/interrupt.h", "engine/checkpoint/*.h"]),
    ("sensors", "Sensors", "What is read off a state: pure functions of a snapshot.",
     ["engine/sensors.h", "engine/contact/contact_sensors.h"]),
    ("bodies", "Bodies", "What has mass.", ["bodies/*.h"]),
    ("flexible", "Flexible bodies", "From a finite-element code's nodes, M and K to modes, motion and stress.",
     ["bodies/flexible/*.h"]),
    ("joints", "Joints and drives", "What ties markers.", ["joints/*.h"]),
    ("forces", "Forces", "What pulls at markers and coordinates.", ["joints/forces/*.h"]),
    ("contact", "Contact", "Shapes, laws and the element between them.",
     ["joints/contact/*.h", "engine/contact/*.h"]),
    ("integrators", "Integrators", "What advances time.", ["integrators/*.h"]),
    ("analysis", "Analyses", "Equilibrium, kinematics, linearization, Campbell diagrams, descriptions.",
     ["engine/analysis/*.h", "engine/equilibrium.h"]),
    ("study", "Studies", "Work against precision, sweeps, the doctor, `solve()` and its certificate.",
     ["engine/study/*.h"]),
    ("output", "Results", "Tables, charts, files; the run as one page.", ["engine/output/*.h", "engine/page/*.h"]),
    ("extending", "Interfaces for your own", "What a body, joint, force, integrator or plug-in implements.",
     ["engine/body.h", "engine/constraint.h", "engine/force_element.h", "engine/connector.h", "engine/batch.h",
      "engine/equations_of_motion.h", "engine/plugin*.h", "engine/registry.h", "engine/loaded_*.h",
      "engine/parameters.h", "engine/field.h", "engine/memory*.h"]),
    ("machinery", "Machinery", "What stands between a graph and an integrator; for those who work on the engine.",
     ["engine/*.h"]),
]
SECTIONS = ("briefdescription detaileddescription innerclass func typedef enum var public-func public-attrib "
            "public-type public-static-func public-static-attrib define user-defined")
EXCLUDED = ["*_internal.h", "*/detail/*", "engine/plugin_abi.h", "engine/batch_of.h", "engine/block_kernels.h", "engine/plugin_tables.h"]


def public_headers(root):
    for folder in ("engine", "bodies", "joints", "integrators"):
        for header in sorted((root / folder).rglob("*.h")):
            name = header.relative_to(root).as_posix()
            if not any(fnmatch.fnmatch(name, pattern) for pattern in EXCLUDED):
                yield name


def assign(headers):
    """Topic page -> headers; the first topic that names a header has it, a named file before a pattern."""
    pages = {page: [] for page, *_ in TOPICS}
    for header in headers:
        named = [page for page, _, _, patterns in TOPICS if header in patterns]
        fitting = [page for page, _, _, patterns in TOPICS if any(fnmatch.fnmatch(header, p) for p in patterns)]
        if not fitting:
            sys.exit(f"error: no topic has {header}\n  mend: name it in tools/docs/reference.py")
        pages[(named or fitting)[0]].append(header)
    return pages


def write_topics(root, out):
    pages = assign(public_headers(root))
    for page, title, words, _ in TOPICS:
        lines = [f"# {title}", "", words, ""]
        for header in pages[page]:
            lines += [f"## {header}", "",
                      f"```{{doxygenfile}} {header}", f":sections: {SECTIONS}", "```", ""]
        (out / f"{page}.md").write_text("\n".join(lines))
    toc = "\n".join(page for page, *_ in TOPICS)
    rows = "\n".join(f"| [{title}]({page}.md) | {words} | {len(pages[page])} |" for page, title, words, _ in TOPICS)
    (out / "index.md").write_text(
        "# API reference\n\nThe public headers of `engine/`, `bodies/`, `joints/` and `integrators/`, by topic, from "
        "their own comments. `#include \"lithe/lithe.h\"` has them all; namespace `lithe`.\n\n"
        f"| topic | what | headers |\n|---|---|---|\n{rows}\n\n"
        "Not here: `engine/plugin_abi.h`, the C border of plug-ins, which is read as it stands. What has no comment yet is [listed](undocumented.md).\n\n"
        f"```{{toctree}}\n:hidden:\n\n{toc}\nundocumented\n```\n")


def write_undocumented(warnings, out):
    found = {}
    for line in warnings.read_text().splitlines() if warnings.exists() else []:
        match = re.match(r"(.*?):(\d+): (?:warning: )?(?:Member|Compound) (.*) \((.*)\) of .* is not documented", line)
        match = match or re.match(r"(.*?):(\d+): (?:warning: )?(?:Compound) (.*?)() is not documented", line)
        if match:
            name = pathlib.Path(match[1]).resolve().relative_to(pathlib.Path.cwd()).as_posix()
            found.setdefault(name, set()).add((int(match[2]), match[3], match[4]))
    total = sum(map(len, found.values()))
    lines = ["# Without a comment", "",
             f"{total} public names that Doxygen finds no comment on: mostly those that their name and type explain. "
             "A name that should have one is a defect.", ""]
    for name in sorted(found):
        entries = sorted(found[name])
        shown = ", ".join(f"`{text.replace('`', '')}`" for _, text, _ in entries)
        lines += [f"**{name}**: {shown}", ""]
    (out / "undocumented.md").write_text("\n".join(lines))
    return total


def main():
    root, out, warnings = map(pathlib.Path, sys.argv[1:4])
    out.mkdir(parents=True, exist_ok=True)
    write_topics(root, out)
    print(f"reference: {len(TOPICS)} topics, {write_undocumented(warnings, out)} names without a comment")


if __name__ == "__main__":
    main()
