#!/usr/bin/env python3
"""Runs the commands in README.md, in their order, and finds every file of the tree that it and specs/*.md link to.

usage: check_readme.py SOURCE_DIR PROGRAM | --self-test

Commands are the lines of fenced blocks that call `sbrdf`. They run in a folder that holds what a reader has already:
material.bsdf, and some sliced files in materials/.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
CALL = re.compile(r"(^|\| |/)sbrdf ")
LINK = re.compile(r"!?\[[^\]]*\]\(([^)#\s]+)(?:#[^)]*)?\)")
LEAST_COMMANDS = 10
SLOWEST = 300  # seconds, for one command on a slow machine that does something else as well


def commands(text):
    """Of blocks without a language, without what follows a `#`, and as if the program were in PATH."""
    for language, block in FENCE.findall(text):
        for line in block.splitlines():
            command = re.sub(r"\s+#.*", "", line).replace("build/release/sbrdf", "sbrdf")
            if not language and CALL.search(command):
                yield command


def prepare(root, folder, program):
    vectors = root / "tests" / "vectors"
    (folder / "bin").mkdir()
    (folder / "bin" / "sbrdf").symlink_to(program)
    shutil.copy(vectors / "rgl" / "small.bsdf", folder / "material.bsdf")
    (folder / "materials").mkdir()
    shutil.copy(vectors / "sbrdf" / "accept" / "guide.sbrdf", folder / "materials" / "leather.sbrdf")
    shutil.copy(vectors / "sbrdf" / "accept" / "elevation-linear.sbrdf", folder / "materials" / "wood.sbrdf")


def run(command, folder):
    """What is wrong with it, or none."""
    environment = {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}
    try:
        done = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=folder, env=environment, capture_output=True,
                              text=True, timeout=SLOWEST, check=False)
    except subprocess.TimeoutExpired:
        return f"takes longer than {SLOWEST} s"
    if done.returncode != 0:
        return f"exit code {done.returncode}: {done.stderr.strip()}"
    return None if done.stdout.strip() else "says nothing"


def broken_commands(root, program):
    # The default number of samples takes the longest, and 500 ask as much of the program.
    found = [c if c != "sbrdf convert material.bsdf material.sbrdf" else c + " --samples 500"
             for c in commands((root / "README.md").read_text(encoding="utf-8"))]
    if len(found) < LEAST_COMMANDS:
        yield f"README.md: only {len(found)} commands were found"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prepare(root, folder, program)
        for command in found:
            wrong = run(command, folder)
            if wrong:
                yield f"README.md: {command}: {wrong}"


def broken_links(root):
    for page in [root / "README.md", *sorted((root / "specs").rglob("*.md"))]:
        for target in LINK.findall(page.read_text(encoding="utf-8")):
            if ":" not in target and not (page.parent / target).exists():
                yield f"{page.relative_to(root)}: links to {target}, which is not there"


def self_test():
    text = "```\nsbrdf a b  # c\n./run\nprintf x | sbrdf d\n```\n```cpp\nsbrdf e\n```\nsbrdf f\n```\nbuild/release/sbrdf g\n```\n"
    assert list(commands(text)) == ["sbrdf a b", "printf x | sbrdf d", "sbrdf g"], list(commands(text))
    with tempfile.TemporaryDirectory() as name:
        root = pathlib.Path(name)
        (root / "specs").mkdir()
        (root / "README.md").write_text("[a](specs/a.md) ![b](https://b.c/d) [e](specs/f.md#g)")
        (root / "specs" / "a.md").write_text("[up](../README.md#h)")
        assert list(broken_links(root)) == ["README.md: links to specs/f.md, which is not there"]
        assert run("true", root) == "says nothing" and run("echo; exit 3", root).startswith("exit code 3")
        assert run("false | echo x", root).startswith("exit code 1") and run("echo x", root) is None


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return 0
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    root, program = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    found = [*broken_links(root), *broken_commands(root, program)]
    print("\n".join(found) or "every command runs, every link leads to a file")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
