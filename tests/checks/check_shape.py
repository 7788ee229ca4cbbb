#!/usr/bin/env python3
"""Refuses functions of the sources that have grown too long, and tells how much of each layer's headers is comment.

usage: check_shape.py ROOT | --self-test
"""
import pathlib
import re
import sys
import tempfile

MOST_LINES = 60  # of one function, from its name to its closing brace
LAYERS = ["formats", "codec", "converters", "tools"]
FRONT_DOOR = "converters/api/sbrdf/sbrdf.h"
# As clang-format writes them: a head ends with "{", and its body with "}" in the column in which the head began.
TYPE = re.compile(r"^(?:template.*)?(?:class|struct|enum|union|namespace|extern)\b")
STATEMENT = re.compile(r"^(?:else|if|for|while|switch|do|try|return|case|\})\b")
ENDS_BEFORE = re.compile(r"[;{}:>]$|^$|^\s*(?://|#)|\*/$")


def head_of(lines, at):
    """Where the head that ends at line `at` begins: behind the nearest line above that ends something else."""
    first = at
    while first > 0 and not ENDS_BEFORE.search(lines[first - 1]):
        first -= 1
    return first


def functions(text):
    """Head, first line and length of each definition that is in no other function."""
    lines = text.split("\n")
    at = 0
    while at < len(lines):
        first = head_of(lines, at) if lines[at].endswith("{") else at
        head = " ".join(line.strip() for line in lines[first : at + 1])
        if not lines[at].endswith("{") or "(" not in head or "= {" in head or TYPE.match(head) or STATEMENT.match(head):
            at += 1
            continue
        indent = re.match(" *", lines[first]).group()
        end = next((k for k in range(at + 1, len(lines)) if re.match(rf"{indent}\}}", lines[k])), at)
        yield head[:80], first + 1, end - first + 1
        at = end + 1


def comment_share(path):
    lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines()]
    lines = [line for line in lines if line]
    comments = [line for line in lines if line.startswith("//") or "///<" in line]
    return len(comments), len(lines)


def violations(root):
    found = []
    for layer in LAYERS:
        for path in sorted((root / layer).rglob("*")):
            if path.suffix not in {".h", ".cpp"}:
                continue
            for name, line, length in functions(path.read_text(encoding="utf-8")):
                if length > MOST_LINES:
                    found.append(f"{path.relative_to(root)}:{line}: {length} lines, at most {MOST_LINES}: {name}")
    return found


def self_test():
    long = "void f(int a,\n       int b) {\n" + "  g();\n" * MOST_LINES + "}\n"
    short = "int g() {\n  return 1;\n}\n" * MOST_LINES
    method = "class C {\n public:\n  void m() {\n" + "    g();\n" * MOST_LINES + "  }\n};\n"
    table = "constexpr std::array kTable = {\n" + "    1,\n" * MOST_LINES + "};\n"
    made = "class C {\n  C(int a)\n      : a_(a) {\n    g();\n  }\n" + "  int b_;\n" * MOST_LINES + "};\n"
    for text, expected in [(long, 1), (short, 0), (method, 1), (table, 0), (made, 0)]:
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            (root / "codec").mkdir()
            (root / "codec/a.cpp").write_text(text)
            assert len(violations(root)) == expected, (text[:40], violations(root))


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    root = pathlib.Path(sys.argv[1])
    for layer in LAYERS:
        pairs = [comment_share(path) for path in (root / layer).rglob("*.h")]
        print(f"{layer}: {100 * sum(c for c, _ in pairs) / sum(n for _, n in pairs):.0f} % of the headers is comment")
    comments, lines = comment_share(root / FRONT_DOOR)
    print(f"{FRONT_DOOR}: {100 * comments / lines:.0f} %")
    found = violations(root)
    print("\n".join(found) or f"no function is longer than {MOST_LINES} lines")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
