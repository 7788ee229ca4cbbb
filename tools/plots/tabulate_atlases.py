#!/usr/bin/env python3
"""Prints the tables of specs/results/atlases.md: bytes and errors of texture atlases, by texel format.

    tools/plots/tabulate_atlases.py SBRDF FOLDER [MAX_ERROR]
    tools/plots/tabulate_atlases.py SBRDF 10/36 [MAX_ERROR]

SBRDF is the program, FOLDER has the measured .bsdf files. Atlases of the ten built-in materials, sliced as in the paper
(8,911 samples, 14/36), and of those files (3,000 samples, searched); errors are those that `sbrdf atlas` reports, on
directions drawn densely around highlights. With 10/36 in place of the folder: the ten alone, 18,721 samples, in float32
and BC6H.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

KURT = ["Brushed alum", "Purple satin", "Red velvet", "Yellow satin", "fabric002", "fabric041", "fabric112", "fabric135",
        "fabric139", "wood01"]
PAPER = ["--values", "measured", "--precision", "0.1%", "--frame", "elevation"]
SAMPLES = {"14/36": "8911", "10/36": "18721"}
FORMATS = [("rgb32f", "exr"), ("rgba16f", "exr"), ("e5b9g9r9", "ktx2"), ("bc6h", "ktx2")]


def run(program, *arguments):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


def atlas(program, sliced, folder, texel, container, most):
    """The report of one atlas; texel_bytes are those of the texels alone, whatever the file packs."""
    out = str(Path(folder) / texel)
    return json.loads(run(program, "atlas", sliced, out, "--texel", texel, "--container", container, "--max-error", most,
                          "--json"))


def row(program, name, sliced, folder, formats, most):
    cells = [name, f"{Path(sliced).stat().st_size:,}"]
    for texel, container in formats:
        report = atlas(program, sliced, folder, texel, container, most)
        errors = report["errors"]["to_slices"]
        cells.append(f"{report['texel_bytes']:,}: {errors['mre_percent']:.2f} / {errors['rel_l1_percent']:.2f}"
                     + ("" if report["reached"] else " *"))
    return "| " + " | ".join(cells) + " |"


def tabulate_built_in(program, placement, folder, formats, most):
    sliced = str(Path(folder) / "material.sbrdf")
    for name in KURT:
        run(program, "convert", "kurt:" + name, sliced, "--placement", placement, "--samples", SAMPLES[placement], *PAPER)
        print(row(program, name, sliced, folder, formats, most), flush=True)


def main():
    program, measured = sys.argv[1], sys.argv[2]
    most = sys.argv[3] if len(sys.argv) > 3 else "1"
    dense = measured == "10/36"
    formats = [FORMATS[0], FORMATS[-1]] if dense else FORMATS
    print("| material | sliced file [bytes] | " + " | ".join(texel for texel, _ in formats) + " |")
    print("|---" * (2 + len(formats)) + "|")
    with tempfile.TemporaryDirectory() as folder:
        tabulate_built_in(program, measured if dense else "14/36", folder, formats, most)
        sliced = str(Path(folder) / "material.sbrdf")
        for file in [] if dense else sorted(Path(measured).glob("*.bsdf")):
            run(program, "convert", str(file), sliced, "--samples", "3000")
            print(row(program, file.stem.removesuffix("_rgb"), sliced, folder, formats, most), flush=True)


if __name__ == "__main__":
    main()
