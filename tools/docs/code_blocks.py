"""Every code block of every page is kept true in one of these ways:

C++    cut from a source that the tests compile and run: found there, line by line and in order
       or compiled and run: it has a prelude, and goes into the one generated source
       or run by another test, that a comment names
shell  its commands exist; a comment says which test runs it, or why none does
others (cmake, python, ...) run by a test, or theirs

    code_blocks.py check            every block is one of these
    code_blocks.py list             and which
    code_blocks.py generate OUT.cpp the source that tests/docs compiles and runs
"""

import functools
import os
import pathlib
import re
import sys

import pages
import pieces

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = ("examples/*.cpp", "examples/studies/*.cpp", "docs/site/code/*.cpp",
           "tests/**/*.cpp", "plugins/**/*.cpp", "engine/**/*.h", "joints/**/*.h", "bodies/**/*.h", "integrators/**/*.h")  # in the tests
BUILDS = ("tests/package/CMakeLists.txt",)
FRONT = ("README.md",)  # its shell blocks are looked at, and need no comment
MEMBERS = "members of "
PROGRAMS = "docs/site/code/*.cpp"  # by this one
CPP = ("cpp",)
TEXT = ("", "text", "csv", "json", "md", "html", "diff", "xml")  # no code
DIRECTIVES = ("{toctree}", "{math}", "{note}", "{tip}", "{warning}", "{table}", "{csv-table}", "{raw}", "{image}",
              "{figure}", "{list-table}", "{admonition}", "{important}", "{dropdown}")


def meaningful(line):
    return line.strip() not in ("", "...", "// ...")


@functools.cache
def sources():
    """Each source with its lines, without indents, and the set of them."""
    found = []
    for pattern in SOURCES:
        for path in sorted(ROOT.glob(pattern)):
            lines = [line.strip() for line in path.read_text().splitlines()]
            found.append((path.relative_to(ROOT), lines, set(lines)))
    return found


def source_of(block):
    """The source that has the block's lines, in order (indents and what lies between aside); None: none has."""
    wanted = [line.strip() for line in block.text.splitlines() if meaningful(line)]
    for path, lines, there in sources():
        rest = iter(lines)
        if wanted and there.issuperset(wanted) and all(line in rest for line in wanted):
            return path
    return None


def build_of(block):
    """The CMakeLists.txt of a test that has the block's commands, words in any order; None: none has."""
    def words(line):
        return set(re.sub(r"#.*", "", line).replace("(", "( ").replace(")", " )").split())

    wanted = [words(line) for line in block.text.splitlines() if words(line)]
    for build in BUILDS:
        lines = [words(line) for line in (ROOT / build).read_text().splitlines()]
        if wanted and all(any(some <= line for line in lines) for some in wanted):
            return build
    return None


def prelude_of(name):
    """A prelude is NAME/prelude.h of the site, else tools/docs/preludes/NAME.h; it defines lithe::NAME::Scene. A block is
    the body of a function run() of a class derived from that, or with "members of NAME" a part of such a class."""
    name = name.removeprefix(MEMBERS)
    for path in (ROOT / "docs/site" / name / "prelude.h", ROOT / "tools/docs/preludes" / f"{name}.h"):
        if path.exists():
            return path.relative_to(ROOT).as_posix()
    return None


def test_exists(name):
    """A test of that name is registered somewhere in tests/, or a script of that name exists."""
    if (ROOT / name).exists() or (name.startswith("examples/") and (ROOT / f"{name}.cpp").exists()):
        return True
    return any(re.search(rf"NAME {re.escape(name)}\b", path.read_text())
               for path in (ROOT / "tests").rglob("CMakeLists.txt"))


