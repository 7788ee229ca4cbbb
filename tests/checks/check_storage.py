#!/usr/bin/env python3
"""`sbrdf reproduce storage`: the paper's Table 5 from the files that it writes, read by others. Cube maps in KTX2 go
through a reader that is written here from the specification; images through exrheader; what cube maps say is checked by
interpolating a sampled direction.

usage: check_storage.py SBRDF

Without exrheader or numpy nothing is checked, and the exit code is 77.
"""
import json
import math
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError as missing:
    print(missing)
    sys.exit(77)

PAPER = {("proposed", 8911): 3.3, ("barycentric", 8911): 3.5, ("proposed", 18721): 5.1, ("barycentric", 18721): 3.6}
MEGABYTE = 2**20


def run(*command):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (command, done.stderr)
    return done.stdout


def texels_of_image(path):
    """Pixels times bytes of R, G and B."""
    header = run("exrheader", path)
    left, bottom, right, top = map(int, re.search(r"dataWindow.*?\((-?\d+) (-?\d+)\) - \((-?\d+) (-?\d+)\)", header).groups())
    kinds = re.findall(r"^\s+[RGB], (.*?)-bit", header, re.MULTILINE)
    assert kinds == ["32"] * 3 or [k.split()[0] for k in kinds] == ["32"] * 3, header
    return (right - left + 1) * (top - bottom + 1) * 12


def cube_map(path):
    """Faces, rows, columns, 3 numbers."""
    data = path.read_bytes()
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n", path
    vk_format, type_size, width, height, depth, layers, faces, levels, packing = struct.unpack_from("<9I", data, 12)
    offset, size, unpacked = struct.unpack_from("<3Q", data, 80)
    kind, step = {23: ("<u1", 1), 90: ("<f2", 2)}[vk_format]
    assert (type_size, width, height, depth, layers, faces, levels, packing) == (step, 256, 256, 0, 0, 6, 1, 0), path
    assert size == unpacked == 6 * 256 * 256 * 3 * step and offset + size == len(data) and offset % 12 == 0, path
    begin, length = struct.unpack_from("<2I", data, 48)
    total, _, version, block, model = struct.unpack_from("<IIHHB", data, begin)
    assert (total, version, block, model) == (length, 2, 24 + 3 * 16, 1), path
    for c in range(3):
        bit, bits, channel, _, low, high = struct.unpack_from("<HBBIII", data, begin + 28 + 16 * c)
        assert (bit, bits + 1) == (8 * step * c, 8 * step), path
        assert (channel, low, high) == ((c, 0, 255) if step == 1 else (c | 0xC0, 0xBF800000, 0x3F800000)), path
    return np.frombuffer(data[offset:], kind).reshape(6, 256, 256, 3)


def check_look_up(vertices, weights, count):
    up = slice(None), slice(None)
    shown = weights[4].astype(float)
    assert np.all(shown >= 0) and np.all(np.abs(shown.sum(axis=2) - 1) < 2e-3)
    assert vertices.max() == count - 1, vertices.max()
    # The normal is direction 0 of every scheme, in the middle of the face +z.
    middle = vertices[4][127:129, 127:129], weights[4][127:129, 127:129]
    assert np.all(middle[0] == 0) and np.all(middle[1][..., 0] == 1), middle
    assert np.all(weights[5][up].astype(float).sum(axis=2)[64:192, 64:192] == 0)  # below the horizon


def main():
    if shutil.which("exrheader") is None:
        print("exrheader is not installed")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "textures"
        rows = json.loads(run(sys.argv[1], "reproduce", "storage", "--material", "fabric112", "--out", out, "--json"))
        for row in rows:
            sizes = 0
            for file in row["files"]:
                path = out / file["name"]
                assert path.stat().st_size == file["bytes"], path
                if path.suffix == ".exr":
                    sizes += texels_of_image(path)
                elif row["method"] == "barycentric":
                    sizes += cube_map(path).nbytes
            key = row["method"], row["samples"]
            if key not in PAPER:
                assert row["texel_bytes"] < 500_000 and row["rel_l1_percent"] < 3, row
                continue
            if row["method"] == "barycentric":
                count = round((math.isqrt(8 * row["samples"] + 1) - 1) / 2)
                check_look_up(cube_map(out / f"barycentric_{row['samples']}_vertices.ktx2"),
                              cube_map(out / f"barycentric_{row['samples']}_weights.ktx2"), count)
                assert 0 <= sizes - row["texel_bytes"] < 128 * 12, (sizes, row)  # the last row of the samples
            else:
                assert sizes == row["texel_bytes"], (sizes, row)
            assert row["formula_bytes"] == row["texel_bytes"], row
            assert round(row["texel_bytes"] / MEGABYTE, 1) == PAPER[key] == row["paper_megabytes"], row
            assert row["mre_percent"] < 10, row
        assert {(row["method"], row["samples"]) for row in rows} >= PAPER.keys(), rows
    return 0


if __name__ == "__main__":
    sys.exit(main())
