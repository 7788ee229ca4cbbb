#!/usr/bin/env python3
"""Reads Zemax tabular BSDF files on its own, with numpy, and compares what the program says at their nodes, between them,
and of a measured file where there is one.

usage: check_zemax.py PROGRAM [MEASURED.bsdf]
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np


def read(path):
    """Lists of angles, and values[channel, rotation, incidence, azimuth, radial]."""
    lines = [line for line in path.read_text().splitlines() if not line.lstrip().startswith("#")]
    words = " ".join(lines).split()
    lists = {}
    for name in ("SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial"):
        at = words.index(name)
        lists[name] = np.array(words[at + 2 : at + 2 + int(words[at + 1])], float)
    rotation, incidence, azimuth, radial = shape = [len(angles) for angles in lists.values()]
    channels, tis = [], []
    for begin in (k for k, word in enumerate(words) if word == "DataBegin"):
        rows = np.array(words[begin + 1 : words.index("DataEnd", begin)])
        rows = rows.reshape(rotation * incidence, azimuth * radial + 2)
        assert (rows[:, 0] == "TIS").all()
        tis.append(rows[:, 1].astype(float).reshape(rotation, incidence))
        channels.append(rows[:, 2:].astype(float).reshape(shape))
    return list(lists.values()), np.array(channels), np.array(tis)


def directions(rotation, incidence, azimuth, radial):
    """theta_i, phi_i, theta_v, phi_v [degrees]: a cap around +z is tilted to the mirror direction of a light in the
    half plane of +x, and both are turned to the light's azimuth."""
    t, a, r = np.radians(incidence), np.radians(azimuth), np.radians(radial)
    x, y, z = np.sin(r) * np.cos(a), np.sin(r) * np.sin(a), np.cos(r)
    x, z = np.cos(t) * x - np.sin(t) * z, np.sin(t) * x + np.cos(t) * z
    theta_v = np.degrees(np.arctan2(np.hypot(x, y), z))
    return np.stack(np.broadcast_arrays(incidence, rotation, theta_v, rotation + np.degrees(np.arctan2(y, x))), axis=-1)


