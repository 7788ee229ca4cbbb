#!/usr/bin/env python3
"""Refuses an include that points upwards, between layers or between the rooms of one, that does not start at the root of
the tree, or that gives a layer below the tools a way to open files or to print; a room that has grown too full; and two
types of one name, of which a program would take either.

usage: check_layers.py ROOT | --self-test
"""
import pathlib
import re
import sys
import tempfile

LAYERS = ["formats", "codec", "converters", "tools", "tests"]  # each may include itself and those before it
# Of each room of a layer: the other rooms of that layer that it may include. A folder that is not listed is an error.
ROOMS = {
    "formats": {
        "core": [],
        "os": ["core"],
        "merl": ["core"],
        "rgl": ["core"],
        "sbrdf": ["core"],
        "ngan": ["core"],
        "utia": ["core"],
        "zemax": ["core"],
        "klems": ["core"],
        "table": ["core"],
        "texture": ["core", "table", "sbrdf"],
    },
    "codec": {
        "frame": [],
        "mask": [],
        "curves": ["frame"],
        "material": ["frame", "mask", "curves"],
        "evaluation": ["frame", "curves", "material"],
        "sampling": ["frame", "curves", "material"],
        "atlas": ["frame", "material", "evaluation"],
        "search": ["frame", "material", "evaluation", "sampling"],
        "fit": ["frame", "curves", "material", "evaluation", "search"],
        "importance": [],
        "entropy": [],
        "coding": ["frame", "material", "entropy"],
        "file": ["frame", "mask", "material", "evaluation", "entropy", "coding"],
        "series": ["frame", "material", "evaluation", "entropy", "file"],
    },
    "converters": {
        "source": [],
        "json": [],
        "difference": ["source"],
        "models": ["source"],
        "tables": ["source", "difference"],
        "drawing": ["source"],
        "slicing": ["source", "difference", "drawing"],
        "series": ["source", "difference", "drawing", "slicing"],
        "files": ["source", "json", "difference", "models", "tables", "slicing", "series", "baselines"],
        "scene": ["source", "json"],
        "baselines": ["source", "json"],
        "judge": ["source", "difference", "tables", "slicing"],
        "bench": ["source", "difference", "tables", "slicing", "files", "baselines", "judge"],
        "audit": ["source", "difference", "models", "drawing", "tables", "slicing", "files", "baselines", "judge"],
        "paper": ["source", "difference", "models", "slicing", "files", "baselines", "judge"],
        "stress": ["source", "models", "slicing", "files", "judge"],
        "api": ["files"],
    },
    "tools": {
        "console": [],
        "io": ["console"],
        "charts": ["console"],
        "conversion": ["console", "io"],
        "bench": ["console", "io", "charts"],
        "audit": ["console", "io", "charts"],
        "commands": ["console", "io", "conversion", "bench", "audit"],
    },
}
MOST_FILES = 15  # in one folder
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
LIBRARY_LAYERS = {"formats", "codec", "converters"}
FILE_ROOM = "formats/os/"  # the one place below the tools that opens files
OPENERS = ("converters/files/by_name.", "converters/baselines/schemes.", "converters/api/", "tools/", "tests/")  # and who may use it
FILES_AND_PRINTING = {"fcntl.h", "filesystem", "fstream", "iostream", "print", "unistd.h"}
SUFFIXES = {".h", ".cpp", ".inc"}
FRONT_DOOR = "converters/api/sbrdf/"  # a namespace of its own
HIDDEN = re.compile(r"^namespace \{\n.*?^\}  // namespace$", re.MULTILINE | re.DOTALL)
TYPE = re.compile(r"^(?:class|struct|enum class) (\w+)(?!\w*::)[^;\n]*\{$", re.MULTILINE)
TAKEN = "struct Taken {\n};\n"  # what one header holds in the self-test


def room_of(parts):
    """The room of a path below the root; none for a file that lies in its layer itself."""
    return parts[1] if len(parts) > 2 else None


def check_room(layer, room, target_room):
    rooms = ROOMS.get(layer)
    if rooms is None or room is None or room == target_room:
        return True
    return room in rooms and target_room in rooms[room]


def check_include(root, path, bracket, target):
    """What is wrong with an include, or none."""
    layer, *_ = parts = path.relative_to(root).parts
    first, *_ = target_parts = target.split("/")
    if first in LAYERS and first not in LAYERS[: LAYERS.index(layer) + 1]:
        return f"{layer} must not include {target}"
    if first in LAYERS and bracket == "<":
        return f'write "{target}" with quotes'
    name = path.relative_to(root).as_posix()
    if layer in LIBRARY_LAYERS and target in FILES_AND_PRINTING and not name.startswith(FILE_ROOM):
        return f"only tools and {FILE_ROOM} open files or print, so {layer} has no use for {target}"
    if target.startswith(FILE_ROOM) and not name.startswith((FILE_ROOM, *OPENERS)):
        return f"only {', '.join(OPENERS)} may open files"
    if bracket == '"' and (first not in LAYERS or not (root / target).is_file()):
        return f'"{target}" is not a file of this tree, seen from its root'
    if first == layer and not check_room(layer, room_of(parts), room_of(target_parts)):
        return f"{layer}/{room_of(parts)} must not include {target}"
    return None


