#!/usr/bin/env python3
"""Converts materials into other formats and measures what comes back: bytes and errors, as a table in Markdown.

usage: tabulate_round_trips.py SBRDF FOLDER [MATERIAL ...]

FOLDER takes the files that are made. MATERIAL is a file or kurt:NAME; unless given, kurt:fabric112 and kurt:wood01.
Errors are those between the nodes of any grid (compare --directions highlight), against the material itself, or,
where the format is reciprocal by construction, against the mean of f(i,v) and f(v,i).
"""
import json
import pathlib
import subprocess
import sys

# Extension, options of writing, options of reading, whether the format is reciprocal, what it is called.
WAYS = [
    (".binary", [], [], True, "MERL 90 x 90 x 180"),
    (".dat", [], [], False, "Ngan"),
    (".bin", [], [], False, "UTIA"),
    (".bsdf", [], [], False, "RGL"),
    (".h5", [], [], False, "HDF5, default grid"),
    (".h5", ["--grid", "merl"], [], True, "HDF5, grid of MERL"),
    (".npy", [], [], False, "NPY, default grid"),
    (".exr", ["--grid", "5:5:5:5"], [], False, "EXR, 5 degrees"),
    (".exr", ["--grid", "5:5:5:5", "--type", "float16"], [], False, "EXR, 5 degrees, half"),
    (".csv", ["--grid", "10:10:10:10"], [], False, "CSV, 10 degrees"),
    (".sbrdf", ["--samples", "3000"], [], True, "sliced, 3,000 samples"),
]


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode == 0 else done.stderr.strip()


def figures(program, reference, test, reciprocal):
    options = ["--symmetrise"] if reciprocal else []
    result = run(program, "compare", reference, test, "--directions", "highlight", "--json", *options)
    if isinstance(result, str):
        return result
    return f"{result['mre_percent']:.3g} | {result['rel_l1_percent']:.3g}"


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    materials = sys.argv[3:] or ["kurt:fabric112", "kurt:wood01"]
    folder.mkdir(parents=True, exist_ok=True)
    print("| material | format | bytes | MRE, % | relative L1, % |\n|---|---|---|---|---|")
    for material in materials:
        name = pathlib.Path(material.replace(":", "_")).stem
        for number, (extension, writing, _, reciprocal, label) in enumerate(WAYS):
            out = folder / f"{name}_{number}{extension}"
            done = run(program, "convert", material, out, "--json", *writing)
            if isinstance(done, str):
                print(f"| {name} | {label} | {done} | | |", flush=True)
                continue
            print(f"| {name} | {label} | {done['out']['bytes']:,} | {figures(program, material, out, reciprocal)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
