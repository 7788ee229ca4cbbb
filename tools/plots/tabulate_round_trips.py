#!/usr/bin/env python3
"""Converts materials into other formats and measures what comes back: bytes and errors, as tables in Markdown.

usage: tabulate_round_trips.py SBRDF FOLDER [--formats NAME,...] [MATERIAL ...]
       tabulate_round_trips.py SBRDF FOLDER --chain NAME,... [MATERIAL ...]

FOLDER takes the files that are made. MATERIAL is a file or kurt:NAME; unless given, kurt:fabric112. NAME is that of a
row of WAYS below; without --formats all of them. A chain converts a material into the first format, that file into the
second, and so on, and compares each file with the one before it and with the material itself.

Errors are those between the nodes of any grid (compare --directions highlight) and on random pairs of the 2-degree
grid (compare --random 200000). Where a format is reciprocal by construction, they are against the mean of f(i,v) and
f(v,i).
"""
import argparse
import json
import pathlib
import subprocess
import sys

# Name: extension, options of writing, whether the format is reciprocal, what it is called.
WAYS = {
    "merl": (".binary", [], True, "MERL 90 x 90 x 180"),
    "ngan": (".dat", [], False, "Ngan"),
    "utia": (".bin", [], False, "UTIA, standard"),
    "utia-dense": (".bin", ["--utia-grid", "dense"], False, "UTIA, dense"),
    "rgl": (".bsdf", [], False, "RGL"),
    "hdf5": (".h5", [], False, "HDF5, default grid"),
    "hdf5-merl": (".h5", ["--grid", "merl"], True, "HDF5, grid of MERL"),
    "npy": (".npy", [], False, "NPY, default grid"),
    "exr": (".exr", ["--grid", "5:5:5:5"], False, "EXR, 5 degrees"),
    "exr-half": (".exr", ["--grid", "5:5:5:5", "--type", "float16"], False, "EXR, 5 degrees, half"),
    "csv": (".csv", ["--grid", "10:10:10:10"], False, "CSV, 10 degrees"),
    "sbrdf": (".sbrdf", ["--samples", "3000"], True, "sliced, 3,000 samples"),
}


class Failed(Exception):
    """A command that ended with an error, which is its text."""


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(done.stderr.strip().replace("|", "\\|"))
    return json.loads(done.stdout)


def figures(program, reference, test, reciprocal):
    """MRE and relative L1 [%] between nodes, then on the grid, as cells of a table."""
    cells = []
    for directions in (["--directions", "highlight"], ["--random", "200000"]):
        options = directions + (["--symmetrise"] if reciprocal else [])
        result = run(program, "compare", reference, test, *options)
        cells += [f"{result['mre_percent']:.3g}", f"{result['rel_l1_percent']:.3g}"]
    return " | ".join(cells)


def short(material):
    return pathlib.Path(str(material).replace("kurt:", "")).name.split(".")[0].removesuffix("_rgb")


def each_format(program, folder, materials, names):
    print("| material | format | bytes | between: MRE, % | L1, % | grid: MRE, % | L1, % |\n|---|---|---|---|---|---|---|")
    for material in materials:
        for name in names:
            extension, writing, reciprocal, label = WAYS[name]
            out = folder / f"{short(material)}_{name}{extension}"
            try:
                size = run(program, "convert", material, out, *writing)["out"]["bytes"]
                print(f"| {short(material)} | {label} | {size:,} | {figures(program, material, out, reciprocal)} |")
            except Failed as error:
                print(f"| {short(material)} | {label} | {error} | | | | |")
            sys.stdout.flush()


def along_chain(program, folder, materials, names):
    print("| material | step | bytes | against | between: MRE, % | L1, % | grid: MRE, % | L1, % |")
    print("|---|---|---|---|---|---|---|---|")
    for material in materials:
        steps = [(material, short(material))]
        reciprocal = False
        for number, name in enumerate(names):
            extension, writing, makes_reciprocal, label = WAYS[name]
            reciprocal = reciprocal or makes_reciprocal
            out = folder / f"{short(material)}_chain_{number}_{name}{extension}"
            size = run(program, "convert", steps[-1][0], out, *writing)["out"]["bytes"]
            for reference, called in dict.fromkeys([steps[0], steps[-1]]):
                against = figures(program, reference, out, reciprocal)
                print(f"| {short(material)} | {number + 1}: {label} | {size:,} | {called} | {against} |", flush=True)
            steps.append((out, label))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("materials", nargs="*", default=["kurt:fabric112"])
    parser.add_argument("--formats", default=",".join(WAYS))
    parser.add_argument("--chain")
    arguments = parser.parse_intermixed_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    work, names = (along_chain, arguments.chain) if arguments.chain else (each_format, arguments.formats)
    work(arguments.program, arguments.folder, arguments.materials, names.split(","))
    return 0


if __name__ == "__main__":
    sys.exit(main())
