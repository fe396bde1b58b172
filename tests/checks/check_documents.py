"""Checks sizes of documents, sources, functions and public headers, and that what the documents name exists.

Usage: check_documents.py ROOT        prints every violation as file:line: reason
       check_documents.py --self-test plants one violation of each kind and expects it to be found
"""
import pathlib
import re
import sys
import tempfile
import unittest

import check_layering

README_WORDS = 700
OVERVIEW_LINES = 120
DECISION_LINES = 15
DECISION_PARTS = ["Question", "Choice", "Rejected", "Evidence", "Revisit when"]
COLUMNS = 165  # of src/README.md and decisions: more would get around the limits of lines
SOURCE_LINES = 400
HEADER_LINES = 200
FUNCTION_LINES = 60
PUBLIC_LINES = 600  # headers of a room together
LONG_FUNCTIONS = {  # "file: function": why it is longer; five at most
    "src/geom/bvh.h: nearest_leaves": "the loop of every foot point: compiled as one, so that its state stays in registers",
}
DOCUMENTS = ["README.md", "src/README.md", "samples/README.md", "tests/README.md"]
LINK = re.compile(r"\]\(([^)#\s]+)[^)]*\)")
NAMED_TEST = re.compile(r"`([A-Za-z0-9_]+_test\.cpp)`")
NAMED_PATH = re.compile(r"`((?:src|include|tools|tests|samples)/[\w./-]+)(?=[` ])")  # ROOM stands for any
NAMED_DECISION = re.compile(r"decisions/([\w-]+\.md)")


def sources(root, *trees):
    for tree in trees:
        yield from (f for f in sorted((root / tree).rglob("*")) if f.suffix in (".cpp", ".h"))


