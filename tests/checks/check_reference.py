#!/usr/bin/env python3
"""Codec and reference decoder agree on every vector, and every rule of specs/sbrdf.md has a file that breaks it.

usage: check_reference.py SOURCE_DIR DUMP_PROGRAM
       check_reference.py --record SOURCE_DIR    writes what is expected of accepted vectors that have no such file yet
"""
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tempfile

CLAUSE = re.compile(r"\[(SB-\d+-\d+)\]")
sys.dont_write_bytecode = True


def vectors(root, kind):
    found = sorted((root / "tests" / "vectors" / "sbrdf" / kind).glob("*.sbrdf"))
    if not found:
        raise SystemExit(f"no vectors to {kind}")
    return found


def summary_of(values, positions, samples):
    return {
        "values_sha256": hashlib.sha256(values).hexdigest(),
        "positions_sha256": hashlib.sha256(positions).hexdigest(),
        "values": len(values) // 4,
        "samples": samples,
    }


def reference_result(reference, path):
    """Values, positions and number of samples, or the refusal."""
    try:
        decoded = reference.Decoded(path.read_bytes())
    except reference.Refused as refused:
        return refused
    return decoded.values_bytes(), decoded.positions_bytes(), decoded.summary()["samples"]


def dump_result(program, path, folder):
    """Exit code, message, and the two files where there are any."""
    outputs = [folder / "values", folder / "positions"]
    for output in outputs:
        output.unlink(missing_ok=True)
    done = subprocess.run([program, path, *outputs], capture_output=True, check=False)
    contents = [output.read_bytes() if output.exists() else b"" for output in outputs]
    return done.returncode, done.stderr.decode(errors="replace").strip(), contents


def check_accepted(reference, program, path, folder):
    expected = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    result = reference_result(reference, path)
    if isinstance(result, reference.Refused):
        yield f"the reference decoder refuses it: {result}"
        return
    summary = summary_of(*result)
    for key, value in expected.items():
        if summary.get(key) != value:
            yield f"reference decoder: {key} is {summary.get(key)}, expected {value}"
    code, message, contents = dump_result(program, path, folder)
    if code != 0:
        yield f"the codec refuses it: {message}"
    elif contents != list(result[:2]):
        differing = [name for name, a, b in zip(("values", "positions"), contents, result) if a != b]
        yield f"codec and reference decoder differ in {' and '.join(differing)}"


def check_rejected(reference, program, path, folder):
    clause = re.match(r"SB-\d+-\d+", path.stem).group()
    result = reference_result(reference, path)
    if not isinstance(result, reference.Refused):
        yield "the reference decoder accepts it"
        return
    if not str(result).startswith(f"[{clause}]"):
        yield f"reference decoder: {result}"
    code, message, _ = dump_result(program, path, folder)
    if f"[{clause}]" not in message:
        yield f"codec: {message or 'accepted'}"
    if code != (4 if result.unsupported else 3):
        yield f"codec: exit code {code}; the reference decoder says {result}"


def check_rules(root, rejected):
    stated = set(CLAUSE.findall((root / "specs" / "sbrdf.md").read_text(encoding="utf-8")))
    broken = {re.match(r"SB-\d+-\d+", path.stem).group() for path in rejected}
    for clause in sorted(stated - broken):
        yield f"specs/sbrdf.md: no vector breaks [{clause}]"
    for clause in sorted(broken - stated):
        yield f"specs/sbrdf.md: has no [{clause}], which a vector breaks"


def check_worked_example(root):
    """The hexadecimal dump in the specification is the file that it names."""
    text = (root / "specs" / "sbrdf.md").read_text(encoding="utf-8")
    lines = re.findall(r"^([0-9a-f]{8}): ([0-9a-f ]+)$", text, re.MULTILINE)
    dumped = bytes.fromhex("".join(digits.replace(" ", "") for _, digits in lines))
    if dumped != (root / "tests" / "vectors" / "sbrdf" / "accept" / "worked-example.sbrdf").read_bytes():
        yield "specs/sbrdf.md: the worked example is not the file in tests/vectors"


def check_command_line(root, path, expected_code, expected_message):
    program = root / "specs" / "reference" / "sbrdf_reference.py"
    done = subprocess.run([sys.executable, "-B", program, path], capture_output=True, text=True, check=False)
    if done.returncode != expected_code or not done.stderr.startswith(expected_message):
        yield f"sbrdf_reference.py {path.name}: exit code {done.returncode}, {done.stderr.strip()}"
    if expected_code == 0 and "samples" not in json.loads(done.stdout):
        yield f"sbrdf_reference.py {path.name}: no number of samples"


def record(root, reference):
    for path in vectors(root, "accept"):
        target = path.with_suffix(".json")
        if not target.exists():
            summary = summary_of(*reference_result(reference, path))
            target.write_text(json.dumps(summary, indent=1) + "\n", encoding="utf-8")


def problems(root, reference, program):
    accepted, rejected = vectors(root, "accept"), vectors(root, "reject")
    with tempfile.TemporaryDirectory() as name:
        for check, paths in ((check_accepted, accepted), (check_rejected, rejected)):
            for path in paths:
                for problem in check(reference, program, path, pathlib.Path(name)):
                    yield f"{path.parent.name}/{path.name}: {problem}"
    yield from check_rules(root, rejected)
    yield from check_worked_example(root)
    folder = rejected[0].parent
    yield from check_command_line(root, accepted[0], 0, "")
    yield from check_command_line(root, folder / "SB-1-1-magic.sbrdf", 3, "[SB-1-1]")
    yield from check_command_line(root, folder / "SB-1-3-major-2.sbrdf", 4, "[SB-1-3]")


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    recording = sys.argv[1] == "--record"
    root = pathlib.Path(sys.argv[2] if recording else sys.argv[1])
    sys.path.insert(0, str(root / "specs" / "reference"))
    import sbrdf_reference as reference  # pylint: disable=import-outside-toplevel
    if recording:
        record(root, reference)
        return 0
    found = list(problems(root, reference, sys.argv[2]))
    for problem in found:
        print(problem)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
