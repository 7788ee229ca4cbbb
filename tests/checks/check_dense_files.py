#!/usr/bin/env python3
"""Dense tables as other programs read them: NumPy reads NPY and CSV, oiiotool and exrheader read EXR, and all of them see
what `sbrdf eval` says. And the other way round: arrays and samples that NumPy wrote are read.

usage: check_dense_files.py SBRDF
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy

GRID = "15:45:0,30,80:60"
SHAPE = (7, 8, 3, 6, 3)


def run(*arguments, text=None):
    done = subprocess.run([str(a) for a in arguments], input=text, capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.stderr)
    return done.stdout


def evaluated(program, name, angles):
    lines = "theta_i,phi_i,theta_v,phi_v\n" + "".join(",".join(f"{a!r}" for a in row) + "\n" for row in angles.tolist())
    rows = run(program, "eval", name, text=lines).strip().split("\n")[1:]
    return numpy.array([[float(field) for field in row.split(",")[4:]] for row in rows])


def check_npy_and_csv(program, folder):
    run(program, "convert", "kurt:fabric112", folder / "a.npy", "--grid", GRID)
    array = numpy.load(folder / "a.npy", allow_pickle=False)
    assert array.shape == SHAPE and array.dtype == numpy.dtype("<f4") and array.flags.c_contiguous
    head = json.loads((folder / "a.npy.json").read_text())
    nodes = [numpy.array(axis["nodes"]) for axis in head["axes"]]
    assert [axis["name"] for axis in head["axes"]] == ["theta_i", "phi_i", "theta_v", "phi_v"]
    angles = numpy.stack(numpy.meshgrid(*nodes, indexing="ij"), -1).reshape(-1, 4)
    values = evaluated(program, "kurt:fabric112", angles)
    assert numpy.allclose(array.reshape(-1, 3), values, rtol=1e-6, atol=0)
    run(program, "convert", folder / "a.npy", folder / "a.csv")
    table = numpy.loadtxt(folder / "a.csv", delimiter=",", skiprows=2)
    assert numpy.array_equal(table[:, :4], angles)
    assert numpy.array_equal(table[:, 4:].astype("f4"), array.reshape(-1, 3))
    return array


def plain_pixels(path, height, width):
    """R, G, B of an image of floats in scan lines without compression: the file ends with its lines, channels by name."""
    size = 8 + 3 * width * 4
    lines = numpy.frombuffer(path.read_bytes()[-height * size :], "<f4").reshape(height, size // 4)
    return lines[:, 2:].reshape(height, 3, width).transpose(0, 2, 1)[:, :, ::-1]


def check_exr(program, folder, array):
    run(program, "convert", folder / "a.npy", folder / "a.exr")
    run("oiiotool", folder / "a.exr", "-d", "float", "--compression", "none", "-o", folder / "plain.exr")
    pixels = plain_pixels(folder / "plain.exr", 56, 18)
    assert numpy.array_equal(pixels, array.reshape(56, 18, 3))
    header = run("exrheader", folder / "a.exr")
    assert '"sbrdf":"dense table"' in header and "(0 0) - (17 55)" in header, header
    # An image that another program wrote, of halves, without the attribute.
    run("oiiotool", folder / "a.exr", "--eraseattrib", ".*", "-d", "half", "--compression", "piz", "-o", folder / "b.exr")
    run(program, "convert", folder / "b.exr", folder / "b.npy", "--grid", GRID)
    halves = numpy.load(folder / "b.npy")
    assert halves.dtype == numpy.dtype("<f2"), halves.dtype
    assert numpy.array_equal(halves, numpy.minimum(array, 65504).astype("f2"))


def check_other_arrays(program, folder, array):
    numpy.save(folder / "fortran.npy", numpy.asfortranarray(array.astype("<f8")))
    run(program, "convert", folder / "fortran.npy", folder / "c.npy", "--grid", GRID, "--type", "float32")
    assert numpy.array_equal(numpy.load(folder / "c.npy"), array)
    holes = numpy.minimum(array[..., 1], 1000).astype("<f2")
    holes[1, 2] = numpy.nan
    numpy.save(folder / "one.npy", holes)
    run(program, "convert", folder / "one.npy", folder / "d.csv", "--grid", GRID)
    table = numpy.loadtxt(folder / "d.csv", delimiter=",", skiprows=2)
    assert numpy.array_equal(table[:, 4].astype("f4").reshape(holes.shape), holes.astype("f4"), equal_nan=True)


def check_samples(program, folder):
    random = numpy.random.default_rng(1)
    angles = random.uniform(0, 1, (800, 4)) * [75, 0, 75, 360]
    samples = numpy.hstack([angles, evaluated(program, "kurt:wood01", angles)])
    numpy.savetxt(folder / "samples.txt", samples, header="theta_i phi_i theta_v phi_v R G B")
    numpy.savetxt(folder / "samples.csv", samples, delimiter=";", header="theta_i;phi_i;theta_v;phi_v;R;G;B", comments="")
    for name in ["samples.txt", "samples.csv"]:
        fitted = evaluated(program, folder / name, angles[::7])
        reference = samples[::7, 4:]
        error = abs(fitted - reference).sum() / reference.sum()
        assert error < 0.03, error


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        array = check_npy_and_csv(program, folder)
        check_exr(program, folder, array)
        check_other_arrays(program, folder, array)
        check_samples(program, folder)
    print("NumPy, oiiotool and exrheader see the values that sbrdf gives")
    return 0


if __name__ == "__main__":
    sys.exit(main())
