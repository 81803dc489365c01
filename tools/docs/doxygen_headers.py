"""The headers as Doxygen is to see them, below OUT: doxygen_headers.py OUT, in the repository's root. Declarations are in the
group of their topic (reference.py), the words behind a field are the field's own, lines of code and formulas in comments
are blocks, and nothing is left that Sphinx's parser of C++ does not know. All at once: a filter that Doxygen calls costs a
start of Python for each file."""

import pathlib
import re
import sys

import reference

LIST_ITEM = r"(?:[-*] |\d+\. )"


def blocks_in_comments(text):
    """Runs of lines of `///` with a deeper indent become blocks of code, except items of lists and what belongs to them."""
    out, open_at, in_list, before = [], None, False, ""
    for line in [*text.split("\n"), ""]:
        comment = re.match(r"( *)///( *)(.*)$", line)
        deep = comment and len(comment[2]) >= 3 and comment[3]
        if not comment or len(comment[2]) < 2:
            in_list = bool(comment and re.match(LIST_ITEM, comment[3]))
        if deep and re.match(LIST_ITEM, comment[3]):
            in_list = True
        if deep and not in_list and open_at is None and re.match(r" *///", before):
            open_at = comment[1]
            out.append(f"{open_at}/// @code{{.unparsed}}")
        elif open_at is not None and not deep:
            out.append(f"{open_at}/// @endcode")
            open_at = None
        out.append(line)
        before = line
    return "\n".join(out[:-1])


def as_seen(text, header):
    # Sphinx knows neither explicit instantiations nor designated initialisers nor lambdas as defaults.
    text = re.sub(r"^extern template[^;]*;", "", text, flags=re.M)
    text = re.sub(r"(?<= = )\{\.[^;\n]*\}(?=;)|(?<=\w)\{\.[^;\n]*\}(?=;)", "{}", text)
    text = re.sub(r" = \[\].*;$", ";", text, flags=re.M)
    # A class that another header only names would belong to two topics.
    text = re.sub(r"^(template <[^>]*>\n?\s*)?(class|struct) \w+;.*$", "", text, flags=re.M)
    # "double mass = 1;  // kg": a field's unit stands behind it.
    text = re.sub(r"^(  (?!.*return)[^()\n]*;)  +// ", r"\1  ///< ", text, flags=re.M)
    text = blocks_in_comments(text)
    if not reference.excluded(header):
        topic = reference.topic_of(header)
        text = text.replace("\nnamespace lithe {\n", f"\nnamespace lithe {{\n/** @addtogroup {topic}\n@{{ */\n")
        # Members that are defined after their class are no part of the topic by themselves.
        end = re.search(r"^template <[^>\n]*>\n?[\w:<>&*, ]+ \w+::\w+\(", text, re.M) or re.search(
            r"^\}  // namespace lithe$", text, re.M)
        if end:
            text = text[:end.start()] + "/** @} */\n" + text[end.start():]
    return text


def main():
    root, out = pathlib.Path.cwd(), pathlib.Path(sys.argv[1])
    for folder in reference.FOLDERS:
        for path in sorted((root / folder).rglob("*.h")):
            header = path.relative_to(root).as_posix()
            seen = out / header
            seen.parent.mkdir(parents=True, exist_ok=True)
            seen.write_text(as_seen(path.read_text(), header))


if __name__ == "__main__":
    main()
