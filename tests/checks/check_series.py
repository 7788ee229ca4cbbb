#!/usr/bin/env python3
"""Dense files (specs/sbrdf.md, section 14): the program and the reference decoder, which was written from the page, say
the same of every vector, and refuse the same files by the same rule.

usage: check_series.py SOURCE_DIR SBRDF
"""
import itertools
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import zlib

sys.dont_write_bytecode = True
RELATIVE, OF_LARGEST = 5e-5, 2e-6
RULE = re.compile(r"\[(S[BD]-[\d-]+)\]")
POLAR = (0, 1e-3, 0.5, 30, 60, 79.999, 80, 85, 90, 90.001)
AZIMUTHS = (0, 90, 180, 270, 45, 359.999, -30, 725)


def run(*command, given=""):
    return subprocess.run([*map(str, command)], input=given, capture_output=True, text=True, check=False)


def pairs_csv(seed):
    draw = random.Random(seed)
    rows = [draw.sample(list(itertools.product(POLAR, AZIMUTHS)), 2) for _ in range(60)]
    lines = [(*i, *v) for i, v in rows]
    lines += [(draw.uniform(0, 80), draw.uniform(0, 360), draw.uniform(0, 80), draw.uniform(0, 360)) for _ in range(140)]
    for _ in range(60):  # about highlights
        theta, phi = draw.uniform(0, 80), draw.uniform(0, 360)
        lines.append((theta, phi, abs(theta + draw.gauss(0, 0.5)), phi + 180 + draw.gauss(0, 0.5)))
    return "theta_i,phi_i,theta_v,phi_v\n" + "".join(",".join(map(str, line)) + "\n" for line in lines)


def values_of(text):
    return [[float(x) for x in line.split(",")[4:]] for line in text.split("\n")[1:] if line]


def differences(program, reference, file, pairs):
    by_program = run(program, "eval", file, given=pairs)
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as csv:
        csv.write(pairs)
        csv.flush()
        by_reference = run(sys.executable, reference, file, "--eval", csv.name)
    if by_program.returncode or by_reference.returncode:
        yield f"{file.name}: {by_program.stderr}{by_reference.stderr}"
        return
    ours, theirs = values_of(by_program.stdout), values_of(by_reference.stdout)
    if len(ours) != len(theirs) or not ours:
        yield f"{file.name}: {len(ours)} rows, not {len(theirs)}"
    largest = max(abs(v) for row in theirs for v in row)
    for k, (a, b) in enumerate(zip(ours, theirs)):
        if any(abs(x - y) > RELATIVE * abs(y) + OF_LARGEST * largest for x, y in zip(a, b)):
            yield f"{file.name}, pair {k}: {a}, by the reference {b}"


def sealed(index, minor=0, tail=b""):
    size, count = len(index), b""
    while size >= 128:
        count, size = count + bytes([size & 127 | 128]), size >> 7
    head = b"\x89SBF\x01" + bytes([minor]) + count + bytes([size]) + index
    return head + struct.pack("<I", zlib.crc32(head)) + tail


def broken_files(index):
    """By rule: of the isotropic vector in R, G, B with a theta_max of 80 degrees."""
    def with_byte(at, value):
        return sealed(index[:at] + bytes([value]) + index[at + 1:])

    yield "SB-2-3", with_byte(0, index[0] | 128)
    yield "SD-1", with_byte(1, index[1] | 2)
    yield "SD-1", with_byte(1, index[1] | 16)
    yield "SD-2", sealed(bytes([index[0], index[1] | 8]) + b"\x00" + index[2:])
    yield "SD-2", sealed(bytes([index[0], index[1] | 8]) + b"\xa9\x46" + index[2:])
    yield "SB-2-6", sealed(index[:2] + b"\x81\x20" + bytes(4097) + index[3:])
    yield "SD-3", with_byte(3, index[3] & 15)  # no fineness
    yield "SD-3", with_byte(3, index[3] & 240 | 3)  # components
    for axis in range(3):
        yield "SD-3", with_byte(4 + axis, 1)
        yield "SD-3", with_byte(4 + axis, 100)
    yield "SD-4", sealed(index[:9] + b"\xc3\x0c" + index[10 + (index[9] >= 128):])
    yield "SD-5", sealed(index + b"\0")
    yield "SB-2-1", sealed(index[:12])
    yield "SD-7", sealed(index, tail=b"\0")
    yield "SB-2-2", with_byte(0, index[0] & 240 | 12)


def refusals(program, reference, index, folder):
    rules = set()
    for number, (rule, content) in enumerate(broken_files(index)):
        rules.add(rule)
        path = folder / f"{number}.sbrdf"
        path.write_bytes(content)
        for who, done in (("program", run(program, "verify", path)), ("reference", run(sys.executable, reference, path))):
            found = RULE.search(done.stderr + done.stdout)
            if done.returncode not in (3, 4) or not found or found.group(1) != rule:
                yield f"file {number}: {who} says {done.returncode} {done.stderr.strip()!r} and not {rule}"
    missing = {f"SD-{k}" for k in (1, 2, 3, 4, 5, 7)} - rules
    if missing:
        yield f"no file breaks {missing}"


def main():
    root, program = map(pathlib.Path, sys.argv[1:])
    reference = root / "specs/reference/sbrdf_series.py"
    vectors = sorted((root / "tests/vectors/series").glob("*.sbrdf"))
    problems = [] if vectors else ["no vectors"]
    for seed, vector in enumerate(vectors):
        problems += differences(program, reference, vector, pairs_csv(seed))
    file = (root / "tests/vectors/series/isotropic.sbrdf").read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        problems += refusals(program, reference, file[7 if file[6] < 128 else 8:-4], pathlib.Path(folder))
        cut = pathlib.Path(folder) / "cut.sbrdf"
        for size in range(len(file)):
            cut.write_bytes(file[:size])
            if size % 9 == 0 and run(program, "verify", cut).returncode not in (3, 4):
                problems.append(f"cut after {size} bytes it is accepted")
    print(*problems, sep="\n", end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
