"""A header as Doxygen is to see it: its declarations in the group of its topic (reference.py), the words behind a field as
the field's own, and nothing that Sphinx's parser of C++ does not know."""

import pathlib
import re
import sys

import reference

root = pathlib.Path.cwd()
path = pathlib.Path(sys.argv[1]).resolve()
text = path.read_text()
header = path.relative_to(root).as_posix()
# Sphinx knows neither explicit instantiations nor designated initialisers nor lambdas as defaults.
text = re.sub(r"^extern template[^;]*;", "", text, flags=re.M)
text = re.sub(r"(?<=[\w ])\{\.[^}]*\}(?=;)", "{}", text)
text = re.sub(r" = \[\].*;$", ";", text, flags=re.M)
# A class that another header only names would belong to two topics.
text = re.sub(r"^(template <[^>]*>\n?\s*)?(class|struct) \w+;.*$", "", text, flags=re.M)
# "double mass = 1;  // kg": a field's unit stands behind it.
text = re.sub(r"^(  (?!.*return)[^()\n]*;)  +// ", r"\1  ///< ", text, flags=re.M)
if not reference.excluded(header):
    topic = reference.topic_of(header)
    text = text.replace("\nnamespace lithe {\n", f"\nnamespace lithe {{\n/** @addtogroup {topic}\n@{{ */\n")
    # Members that are defined after their class are no part of the topic by themselves.
    end = re.search(r"^template <[^>\n]*>\n?[\w:<>&*, ]+ \w+::\w+\(", text, re.M) or re.search(
        r"^\}  // namespace lithe$", text, re.M)
    if end:
        text = text[:end.start()] + "/** @} */\n" + text[end.start():]
sys.stdout.write(text)