def shell_error(block):
    """What is wrong with the commands of a shell block: a script, preset, sub-command that does not exist."""
    commands = {path.stem.removesuffix("_command") for path in (ROOT / "tools/lithe").glob("*_command.cpp")}
    presets = re.findall(r'"name": "(\w+)"', (ROOT / "CMakePresets.json").read_text())
    code = re.sub(r"\\\n", " ", block.text)
    for line in code.splitlines():
        line = re.sub(r"(^|\s)#.*$", "", line)
        for command in re.split(r"&&|\|\||;|\|", line):
            words = command.split()
            while words and re.match(r"[A-Z_]+=", words[0]):
                words = words[1:]
            if not words:
                continue
            first = words[0]
            if re.match(r"(\./)?(tools|tests)/", first) and not (ROOT / first).exists():
                return f"there is no {first}"
            if first == "lithe" and len(words) > 1 and words[1] not in commands and not words[1].startswith("-"):
                return f"the command lithe has no '{words[1]}'"
            if "--preset" in words and words[words.index("--preset") + 1] not in presets:
                return f"there is no preset {words[words.index('--preset') + 1]}"
    return None


def judge(block):
    """(kind, detail) of a block; kind 'wrong' with what is wrong."""
    language, marks = block.language, block.marks
    if language in DIRECTIVES or language in TEXT or language.startswith("{admonition"):
        return ("text", "")
    if "theirs" in marks:
        return ("theirs", marks["theirs"])
    if "run by" in marks:
        return ("run by", marks["run by"]) if test_exists(marks["run by"]) else (
            "wrong", f"there is no test '{marks['run by']}'")
    if language == "{step}":
        path, number = block.argument.split()
        source = ROOT / path
        if source.exists() and pieces.step(source.read_text(), int(number)) is not None:
            return ("cut", path)
        return ("wrong", f"{path} has no step {number}")
    if language == "{literalinclude}":
        return literal(block)
    if language.startswith("{doxygen"):
        return ("text", "")
    if language in CPP:
        source = source_of(block)
        if source:
            return ("cut", source.as_posix())
        if "not run" in marks and marks["not run"]:
            return ("not run", marks["not run"])
        if "prelude" in marks:
            if prelude_of(marks["prelude"]):
                return ("compiled", marks["prelude"])
            return ("wrong", f"there is no prelude '{marks['prelude']}'")
        return ("wrong", "it is no piece of an example and has no prelude to be compiled with")
    if language == "cmake" and build_of(block):
        return ("cut", build_of(block))
    if language in ("sh", "bash", "console"):
        error = shell_error(block)
        if error:
            return ("wrong", error)
        if marks.get("not run") or str(block.page) in FRONT:
            return ("not run", marks.get("not run") or "its commands exist")
        return ("wrong", "a comment must say who runs these commands, or why nobody does")
    if "not run" in marks and marks["not run"]:
        return ("not run", marks["not run"])
    return ("wrong", f"nothing keeps a block of '{language}' true: say who runs it, or whose it is")


def literal(block):
    path = ((ROOT / block.page).parent / block.argument).resolve()
    if not path.exists():
        return ("wrong", f"there is no {block.argument}")
    text = path.read_text()
    for option in ("start-at", "start-after", "end-before", "end-at"):
        for marker in re.findall(rf'^:{option}:\s*"?(.*?)"?\s*$', block.text, re.M):
            if marker not in text:
                return ("wrong", f"{block.argument} has no '{marker}'")
    relative = path.relative_to(ROOT).as_posix()
    if relative.endswith((".cpp", ".h")) and not any(path in ROOT.glob(p) for p in SOURCES + ("plugins/*/*.cpp",)):
        return ("wrong", f"no test runs {relative}")
    return ("cut", relative)


def all_blocks():
    return [block for page in pages.pages(ROOT) for block in pages.blocks(ROOT, page)]


def untaught():
    """Examples without a page of the tutorial."""
    taught = {path.stem for path in (ROOT / "docs/site/tutorial").glob("[0-9]*.md")}
    return [path for path in sorted((ROOT / "examples").glob("[0-9]*.cpp")) if path.stem not in taught]


