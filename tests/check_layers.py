#!/usr/bin/env python3
"""Refuses an include that points upwards in the layers, that does not start at the root of the tree, or that gives a
layer below the tools a way to open files or to print.

usage: check_layers.py ROOT | --self-test
"""
import pathlib
import re
import sys
import tempfile

LAYERS = ["formats", "codec", "converters", "tools", "tests"]  # each may include itself and those before it
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
LIBRARY_LAYERS = {"formats", "codec", "converters"}
FILES_AND_PRINTING = {"fcntl.h", "filesystem", "fstream", "iostream", "print", "unistd.h"}
SUFFIXES = {".h", ".cpp", ".inc"}


def violations(root):
    found = []
    for position, layer in enumerate(LAYERS):
        allowed = LAYERS[: position + 1]
        for path in sorted((root / layer).rglob("*")):
            # The consumer is another project, which knows installed headers only.
            if path.suffix not in SUFFIXES or root / "tests" / "consumer" in path.parents:
                continue
            text = path.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(text):
                bracket, target = match.groups()
                where = f"{path.relative_to(root)}:{text.count(chr(10), 0, match.start(2)) + 1}"
                first = target.split("/")[0]
                if first in LAYERS and first not in allowed:
                    found.append(f"{where}: {layer} must not include {target}")
                elif first in LAYERS and bracket == "<":
                    found.append(f'{where}: write "{target}" with quotes')
                elif layer in LIBRARY_LAYERS and target in FILES_AND_PRINTING:
                    found.append(f"{where}: only tools opens files or prints, so {layer} has no use for {target}")
                elif bracket == '"' and (first not in LAYERS or not (root / target).is_file()):
                    found.append(f'{where}: "{target}" is not a file of this tree, seen from its root')
    return found


def self_test():
    cases = {
        '#include "codec/b.h"\n': True,
        '#include <vector>\n#include "formats/a.h"\n': False,
        '#include "a.h"\n': True,
        '#include "../formats/a.h"\n': True,
        "#include <formats/a.h>\n": True,
        "#include <fstream>\n": True,
        '#  include "tools/c.h"\n': True,
        '// #include "tools/c.h"\n': False,
    }
    for text, refused in cases.items():
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for layer in LAYERS:
                (root / layer).mkdir()
            for header in ["formats/a.h", "codec/b.h", "tools/c.h"]:
                (root / header).write_text("")
            (root / "formats/a.cpp").write_text(text)
            assert bool(violations(root)) == refused, text


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    found = violations(pathlib.Path(sys.argv[1]))
    print("\n".join(found) or "every include is one that its layer may have")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
