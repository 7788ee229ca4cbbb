#!/usr/bin/env python3
"""Refuses files that name a path of one machine, and sources that no CMakeLists.txt lists.

usage: check_files.py ROOT | --self-test
"""
import pathlib
import re
import subprocess
import sys
import tempfile

# Roots under which people keep their own files: a path below them exists on one machine only.
MACHINE_PATH = re.compile(r"(?:^|[^A-Za-z0-9_./])(/(?:work|tmp|root|home|farm|mnt|Users)/[A-Za-z0-9][^\s\"']*)", re.MULTILINE)
# A folder without a list of its own is listed by the nearest one above.
LISTED_SUFFIXES = {".h", ".cpp"}
CODE_FOLDERS = {"formats", "codec", "converters", "tools", "tests"}


def project_files(root):
    """Those that git tracks or would track; without git, all but hidden folders and the build folder."""
    command = ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(command, capture_output=True, check=True)
        paths = [root / name for name in done.stdout.decode().split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        paths = []
        for path in root.rglob("*"):
            parts = path.relative_to(root).parts
            if parts[0] not in {"build", ".git", ".cache"}:
                paths.append(path)
    return sorted(path for path in paths if path.is_file())


def machine_paths(root, paths):
    found = []
    for path in paths:
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        for match in MACHINE_PATH.finditer(text):
            line = text.count("\n", 0, match.start(1)) + 1
            found.append(f"{path.relative_to(root)}:{line}: {match.group(1)} is a path of one machine")
    return found


def unlisted_sources(root, paths):
    found = []
    for path in paths:
        if path.suffix not in LISTED_SUFFIXES or path.relative_to(root).parts[0] not in CODE_FOLDERS:
            continue
        listing = next(folder for folder in path.parents if (folder / "CMakeLists.txt").is_file())
        words = (listing / "CMakeLists.txt").read_text(encoding="utf-8").replace(")", " ").split()
        if path.relative_to(listing).as_posix() not in words:
            found.append(f"{path.relative_to(root)}: not listed in {(listing / 'CMakeLists.txt').relative_to(root)}")
    return found


def violations(root):
    paths = project_files(root)
    return machine_paths(root, paths) + unlisted_sources(root, paths)


def self_test():
    home = "/".join(["", "home", "somebody", "brdf"])
    cases = [
        ("formats/a.cpp", "int a;\n", 0),
        ("formats/core/b.h", "int b;\n", 0),
        ("formats/core/c.h", "int c;\n", 1),
        ("formats/a.cpp", f'auto path = "{home}";\n', 1),
        ("notes.md", f"see {home}/x and x{home}\n", 1),
        ("notes.md", "an URL such as https://example.org/home/page\n", 0),
    ]
    for name, text, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "formats/core").mkdir(parents=True)
            (root / "formats/CMakeLists.txt").write_text("add_library(formats a.cpp\ncore/b.h)\n")
            (root / name).write_text(text)
            assert len(violations(root)) == expected, (name, text, violations(root))


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    print("\n".join(found) or "every source is listed and no file names a path of one machine")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