def check():
    wrong = [(block.place, judge(block)[1], block.text) for block in all_blocks() if judge(block)[0] == "wrong"]
    for place, why, text in wrong:
        first = next((line for line in text.splitlines() if line.strip()), "")
        print(f"error: a code block is not kept true: {why}\n  at:   {place}: {first.strip()}\n"
              "  fix:  see tools/docs/code_blocks.py", file=sys.stderr)
    for example in untaught():
        print(f"error: {example.relative_to(ROOT)} has no page in the tutorial\n"
              f"  fix:  write docs/site/tutorial/{example.stem}.md", file=sys.stderr)
    return 1 if wrong or untaught() else 0


def listing():
    counts = {}
    for block in all_blocks():
        kind, detail = judge(block)
        if kind == "text":
            continue
        counts[kind] = counts.get(kind, 0) + 1
        print(f"{kind:9} {block.language:16} {block.place}  {detail}")
    print(", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    return 0


def generate(out):
    """One function a block, of a scene made by its prelude; the programs of docs/site/code each in a namespace."""
    compiled = [block for block in all_blocks() if judge(block)[0] == "compiled"]
    preludes = sorted({block.marks["prelude"].removeprefix(MEMBERS) for block in compiled})
    code = ["// Generated by tools/docs/code_blocks.py: every code block of the pages that no example has.",
            "#include <cmath>", "#include <cstdio>", "#include <exception>", "#include <functional>",
            "#include <string>", "#include <utility>", "#include <vector>", '#include "lithe/lithe.h"', ""]
    code += [f'#include "{prelude_of(name)}"' for name in preludes]
    programs = sorted(ROOT.glob(PROGRAMS))
    for path in programs:
        code += [f"namespace program_{path.stem} {{", f'#include "{path.relative_to(ROOT).as_posix()}"', "}"]
    code += ["", "using namespace lithe;", "namespace {"]
    calls = []
    goes_on = []
    for block in compiled:
        name = block.marks["prelude"]
        if "goes on" in block.marks:
            goes_on[-1][1].append(block)
            continue
        goes_on.append((name, [block]))
    for number, (name, group) in enumerate(goes_on):
        members = name.startswith(MEMBERS)
        code += [f"struct Block{number} : lithe::{name.removeprefix(MEMBERS)}::Scene {{"]
        code += [] if members else ["  void run() {"]
        for block in group:
            code += [f'#line {block.line} "{(ROOT / block.page).as_posix()}"', block.text]
        code += ["};"] if members else ["  }", "};"]
        calls.append((group[0].place, f"[] {{ return Block{number}().run(), 0; }}"))
    code += ["}  // namespace", f'#line {len(code)} "docs_code.cpp"', "", "int main() {",
             "  const std::vector<std::pair<std::string, std::function<int()>>> blocks = {"]
    calls += [(path.relative_to(ROOT).as_posix(), f"program_{path.stem}::main") for path in programs]
    code += [f'      {{"{place}", {call}}},' for place, call in calls]
    code += ["  };", "  int failed = 0;", "  for (const auto& [place, run] : blocks) {", "    int result = 1;",
             "    try {", "      result = run();", "    } catch (const std::exception& error) {",
             '      std::fprintf(stderr, "%s\\n", error.what());', "    }", "    if (result != 0) {",
             '      std::fprintf(stderr, "error: the code block at %s fails\\n", place.c_str());', "      ++failed;",
             "    }", "  }", '  std::printf("%zu blocks and programs of the pages, %d fail\\n", blocks.size(), failed);',
             "  return failed == 0 ? 0 : 1;", "}", ""]
    text = "\n".join(code)
    out = pathlib.Path(out)
    if not out.exists() or out.read_text() != text:  # unchanged: nothing to compile
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(text)
    return 0


def main():
    command = sys.argv[1] if len(sys.argv) > 1 else "check"
    if command == "generate":
        return generate(sys.argv[2])
    return {"check": check, "list": listing}[command]()


if __name__ == "__main__":
    try:
        sys.exit(main())
    except BrokenPipeError:
        os._exit(0)
