#!/usr/bin/env python3
"""Reads dense tables that sbrdf writes in HDF5 with h5py and h5dump, and has sbrdf read what h5py wrote.

usage: check_hdf5.py SBRDF
"""
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np


def run(*arguments, text=None):
    done = subprocess.run([str(a) for a in arguments], input=text, capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.stderr)
    return done.stdout


def evaluate(program, source, rows):
    text = "theta_i,phi_i,theta_v,phi_v\n" + "".join(",".join(repr(float(a)) for a in row) + "\n" for row in rows)
    lines = run(program, "eval", source, text=text).splitlines()[1:]
    return np.array([[float(v) for v in line.split(",")[4:]] for line in lines])


def check_written(program, folder):
    """Scales, attributes and the value at every node, beside what the source is there."""
    path = folder / "table.h5"
    run(program, "convert", "kurt:fabric112", path, "--grid", "0,20,80:90:40,75:0,10,200", "--type", "float64")
    with h5py.File(path) as file:
        assert file.attrs["sbrdf"] == b"dense table" and file.attrs["frame"] == b"angles"
        table = file["f_r"]
        assert table.shape == (3, 4, 2, 3, 3) and table.dtype == np.float64, table
        assert table.attrs["unit"] == b"1/sr" and table.attrs["quantity"] == b"f_r, without cosine"
        assert [d.label for d in table.dims] == ["theta_i", "phi_i", "theta_v", "phi_v", "channel"]
        nodes = [table.dims[k][0][...] for k in range(4)]
        assert all(table.dims[k][0].attrs["unit"] == b"degree" for k in range(4))
        assert list(nodes[0]) == [0, 20, 80] and list(nodes[1]) == [0, 90, 180, 270] and list(nodes[3]) == [0, 10, 200]
        assert [n.decode() for n in table.dims[4][0][...]] == ["R", "G", "B"]
        assert "remarks" in json.loads(file.attrs["report"])
        expected = evaluate(program, "kurt:fabric112", itertools.product(*nodes)).reshape(table.shape)
        assert np.allclose(table[...], expected, rtol=1e-6), np.abs(table[...] / expected - 1).max()
    dump = run("h5dump", "-d", "f_r", "-s", "0,0,0,0,0", "-c", "1,1,1,1,1", path)
    assert "DATA {" in dump and "DIMENSION_LIST" in dump


def check_samples(program, folder):
    """Uniform samples: directions and rows as their page says, beside what the source is there, and given back."""
    path = folder / "samples.h5"
    run(program, "convert", "kurt:fabric112", path, "--scheme", "4", "--interpolation", "rbf", "--rbf-kernel", "linear")
    with h5py.File(path) as file:
        attributes = {key: file.attrs[key] for key in ("sbrdf", "version", "scheme", "interpolation", "kernel")}
        assert attributes == {"sbrdf": b"uniform samples", "version": b"1", "scheme": b"4", "interpolation": b"rbf",
                              "kernel": b"linear"}, attributes
        thetas, counts, values = file["ring_theta"][...], file["ring_count"][...], file["f_r"][...]
        assert list(thetas) == [0, 20, 40, 60, 80] and list(counts) == [1, 6, 10, 12, 18]
        assert [name.decode() for name in file["channel"][...]] == ["R", "G", "B"] and values.shape == (1128, 3)
    directions = [(t, 360 * k / n) for t, n in zip(thetas, counts.astype(int)) for k in range(n)]
    pairs = [(*directions[b], *directions[a]) for a in range(len(directions)) for b in range(a + 1)]
    expected = evaluate(program, "kurt:fabric112", pairs)
    assert np.allclose(values, expected, rtol=1e-6), np.abs(values / expected - 1).max()
    assert np.allclose(evaluate(program, path, pairs), expected, rtol=1e-5, atol=1e-5)
    for field, damaged in (("ring_count", counts + 1), ("f_r", values[:-1]), ("ring_theta", thetas - 30)):
        with h5py.File(path, "a") as file:
            kept = file[field][...]
            del file[field]
            file[field] = damaged
        done = subprocess.run([program, "info", str(path)], capture_output=True, text=True)
        assert done.returncode == 3 and "samples.h5" in done.stderr, (field, done)
        with h5py.File(path, "a") as file:
            del file[field]
            file[field] = kept
    run(program, "info", path)


def check_foreign(program, folder):
    """A dataset without any attribute, big-endian and not chunked."""
    path = folder / "foreign.h5"
    theta, phi = np.arange(0, 91, 30), np.arange(0, 360, 90)
    a, b, c, d = np.meshgrid(theta, phi, theta, phi, indexing="ij")
    values = 0.1 + a / 90 + b / 3600 + c / 900 + d / 36000
    with h5py.File(path, "w") as file:
        file["some/table"] = values.astype(">f4")
    rows = list(itertools.product(theta, phi, theta, phi))
    done = subprocess.run([program, "info", str(path)], capture_output=True, text=True)
    assert done.returncode == 1 and "--grid" in done.stderr, done.stderr
    out = folder / "foreign_copy.h5"
    run(program, "convert", path, out, "--grid", "30:90:30:90")
    assert np.allclose(evaluate(program, out, rows)[:, 0], values.ravel(), rtol=1e-6)
    with h5py.File(out) as file:
        assert file["f_r"].shape == (4, 4, 4, 4, 1) and np.array_equal(file["f_r"][..., 0], values.astype("f4"))


def check_exact(program, folder):
    """Numbers survive whatever they are: negatives, holes, denormals, 1e12; with no difference in a second copy."""
    for name in ("float16", "float32", "float64"):
        first, second, third = (folder / f"{name}{k}.h5" for k in range(3))
        run(program, "convert", "kurt:fabric112", first, "--grid", "30:90:30:90", "--type", name)
        with h5py.File(first, "r+") as file:
            table = file["f_r"]
            table[0, 0, 0, 0] = [-1.5, 2, 3]
            table[1, 0, 0, 0] = np.nan
            table[2, 0, 0, 0] = [1e4 if name == "float16" else 1e12, 6e-8 if name == "float16" else 1e-40, 1]
        run(program, "convert", first, second)
        assert first.read_bytes() == second.read_bytes()
        run(program, "convert", first, third, "--deflate", "0")
        with h5py.File(first) as one, h5py.File(third) as other:
            assert one["f_r"].dtype == other["f_r"].dtype
            a, b = one["f_r"][...], other["f_r"][...]
            assert np.array_equal(a, b, equal_nan=True), (name, [(a[k], b[k]) for k in zip(*np.where(a != b))][:5])


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        for check in (check_written, check_samples, check_foreign, check_exact):
            check(program, pathlib.Path(name))
            print(check.__doc__.splitlines()[0])
    return 0


if __name__ == "__main__":
    sys.exit(main())