def doubled_types(root):
    """Types of one name in several files. No compiler or linker tells: a program takes any of them, destructors too."""
    found = {}
    for path in sorted(path for layer in LAYERS[:-1] for path in (root / layer).rglob("*")):
        if path.suffix not in SUFFIXES or path.relative_to(root).as_posix().startswith(FRONT_DOOR):
            continue
        text = HIDDEN.sub("", path.read_text(encoding="utf-8"))
        for match in TYPE.finditer(text):
            found.setdefault(match.group(1), set()).add(path.relative_to(root).as_posix())
    return [f"{', '.join(sorted(files))}: each has a type {name}" for name, files in found.items() if len(files) > 1]


def violations(root):
    found = doubled_types(root)
    for layer in LAYERS:
        for folder in sorted({path.parent for path in (root / layer).rglob("*") if path.is_file()}):
            room = room_of((*folder.relative_to(root).parts, "."))
            if room and layer in ROOMS and room not in ROOMS[layer] and list(folder.glob("*.cpp")):
                found.append(f"{folder.relative_to(root)}: not a room of {layer}")
            sources = [path for path in folder.iterdir() if path.suffix in SUFFIXES]
            if len(sources) > MOST_FILES:
                found.append(f"{folder.relative_to(root)}: {len(sources)} files; a room holds at most {MOST_FILES}")
        for path in sorted((root / layer).rglob("*")):
            # The consumer and the examples are other projects, which know the installed header only.
            if path.suffix not in SUFFIXES or {root / "tests/consumer", root / "tests/examples"} & set(path.parents):
                continue
            text = path.read_text(encoding="utf-8")
            for match in INCLUDE.finditer(text):
                wrong = check_include(root, path, *match.groups())
                if wrong:
                    line = text.count(chr(10), 0, match.start(2)) + 1
                    found.append(f"{path.relative_to(root)}:{line}: {wrong}")
    return found


def self_test():
    cases = [
        ("codec/search/t.h", "struct Taken {\n};\n", True),
        ("codec/search/t.h", "class Taken final : public Other {\n};\n", True),
        ("codec/search/t.h", "struct Taken;\nstruct Outer {\n  struct Taken {\n  };\n};\n", False),
        ("codec/search/t.cpp", "namespace {\nstruct Taken {\n};\n}  // namespace\n", False),
        ("codec/search/t.cpp", "struct Taken::Inner {\n};\n", False),
        ("tests/codec/t.cpp", "struct Taken {\n};\n", False),
        ("formats/core/a.cpp", '#include "codec/frame/b.h"\n', True),
        ("formats/core/a.cpp", '#include <vector>\n#include "formats/core/a.h"\n', False),
        ("formats/core/a.cpp", '#include "a.h"\n', True),
        ("formats/core/a.cpp", '#include "../core/a.h"\n', True),
        ("formats/core/a.cpp", "#include <formats/core/a.h>\n", True),
        ("formats/core/a.cpp", "#include <fstream>\n", True),
        ("formats/core/a.cpp", '#  include "tools/c.h"\n', True),
        ("formats/core/a.cpp", '// #include "tools/c.h"\n', False),
        # Between rooms.
        ("codec/frame/b.cpp", '#include "codec/material/m.h"\n', True),
        ("codec/material/m.cpp", '#include "codec/frame/b.h"\n', False),
        ("codec/material/m.cpp", '#include "formats/core/a.h"\n', False),
        ("codec/search/s.cpp", '#include "codec/material/m.h"\n', False),
        ("codec/material/m.cpp", '#include "codec/search/s.h"\n', True),
        ("codec/frame/b.cpp", '#include "formats/os/o.h"\n', True),
        ("tools/main.cpp", '#include "formats/os/o.h"\n', False),
        ("formats/os/o.cpp", "#include <fcntl.h>\n", False),
        ("codec/attic/a.cpp", "\n", True),
        ("tests/codec/t.cpp", '#include "codec/search/s.h"\n', False),
        ("tools/main.cpp", '#include "tools/c.h"\n#include "codec/search/s.h"\n', False),
    ]
    headers = ["formats/core/a.h", "codec/frame/b.h", "codec/material/m.h", "codec/search/s.h", "tools/c.h", "formats/os/o.h"]
    for name, text, refused in cases:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for path in [name, *headers]:
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text if path == name else TAKEN if path == "formats/core/a.h" else "")
            assert bool(violations(root)) == refused, (name, text, violations(root))
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "codec/frame").mkdir(parents=True)
        for number in range(MOST_FILES + 1):
            assert not violations(root)
            (root / f"codec/frame/f{number}.h").write_text("")
        assert violations(root)


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    found = violations(pathlib.Path(sys.argv[1]))
    print("\n".join(found) or "every include is one that its layer and room may have, and no room is too full")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