def plain_code(text):
    """The text with comments, literals and preprocessor lines blanked out; line breaks stay."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])+\''
                         r"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.DOTALL | re.MULTILINE)
    return pattern.sub(lambda m: "\n" * m[0].count("\n") or " ", text)


def functions(text):
    """(line, name, number of lines) of each outermost function body; lambdas count with the function around them."""
    code, stack, head = plain_code(text), [], ""
    line = 1
    for c in code:
        if c == "{":
            text_before = re.sub(r"\balignas\s*\([^)]*\)|\[\[.*?\]\]", "", head).strip()
            inside = stack and stack[-1][0] != "scope"
            if inside or text_before.endswith("=") or (text_before and ")" not in text_before and not re.search(
                    r"\b(namespace|class|struct|union|enum|extern)\b", text_before)):
                kind = "other"
            elif re.search(r"\b(namespace|class|struct|union|enum)\b[^()]*$", text_before) or text_before == "extern":
                kind = "scope"
            else:
                kind = "function"
            name = re.search(r"(operator\s*\S+?|~?\w+)\s*\(", text_before)
            stack.append((kind, line, name[1] if name else "?"))
            head = ""
        elif c == "}":
            if stack:
                kind, start, name = stack.pop()
                if kind == "function":
                    yield start, name, line - start + 1
            head = ""
        elif c == ";":
            head = ""
        else:
            head += c
        line += c == "\n"


def check_sizes(root):
    long_functions = set()
    for file in sources(root, "src", "include", "tools", "tests"):
        path, text = file.relative_to(root), file.read_text()
        limit = HEADER_LINES if file.suffix == ".h" else SOURCE_LINES
        if text.count("\n") > limit:
            yield f"{path}:1: {text.count(chr(10))} lines, at most {limit}"
        for line, name, length in functions(text) if path.parts[0] != "tests" else []:
            key = f"{path}: {name}"
            if length > FUNCTION_LINES and key in LONG_FUNCTIONS:
                long_functions.add(key)
            elif length > FUNCTION_LINES:
                yield f"{path}:{line}: {name} has {length} lines, at most {FUNCTION_LINES}"
    for key in sorted(set(LONG_FUNCTIONS) - long_functions):
        yield f"tests/checks/check_documents.py:1: '{key}' needs no exception"
    for room in sorted(p for p in (root / "include" / "patchwright").glob("*") if p.is_dir()):
        total = sum(f.read_text().count("\n") for f in room.rglob("*.h"))
        if total > PUBLIC_LINES:
            yield f"{room.relative_to(root)}:1: public headers have {total} lines together, at most {PUBLIC_LINES}"


def check_decisions(root):
    numbers = set()
    for file in sorted((root / "src" / "decisions").glob("*")):
        path, lines = file.relative_to(root), file.read_text().splitlines()
        if not re.fullmatch(r"\d{3}-[a-z0-9-]+\.md", file.name) or file.name[:3] in numbers:
            yield f"{path}:1: a decision is a file NNN-title.md with a number of its own"
        numbers.add(file.name[:3])
        if len(lines) > DECISION_LINES:
            yield f"{path}:1: {len(lines)} lines, at most {DECISION_LINES}"
        for part in DECISION_PARTS:
            if not any(line.startswith(f"* {part}") for line in lines):
                yield f"{path}:1: no line '* {part}'"


def check_overview(root):
    """src/README.md: its size, and its table of rooms against the arrows that check_layering enforces."""
    file = root / "src" / "README.md"
    if not file.exists():
        return
    lines = file.read_text().splitlines()
    if len(lines) > OVERVIEW_LINES:
        yield f"src/README.md:1: {len(lines)} lines, at most {OVERVIEW_LINES}"
    rooms = {}
    for line in lines:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 3 and re.match(r"`\w+`", cells[0]):
            rooms[re.match(r"`(\w+)`", cells[0])[1]] = set(re.findall(r"`(\w+)`", cells[2]))
    for room, arrows in check_layering.ARROWS.items():
        if rooms.get(room) != set(arrows):
            yield f"src/README.md:1: its table of rooms gives {room} other arrows than check_layering.py"


def check_names(root):
    """Links and paths in documents, and decisions named in comments, exist."""
    tests = {f.name for f in (root / "tests").rglob("*.cpp")}
    decisions = {f.name for f in (root / "src" / "decisions").glob("*.md")}
    documents = [root / d for d in DOCUMENTS if (root / d).exists()] + sorted((root / "src" / "decisions").glob("*.md"))
    for file in documents:
        path = file.relative_to(root)
        for number, line in enumerate(file.read_text().splitlines(), 1):
            if len(line) > COLUMNS and path.parts[0] == "src":
                yield f"{path}:{number}: {len(line)} columns, at most {COLUMNS}"
            for link in LINK.findall(line):
                if "://" not in link and not (file.parent / link).exists():
                    yield f"{path}:{number}: no file {link}"
            for name in NAMED_TEST.findall(line):
                if name not in tests:
                    yield f"{path}:{number}: no test {name}"
            for name in NAMED_PATH.findall(line):
                if not (root / name).exists() and "ROOM" not in name:
                    yield f"{path}:{number}: no file {name}"
    for file in sources(root, "src", "include", "tools", "tests"):
        for number, line in enumerate(file.read_text().splitlines(), 1):
            for name in NAMED_DECISION.findall(line):
                if name not in decisions:
                    yield f"{file.relative_to(root)}:{number}: no decision {name}"


def check_readme(root):
    """README.md: its size, and its example, which a test builds and runs."""
    file, example = root / "README.md", root / "tests" / "consumer" / "use_convert.cpp"
    text = file.read_text() if file.exists() else ""
    if len(text.split()) > README_WORDS:
        yield f"README.md:1: {len(text.split())} words, at most {README_WORDS}"
    code = re.search(r"```cpp\n(.*?)```", text, re.DOTALL)
    if code and not (example.exists() and example.read_text() == code[1]):
        yield "README.md:1: the example is not tests/consumer/use_convert.cpp"


def violations(root):
    return [*check_readme(root), *check_overview(root), *check_decisions(root), *check_names(root), *check_sizes(root)]


class SelfTest(unittest.TestCase):
    def setUp(self):
        self.exceptions = dict(LONG_FUNCTIONS)
        LONG_FUNCTIONS.clear()

    def tearDown(self):
        LONG_FUNCTIONS.update(self.exceptions)

    def check(self, file, text, *expected):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / file).parent.mkdir(parents=True, exist_ok=True)
            (root / file).write_text(text)
            found = violations(root)
        self.assertEqual(len(found), len(expected), found)
        for line, part in zip(found, expected):
            self.assertIn(part, line)

    def test_functions(self):
        code = ('namespace a {\nstruct [[nodiscard]] B : C<int> {\n  B(int x) : c_{x}, d_{1} {\n    e();\n  }\n'
                '  int f() const { return \'}\' + 1\'000; }  // {\n};\nconst int table[] = {\n1,\n2};\n'
                'template <class T> auto g(T t) -> int\n{\n  auto h = [&](int i) {\n    if (i) {\n"}{";\n}\n  };\n}\n'
                '#define M \\\n {\nenum class E { A };\n}\n')
        bodies = [(name, length) for _, name, length in functions(code) if length > 1]
        self.assertEqual(bodies, [("?", 3), ("g", 7)])

    def test_long_functions(self):
        body = "x();\n" * FUNCTION_LINES
        self.check("src/fit/a.cpp", f"void f(int a)\n{{\n{body}}}\n", "a.cpp:2: f has 62 lines, at most 60")
        self.check("tests/fit/a_test.cpp", f"void f() {{\n{body}}}\n")
        LONG_FUNCTIONS["src/fit/a.cpp: f"] = "because"
        self.check("src/fit/a.cpp", f"void f() {{\n{body}}}\n")
        self.check("src/fit/a.cpp", "void f() {}\n", "needs no exception")

    def test_sizes(self):
        self.check("src/fit/a.cpp", "\n" * 401, "a.cpp:1: 401 lines")
        self.check("src/fit/a.h", "\n" * 201, "a.h:1: 201 lines")
        for room, lines, found in (("fit", 601, 2), ("fit", 200, 0)):
            self.check(f"include/patchwright/{room}/a.h", "\n" * lines, *["lines"] * found)
        self.check("README.md", "word " * 701, "README.md:1: 701 words")

    def test_decisions(self):
        good = "# Title\n\n" + "\n".join(f"* {part}: text" for part in DECISION_PARTS) + "\n"
        self.check("src/decisions/001-a.md", good)
        self.check("src/decisions/a.md", good, "a decision is a file")
        self.check("src/decisions/001-a.md", good.replace("* Evidence", "* Proof"), "no line '* Evidence'")
        self.check("src/decisions/001-a.md", good + "\n" * 20, "27 lines, at most 15")
        self.check("src/decisions/001-a.md", good.replace("text", "long " * 40, 1), "columns, at most")

    def test_names(self):
        self.check("README.md", "[a](b.md), [b](https://example.org/c.md), [c](README.md#d)\n", "README.md:1: no file b.md")
        self.check("tests/README.md", "`a_test.cpp` and `tests/b.py`\n", "no test a_test.cpp", "no file tests/b.py")
        self.check("src/fit/a.cpp", "// see src/decisions/001-a.md\n", "a.cpp:1: no decision 001-a.md")

    def test_example(self):
        self.check("README.md", "```cpp\nint main() {}\n```\n", "the example is not")

    def test_rooms(self):
        rows = [f"| `{room}` | text | {', '.join(f'`{other}`' for other in arrows) or 'std'} |\n"
                for room, arrows in check_layering.ARROWS.items()]
        self.check("src/README.md", "".join(rows))
        self.check("src/README.md", "".join(rows[1:]), "gives base other arrows")


def main():
    if sys.argv[1:] == ["--self-test"]:
        unittest.main(argv=sys.argv[:1])
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    if len(LONG_FUNCTIONS) > 5:
        found.append("tests/checks/check_documents.py:1: more than five exceptions")
    print("\n".join(found) if found else "Documents and sizes hold.")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