def evaluate(program, path, angles):
    rows = "".join(",".join(map(repr, row)) + "\n" for row in angles.tolist())
    done = subprocess.run([program, "eval", path], input="theta_i,phi_i,theta_v,phi_v\n" + rows, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    return np.array([line.split(",")[4:] for line in done.stdout.splitlines()[1:]], float)


def info(program, path):
    return json.loads(subprocess.run([program, "info", path, "--json"], capture_output=True, text=True, check=True).stdout)


def check_nodes(program, path):
    """At each node above the horizon with a value: it. How many there were, and how many zeros."""
    lists, channels, _ = read(path)
    values = channels[0]
    grid = np.meshgrid(*lists, indexing="ij")
    angles = directions(*grid)
    seen = angles[..., 2] < 90 - 1e-6
    seen &= (grid[3] > 0) | (grid[2] == 0)  # one direction is enough where all azimuths are one
    seen &= (grid[0] < 360) & (grid[2] < 360)
    zeros = int((values[seen] == 0).sum())
    seen &= values != 0
    found = evaluate(program, path, angles[seen])[:, 0]
    error = np.abs(found - values[seen]) / np.abs(values[seen])
    assert error.max() <= 1e-5, (path, error.max())
    return int(seen.sum()), zeros


def integrals(lists, values, cosine):
    """Of f_r cos(theta_v) or of f_r, by the trapezium rule on a grid of a degree, linear in both angles between nodes."""
    _, incidences, azimuths, radials = lists
    fine_a, fine_r = np.arange(0.5, 360), np.arange(0.25, 180, 0.5)
    result = np.empty(values.shape[:2])
    for i, incidence in enumerate(incidences):
        a, r = np.meshgrid(np.radians(fine_a), np.radians(fine_r), indexing="ij")
        t = np.radians(incidence)
        cos_v = np.maximum(np.cos(r) * np.cos(t) + np.sin(r) * np.cos(a) * np.sin(t), 0)
        weight = (cos_v if cosine else cos_v > 0) * np.sin(r) * np.radians(1) * np.radians(0.5)
        for k in range(values.shape[0]):
            along = np.stack([np.interp(fine_r, radials, row) for row in values[k, i]])
            table = np.stack([np.interp(fine_a, azimuths, column) for column in along.T], axis=-1)
            result[k, i] = (table * weight).sum()
    return result


def check_measured(program, path):
    nodes, zeros = check_nodes(program, path)
    told = info(program, path)
    findings = {finding["what"]: finding["count"] for finding in told["findings"]}
    lists, (values,), (tis,) = read(path)
    above = directions(*np.meshgrid(*lists, indexing="ij"))[..., 2] <= 90 + 1e-6
    zero_nodes = int(((values == 0) & above)[:-1, :, :-1].sum())
    (seam,) = [(what, count) for what, count in findings.items() if what.startswith("values at SampleRotation 360")]
    difference = np.abs(values[-1] - values[0])
    assert f"by up to {difference.max():.4g} 1/sr" in seam[0] and seam[1] == (difference > 0).sum(), seam
    (unmeasured,) = [count for what, count in findings.items() if "exactly 0, taken as unmeasured" in what]
    assert unmeasured == zero_nodes, (unmeasured, zero_nodes)
    (different,) = [(what, count) for what, count in findings.items() if "from the TIS stated" in what]
    told = [float(number) for number in re.findall(r"([0-9.]+)(?: to| times)", different[0])]
    ratios = [integrals(lists, values, cosine) / tis for cosine in (True, False)]
    expected = [bound for ratio in ratios for bound in (ratio.min(), ratio.max())]
    assert np.allclose(told, expected, rtol=0.01), (told, expected)
    assert different[1] == (np.abs(ratios[0] - 1) > 0.05).sum(), different
    print(f"{path.name}: {nodes} values agree, {zeros} zeros above the horizon; integrals over TIS, with and without "
          f"cosine: {told}")


def closed_form(rotation, incidence, azimuth, radial):
    """Smooth in all directions: a lobe off the mirror direction, and a grain."""
    r, a, p = np.radians(radial), np.radians(azimuth), np.radians(rotation)
    lobe = np.exp(-0.5 * ((np.sin(r) * np.cos(a) - 0.1) ** 2 + 2 * (np.sin(r) * np.sin(a)) ** 2))
    return 0.05 + 0.3 * lobe + 0.02 * np.cos(2 * p + 0.4) + 0.04 * (np.asarray(incidence) / 90) ** 2


def write(path, lists, values, symmetry):
    names = ("SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial")
    with path.open("w", newline="") as file:
        file.write(f"# made by a closed form\r\nSource Measured\r\nSymmetry\t{symmetry}\r\nSPECTRALCONTENT Monochrome\r\n")
        file.write("ScatterType BRDF\r\n")
        for name, angles in zip(names, lists):
            file.write(f"{name}\t{len(angles)}\r\n" + "\t".join(f"{angle:g}" for angle in angles) + "\r\n")
        file.write("\r\nMonochrome\r\nDataBegin\r\n")
        for block in values.reshape(-1, *values.shape[2:]):
            file.write("TIS 0.5\r\n" + "".join("\t".join(f"{v:.8e}" for v in row) + "\r\n" for row in block))
        file.write("DataEnd\r\n")


def interpolated(lists, values, points):
    """Linear along each axis; azimuths close after a turn."""
    result = np.zeros(len(points))
    weights, corners = [], []
    for axis, nodes in enumerate(lists):
        if axis in (0, 2):
            nodes = np.append(nodes, nodes[0] + 360)
        low = np.clip(np.searchsorted(nodes, points[:, axis], side="right") - 1, 0, len(nodes) - 2)
        weight = (points[:, axis] - nodes[low]) / (nodes[low + 1] - nodes[low])
        count = values.shape[axis]
        weights.append((1 - weight, weight))
        corners.append((low % count, (low + 1) % count))
    for corner in np.ndindex(2, 2, 2, 2):
        share = np.prod([weights[axis][side] for axis, side in enumerate(corner)], axis=0)
        result += share * values[tuple(corners[axis][side] for axis, side in enumerate(corner))]
    return result


def check_closed_form(program, folder):
    path = folder / "closed.bsdf"
    lists = [np.arange(0, 360, 30), np.array([0, 15, 30, 40, 65, 85]), np.arange(0, 360, 15),
             np.array([0, 5, 10, 20, 30, 45, 60, 80, 100, 120, 150, 180])]
    values = closed_form(*np.meshgrid(*lists, indexing="ij"))
    write(path, lists, values, "Asymmetrical4D")
    nodes, zeros = check_nodes(program, path)
    assert zeros == 0 and nodes > 10000, (nodes, zeros)
    random = np.random.default_rng(1)
    points = random.uniform([0, 0, 0, 0], [360, 85, 360, 175], (20000, 4))
    angles = directions(*points.T)
    above = angles[:, 2] < 89.9
    found = evaluate(program, path, angles[above])[:, 0]
    linear = interpolated(lists, values, points[above])
    assert np.abs(found / linear - 1).max() < 1e-5, np.abs(found / linear - 1).max()
    error = np.abs(found / closed_form(*points[above].T) - 1)
    assert error.max() < 0.05 and error.mean() < 0.01, (error.max(), error.mean())
    print(f"closed form: {nodes} nodes; between them off by {100 * error.mean():.2f} %, at most {100 * error.max():.1f} %")


def check_mirrored(program, folder):
    path = folder / "plane.bsdf"
    lists = [np.array([0.0]), np.array([10, 40, 70]), np.arange(0, 181, 20), np.array([0, 10, 30, 60, 90, 130, 180])]
    values = closed_form(*np.meshgrid(*lists, indexing="ij"))
    write(path, lists, values, "planesymmetrical")
    check_nodes(program, path)
    grid = np.meshgrid(*lists, indexing="ij")
    angles = directions(123.0, grid[1], -grid[2], grid[3])  # the other half, whatever the azimuth of the light
    seen = (angles[..., 2] < 89.9) & (grid[3] > 0)
    found = evaluate(program, path, angles[seen])[:, 0]
    assert np.abs(found / values[seen] - 1).max() < 1e-5
    assert info(program, path)["isotropic"]


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 1
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_closed_form(program, folder)
        check_mirrored(program, folder)
    if len(sys.argv) == 3:
        measured = pathlib.Path(sys.argv[2])
        if measured.exists():
            check_measured(program, measured)
        else:
            print("no measured file")
    return 0


if __name__ == "__main__":
    sys.exit(main())
