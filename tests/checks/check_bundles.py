#!/usr/bin/env python3
"""Program and reference reader agree on every bundle, and every rule of specs/sbrdfz.md has a bundle that breaks it.

usage: check_bundles.py SOURCE_DIR DUMP_PROGRAM
"""
import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

CLAUSE = re.compile(r"\[(SZ-\d+-\d+)\]")
sys.dont_write_bytecode = True


def clause_of(path):
    return re.match(r"SZ-\d+-\d+", path.stem).group()


def vectors(root, kind):
    found = sorted((root / "tests" / "vectors" / "sbrdfz" / kind).glob("*.sbrdfz"))
    if not found:
        raise SystemExit(f"no vectors to {kind}")
    return found


def dump(program, path, out):
    done = subprocess.run([program, path, out], capture_output=True, check=False)
    return done.returncode, done.stderr.decode(errors="replace").strip()


def check_accepted(reference, program, path, out):
    try:
        files = list(reference.Bundle(path.read_bytes()).files())
    except reference.Refused as refused:
        yield f"the reference reader refuses it: {refused}"
        return
    if reference.summary_of(path.read_bytes()) != json.loads(path.with_suffix(".json").read_text(encoding="utf-8")):
        yield "the reference reader finds other files in it than are expected"
    code, message = dump(program, path, out)
    expected = b"".join(struct.pack("<Q", len(part)) + part for name, file in files for part in (name.encode(), file))
    if code != 0:
        yield f"the program refuses it: {message}"
    elif out.read_bytes() != expected:
        yield "program and reference reader find other files in it"


def check_rejected(reference, program, path, out):
    code, message = dump(program, path, out)
    if f"[{clause_of(path)}]" not in message:
        yield f"program: {message or 'accepted'}"
    try:
        list(reference.Bundle(path.read_bytes()).files())
        yield "the reference reader accepts it"
    except reference.Refused as refused:
        if not str(refused).startswith(f"[{clause_of(path)}]"):
            yield f"reference reader: {refused}"
        if code != (4 if refused.unsupported else 3):
            yield f"program: exit code {code}; the reference reader says {refused}"


def check_rules(root, rejected):
    stated = set(CLAUSE.findall((root / "specs" / "sbrdfz.md").read_text(encoding="utf-8")))
    broken = set(map(clause_of, rejected))
    for clause in sorted(stated - broken):
        yield f"specs/sbrdfz.md: no vector breaks [{clause}]"
    for clause in sorted(broken - stated):
        yield f"specs/sbrdfz.md: has no [{clause}], which a vector breaks"


def problems(root, reference, program):
    accepted, rejected = vectors(root, "accept"), vectors(root, "reject")
    with tempfile.TemporaryDirectory() as name:
        for check, paths in ((check_accepted, accepted), (check_rejected, rejected)):
            for path in paths:
                for problem in check(reference, program, path, pathlib.Path(name) / "out"):
                    yield f"{path.parent.name}/{path.name}: {problem}"
    yield from check_rules(root, rejected)


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    root = pathlib.Path(sys.argv[1])
    sys.path.insert(0, str(root / "specs" / "reference"))
    import sbrdfz_reference as reference  # pylint: disable=import-outside-toplevel
    found = list(problems(root, reference, sys.argv[2]))
    for problem in found:
        print(problem)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
