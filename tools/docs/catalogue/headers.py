"""What the headers of Lithe say: public types, their bases, the fields of their parameters."""

import re


def without_comments(text):
    return re.sub(r"/\*.*?\*/", "", re.sub(r"//[^\n]*", "", text), flags=re.S)


def matching(text, start):
    """Place behind the brace that closes the one at `start`."""
    depth = 0
    for i in range(start, len(text)):
        if text[i] == "{":
            depth += 1
        elif text[i] == "}":
            depth -= 1
            if depth == 0:
                return i + 1
    raise ValueError("a brace is not closed")


class Type:
    def __init__(self, name, kind, bases, body, header):
        self.name, self.kind, self.bases, self.body, self.header = name, kind, bases, body, header

    def nested(self, name):
        at = re.search(rf"\bstruct {name} (?:final )?{{", self.body)
        return self.body[at.end() : matching(self.body, at.end() - 1) - 1] if at else None

    def shape(self):
        """(markers, rows) where the compiler knows them, else None."""
        found = re.search(r"(?:Joint|Force)<\s*(\d+),\s*(\d+)\s*>", self.bases)
        return (int(found[1]), int(found[2])) if found else None

    def coordinates(self):
        """Functions that return a coordinate of the joint."""
        return re.findall(r"\bJointCoordinate (\w+)\(\) const", self.body)


def types_of(path, header):
    """Types at the level of the namespace, in the order of the file."""
    text = without_comments(path.read_text())
    found = []
    for at in re.finditer(r"^(class|struct|enum class) (\w+)(?: final)?\s*(?::([^{;]*))?{", text, re.M):
        end = matching(text, at.end() - 1)
        found.append(Type(at[2], at[1], " ".join((at[3] or "").split()), text[at.end() : end - 1], header))
    return found


def statements(body):
    """Pieces of a struct's body that end with a semicolon, functions and nested types left out."""
    piece, i = "", 0
    while i < len(body):
        if body[i] == "{":
            end = matching(body, i)
            inside = body[i:end]
            rest = body[end:].lstrip()
            piece += inside
            i = end
            if "(" in piece.split("{")[0] and not piece.split("{")[0].rstrip().endswith("=") and not rest.startswith(";"):
                piece = ""  # a function with its body
            continue
        if body[i] == ";":
            yield " ".join(piece.split())
            piece = ""
        else:
            piece += body[i]
        i += 1


def split_declarators(text):
    """At the commas outside of brackets."""
    parts, depth, last = [], 0, ""
    for c in text:
        depth += c in "({[<"
        depth -= c in ")}]>"
        if c == "," and depth == 0:
            parts.append(last.strip())
            last = ""
        else:
            last += c
    return [*parts, last.strip()]


def normal_default(text):
    text = text.strip()
    for long, short in (
        ("-std::numeric_limits<double>::infinity()", "−∞"),
        ("std::numeric_limits<double>::infinity()", "∞"),
    ):
        text = text.replace(long, short)
    return text


def fields(body):
    """{name: (type, default)} of a struct of plain members; no default: an empty text."""
    result = {}
    for statement in statements(body):
        if re.match(r"(static|using|enum|struct|class|template|friend|explicit|virtual|operator|bool operator)\b", statement):
            continue
        head = re.match(r"((?:const )?[\w:]+(?:<.*?>(?=\s+\w+))?(?:::\w+)?[&*]?\s*[*&]?) ?(\w+.*)", statement)
        if not head or re.match(r"\w+\s*\(", head[2]):
            continue
        for declarator in split_declarators(head[2]):
            name = re.match(r"\w+", declarator)[0]
            rest = declarator[len(name) :].strip()
            if rest.startswith("="):
                default = rest[1:].strip()
            elif rest.startswith("{"):
                default = rest
            elif rest:
                break
            else:
                default = ""
            result[name] = (head[1].strip(), normal_default(default))
    return result


def functions_returning(path, result):
    """Names of the free functions of a header that return `result`."""
    return sorted(set(re.findall(rf"^{result} (\w+)\(", without_comments(path.read_text()), re.M)))
