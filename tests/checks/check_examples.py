#!/usr/bin/env python3
"""Runs the examples of tests/examples and compares what they print with what the program says.

usage: check_examples.py PROGRAM EVALUATE CONVERT LOAD_PART SAMPLE
"""
import math
import pathlib
import re
import subprocess
import sys
import tempfile


def run(*command, text=None, expect=0):
    done = subprocess.run([str(word) for word in command], input=text, capture_output=True, text=True)
    if done.returncode != expect:
        sys.exit(f"exit {done.returncode}, not {expect}: {' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def reflected(program, name):
    """The share of the light from 60 degrees that comes back, by the rule of midpoints."""
    rings, azimuths = 80, 160
    rows = ["theta_i,phi_i,theta_v,phi_v"]
    for a in range(rings):
        theta = math.degrees(math.asin(math.sqrt((a + 0.5) / rings)))  # cos theta d(theta) in even steps
        rows += [f"60,0,{theta},{360 * (b + 0.5) / azimuths}" for b in range(azimuths)]
    values = [line.split(",")[4:] for line in run(program, "eval", name, text="\n".join(rows)).splitlines()[1:]]
    return [math.pi * sum(map(float, channel)) / len(values) for channel in zip(*values)]


def main():
    if len(sys.argv) != 6:
        print(__doc__, file=sys.stderr)
        return 1
    program, evaluate, convert, load_part, sample = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        split = folder / "split.sbrdf"
        run(program, "convert", "kurt:fabric112", split, "--placement", "14/36", "--samples", "5000", "--chunks", "split")
        row = run(program, "eval", split, text="theta_i,phi_i,theta_v,phi_v\n30,0,45,180\n").splitlines()[1]
        expected = [float(value) for value in row.split(",")[4:]]

        values = [float(line) for line in run(evaluate, split).splitlines()]
        assert all(abs(a - b) <= 1e-5 * abs(b) for a, b in zip(values, expected, strict=True)), (values, expected)

        *values, read = run(load_part, split).splitlines()
        assert all(abs(float(a) - b) <= 1e-5 * abs(b) for a, b in zip(values, expected, strict=True)), (values, expected)
        part, whole = map(int, re.fullmatch(r"(\d+) of (\d+) bytes read", read).groups())
        assert whole == split.stat().st_size and part < whole / 2, read

        shares = [float(line) for line in run(sample, split).splitlines()]
        expected = reflected(program, split)
        assert all(abs(a - b) <= 0.01 * b for a, b in zip(shares, expected, strict=True)), (shares, expected)

        out = folder / "out.sbrdf"
        report = run(convert, "kurt:wood01", out, "200")
        assert f"{out.stat().st_size} bytes" in report and "200 samples" in report, report
        assert not list(folder.glob(".*")), "something was left behind"
        run(convert, "kurt:wood01", folder / "out.nothing", expect=3)
        run(evaluate, folder / "missing", expect=1)
    print("the examples say what the program says")
    return 0


if __name__ == "__main__":
    sys.exit(main())
