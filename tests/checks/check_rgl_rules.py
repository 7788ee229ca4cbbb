#!/usr/bin/env python3
"""RGL material files obey the rules that the programs reading them rely on, can be drawn from, and say what is evaluated.

usage: check_rgl_rules.py SOURCE_DIR SBRDF [FILE.bsdf ...]    files that the program writes here, and those named
       check_rgl_rules.py --self-test

Written from the rules of specs/rgl.md (sections 1 to 4) and of the published readers, not from the writer. Of each file:
fields, types, shapes, alignment; axes that rise; positive integrals. Directions drawn as renderers draw them (luminance,
then vndf, then reflection at the half direction) have the density that is worked out for them: a chi-square test at
three incidences, and an integral of one. Values worked out here agree with `sbrdf eval`.
"""
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np

sys.dont_write_bytecode = True
MAGIC = b"tensor_file\0\x01\x00"
TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8", 9: "<f2", 10: "<f4", 11: "<f8"}
# Source, options: one of each kind.
MADE = (
    ("kurt:wood01", "--rgl-theta 6 --rgl-phi 9 --rgl-size 12 --rgl-warp-size 32"),
    ("kurt:Purple satin", "--rgl-theta 5 --rgl-phi 13 --rgl-size 16 --rgl-warp-size 48"),
    ("small.bsdf", "--rgl-theta 9 --rgl-size 20"),
    ("small.bsdf", "--rgl-size 16"),
)


class Broken(Exception):
    """A rule that does not hold."""


def require(holds, what):
    if not holds:
        raise Broken(what)


# ---- The container and its rules -------------------------------------------------------------------------------------


def parse(data):
    require(data[:14] == MAGIC, "magic and version 1.0")
    (count,) = struct.unpack_from("<I", data, 14)
    at, fields = 18, {}
    for _ in range(count):
        (size,) = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + size].decode()
        at += 2 + size
        axes, kind, offset = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{axes}Q", data, at + 11)
        at += 11 + 8 * axes
        elements = math.prod(shape)
        require(offset % 8 == 0, f"{name} begins at a multiple of 8")
        require(offset + elements * np.dtype(TYPES[kind]).itemsize <= len(data), f"{name} lies within the file")
        require(name not in fields, f"{name} stands once")
        fields[name] = np.frombuffer(data, TYPES[kind], elements, offset).reshape(shape)
    require(all(f.size == 0 or at <= len(data) for f in fields.values()), "the header is whole")
    return fields


def check_fields(f):
    for name, dimensions in (("theta_i", 1), ("phi_i", 1), ("ndf", 2), ("sigma", 2), ("vndf", 4), ("luminance", 4)):
        require(name in f, f"{name} is there")
        require(f[name].dtype == np.dtype("<f4") and f[name].ndim == dimensions, f"{name} is f32 and {dimensions}-D")
        require(np.isfinite(f[name]).all(), f"{name} is finite")
    for name in ("description", "jacobian"):
        require(name in f and f[name].dtype == np.dtype("u1") and f[name].ndim == 1, f"{name} is u8 and 1-D")
    require(f["jacobian"].shape == (1,) and f["jacobian"][0] == 1, "jacobian is 1")
    colours = "rgb" if "rgb" in f else "spectra"
    require(colours in f and f[colours].dtype == np.dtype("<f4") and f[colours].ndim == 5, "rgb or spectra, f32, 5-D")
    p, t = f["phi_i"].size, f["theta_i"].size
    n = f["luminance"].shape[2]
    channels = 3 if colours == "rgb" else f["wavelengths"].size
    require(f["vndf"].shape[:2] == (p, t), "vndf has a slice for each incidence")
    require(f["luminance"].shape == (p, t, n, n), "luminance is square, with a slice for each incidence")
    require(f[colours].shape == (p, t, channels, n, n), "colours have the nodes of luminance")
    require(np.isfinite(f[colours]).all() and f[colours].max() > 0, "colours are finite, some of them positive")
    for name in ("ndf", "sigma", "vndf", "luminance"):
        require(min(f[name].shape[-2:]) >= 2, f"{name} has 2 x 2 nodes or more")
    return colours


def check_rules(data):
    """The fields; Broken says which rule does not hold."""
    f = parse(data)
    colours = check_fields(f)
    theta, phi = f["theta_i"].astype(float), f["phi_i"].astype(float)
    require((np.diff(theta) > 0).all() and theta[0] >= 0 and theta[-1] <= math.pi / 2 + 1e-5, "theta_i rises to pi/2")
    require((np.diff(phi) > 0).all(), "phi_i rises")
    if phi.size > 2:
        require(abs(phi[0] + math.pi) < 1e-5 and abs(phi[-1] - math.pi) < 1e-5, "phi_i is the full turn from -pi to pi")
    require((f["sigma"] > 0).all() and (f["ndf"] >= 0).all() and f["ndf"].max() > 0, "sigma and ndf are positive")
    for name in ("vndf", "luminance"):
        require((f[name] >= 0).all(), f"{name} is not negative")
        inner = f[name].astype(float)
        masses = (inner[..., 1:, 1:] + inner[..., :-1, 1:] + inner[..., 1:, :-1] + inner[..., :-1, :-1]).sum((2, 3))
        require((masses > 0).all(), f"every slice of {name} has a positive integral")
    return f, colours


# ---- Evaluation and drawing, sections 3 and 4 ------------------------------------------------------------------------


def place(u, count):
    k = np.clip((u * (count - 1)).astype(int), 0, count - 2)
    return k, u * (count - 1) - k


def bilinear(table, x, y):
    (j, v), (i, u) = place(y, table.shape[-2]), place(x, table.shape[-1])
    return ((1 - v) * ((1 - u) * table[..., j, i] + u * table[..., j, i + 1])
            + v * ((1 - u) * table[..., j + 1, i] + u * table[..., j + 1, i + 1]))


class Density:
    """A bilinear density over the square, of one incidence."""

    def __init__(self, nodes):
        self.nodes = nodes
        self.along = self.cumulate(nodes)
        self.rows = self.cumulate(self.along[:, -1])

    @staticmethod
    def cumulate(values):
        sums = np.cumsum((values[..., 1:] + values[..., :-1]) / 2, axis=-1)
        return np.concatenate([np.zeros_like(sums[..., :1]), sums], axis=-1)

    @staticmethod
    def part(t, a, b):
        return t * (a + t * (b - a) / 2)

    @staticmethod
    def solve(area, a, b):
        divisor = a + np.sqrt(np.maximum(a * a + 2 * (b - a) * area, 0))
        return np.clip(np.where(divisor > 0, 2 * area / np.where(divisor > 0, divisor, 1), 0), 0, 1)

    def invert(self, x, y):
        (j, v), (i, u) = place(y, self.nodes.shape[0]), place(x, self.nodes.shape[1])
        mass = self.along[:, -1]
        whole = (1 - v) * mass[j] + v * mass[j + 1]
        before = [self.along[k, i] + self.part(u, self.nodes[k, i], self.nodes[k, i + 1]) for k in (j, j + 1)]
        below = self.rows[j] + self.part(v, mass[j], mass[j + 1])
        return ((1 - v) * before[0] + v * before[1]) / np.where(whole > 0, whole, 1), below / self.rows[-1]

    def warp(self, x, y):
        mass = self.along[:, -1]
        target = y * self.rows[-1]
        j = np.clip(np.searchsorted(self.rows, target, side="right") - 1, 0, mass.size - 2)
        v = self.solve(target - self.rows[j], mass[j], mass[j + 1])
        nodes = (1 - v)[:, None] * self.nodes[j] + v[:, None] * self.nodes[j + 1]
        along = self.cumulate(nodes)
        target = x * along[:, -1]
        i = np.clip((along <= target[:, None]).sum(1) - 1, 0, nodes.shape[1] - 2)
        row = np.arange(i.size)
        u = self.solve(target - along[row, i], nodes[row, i], nodes[row, i + 1])
        return (i + u) / (nodes.shape[1] - 1), (j + v) / (mass.size - 1)

    def at(self, x, y):
        cells = (self.nodes.shape[0] - 1) * (self.nodes.shape[1] - 1)
        return bilinear(self.nodes, x, y) * cells / self.rows[-1]


def normalised(slices):
    d = slices.astype(float)
    masses = (d[..., 1:, 1:] + d[..., :-1, 1:] + d[..., 1:, :-1] + d[..., :-1, :-1]).sum((2, 3)) / 4
    return d / masses[..., None, None]


class Material:
    def __init__(self, fields, colours):
        self.f = {name: values.astype(float) for name, values in fields.items()}
        self.colours = self.f[colours]
        self.isotropic = self.f["phi_i"].size <= 2
        self.vndf, self.luminance = normalised(fields["vndf"]), normalised(fields["luminance"])

    @staticmethod
    def bracket(nodes, at):
        if nodes.size == 1:
            return ((0, 1.0),)
        k = int(np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2))
        t = float(np.clip((at - nodes[k]) / (nodes[k + 1] - nodes[k]), 0, 1))
        return ((k, 1 - t), (k + 1, t))

    def mixed(self, slices, theta_i, phi_i):
        return sum(wp * wt * slices[p, t] for p, wp in self.bracket(self.f["phi_i"], phi_i)
                   for t, wt in self.bracket(self.f["theta_i"], theta_i))

    def incidence(self, theta_i, phi_i):
        return Incidence(self, theta_i, 0.0 if self.isotropic else math.remainder(phi_i, 2 * math.pi))


class Incidence:
    """All that is known once the light is: azimuths of isotropic materials are relative to it."""

    def __init__(self, material, theta_i, phi_i):
        self.i = np.array([math.sin(theta_i) * math.cos(phi_i), math.sin(theta_i) * math.sin(phi_i), math.cos(theta_i)])
        self.vndf = Density(material.mixed(material.vndf, theta_i, phi_i))
        self.luminance = Density(material.mixed(material.luminance, theta_i, phi_i))
        self.colours = material.mixed(material.colours, theta_i, phi_i)
        self.ndf = material.f["ndf"]
        x, y = np.array([math.sqrt(theta_i * 2 / math.pi)]), np.array([0.5 if material.isotropic else self.turn(phi_i)])
        self.sigma = float(bilinear(material.f["sigma"], x, y)[0])

    @staticmethod
    def turn(phi):
        return phi / (2 * math.pi) + 0.5 - np.floor(phi / (2 * math.pi) + 0.5)

    def half(self, v):
        m = v + self.i
        m /= np.linalg.norm(m, axis=1)[:, None]
        theta = np.arctan2(np.hypot(m[:, 0], m[:, 1]), m[:, 2])
        return m, np.sqrt(theta * 2 / math.pi), self.turn(np.arctan2(m[:, 1], m[:, 0]))

    def f_r_cos(self, v):
        _, x, y = self.half(v)
        sx, sy = self.vndf.invert(x, y)
        scale = bilinear(self.ndf, x, y) / (4 * self.sigma)
        return (bilinear(self.colours, np.clip(sx, 0, 1), np.clip(sy, 0, 1)) * scale).T

    @staticmethod
    def jacobian(i_m, x):
        return 8 * math.pi ** 2 * x * np.sin(x * x * math.pi / 2) * i_m

    def pdf(self, v):
        m, x, y = self.half(v)
        sx, sy = self.vndf.invert(x, y)
        return (self.luminance.at(np.clip(sx, 0, 1), np.clip(sy, 0, 1)) * self.vndf.at(x, y)
                / np.maximum(self.jacobian(m @ self.i, x), 1e-12))

    def draw(self, count, random):
        x, y = self.vndf.warp(*self.luminance.warp(random.random(count), random.random(count)))
        theta, phi = x * x * math.pi / 2, (2 * y - 1) * math.pi
        m = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
        return 2 * (m @ self.i)[:, None] * m - self.i


def expected_shares(incidence, cells, fine):
    """Of the upper hemisphere, in cells of equal solid angle: along z, and along the azimuth."""
    k = (np.arange(cells * fine) + 0.5) / (cells * fine)
    z, phi = (g.ravel() for g in np.meshgrid(k, k))
    across = np.sqrt(1 - z ** 2)
    v = np.stack([across * np.cos(2 * math.pi * phi), across * np.sin(2 * math.pi * phi), z], axis=1)
    cell = np.minimum((z * cells).astype(int), cells - 1) * cells + (phi * cells).astype(int)
    return np.bincount(cell, incidence.pdf(v) * 2 * math.pi / z.size, cells * cells)


def check_drawing(material, theta_i, phi_i, count=40000, cells=16):
    """Directions drawn, against the integral of their density over cells of equal solid angle of the whole sphere."""
    random = np.random.default_rng(1)
    incidence = material.incidence(theta_i, phi_i)
    x, y = (np.arange(600) + 0.5) / 600, (np.arange(600) + 0.5) / 600
    gx, gy = (g.ravel() for g in np.meshgrid(x, y))
    for density, name in ((incidence.vndf, "vndf"), (incidence.luminance, "luminance")):
        require(abs(density.at(gx, gy).mean() - 1) < 1e-3, f"{name} integrates to 1")
    v = incidence.draw(count, random)
    expected = expected_shares(incidence, cells, 40) * count
    coarser = expected_shares(incidence, cells, 29) * count
    above = v[v[:, 2] > 0]
    z, phi = above[:, 2], np.arctan2(above[:, 1], above[:, 0]) / (2 * math.pi) % 1
    found = np.bincount(np.minimum((z * cells).astype(int), cells - 1) * cells
                        + np.minimum((phi * cells).astype(int), cells - 1), minlength=cells * cells)
    # Where the lobe is narrower than parts of cells, their sum is no integral.
    keep = (expected > 20) & (np.abs(expected - coarser) < 0.02 * expected)
    difference = (found - expected)[keep] ** 2 / (expected[keep] + (0.03 * expected[keep]) ** 2)
    require(keep.sum() > 3, "enough cells to tell")
    limit = keep.sum() + 5 * math.sqrt(2 * keep.sum())
    require(difference.sum() < limit, f"directions are drawn as their density says: {difference.sum():.0f} > {limit:.0f}")
    return difference.sum() / keep.sum()


def check_values(program, path, material, relative=2e-4):
    random = np.random.default_rng(2)
    angles = np.stack([random.uniform(0, 85, 80), random.uniform(0, 360, 80), random.uniform(0, 85, 80),
                       random.uniform(0, 360, 80)], axis=1).round(3)
    rows = "theta_i,phi_i,theta_v,phi_v\n" + "\n".join(",".join(map(str, row)) for row in angles) + "\n"
    done = subprocess.run([program, "eval", str(path)], input=rows, capture_output=True, text=True, check=True)
    found = np.array([[float(word) for word in line.split(",")[4:]] for line in done.stdout.split("\n")[1:] if line])
    for row, values in zip(np.radians(angles), found):
        azimuth = row[3] - (row[1] if material.isotropic else 0)
        v = np.array([[math.sin(row[2]) * math.cos(azimuth), math.sin(row[2]) * math.sin(azimuth), math.cos(row[2])]])
        expected = material.incidence(row[0], row[1]).f_r_cos(v)[0] / math.cos(row[2])
        error = np.abs(values - expected) / (np.abs(expected).max() + 1e-9)
        require(error.max() < relative, f"{path}: eval says {values}, the file {expected} at {np.degrees(row)}")


def check_file(program, path):
    fields, colours = check_rules(pathlib.Path(path).read_bytes())
    material = Material(fields, colours)
    worst = max(check_drawing(material, math.radians(t), math.radians(p)) for t, p in ((20, 0), (47, 30), (70, -75)))
    check_values(program, path, material)
    print(f"{path}: sound; chi-square per cell at most {worst:.2f}")


# ---- Self-test -------------------------------------------------------------------------------------------------------


def emit(fields):
    kinds = {np.dtype(name): kind for kind, name in TYPES.items()}
    size = 18 + sum(2 + len(name) + 11 + 8 * v.ndim for name, v in fields.items())
    header, body = MAGIC + struct.pack("<I", len(fields)), b""
    for name, v in fields.items():
        body += bytes(-(size + len(body)) % 8)
        header += struct.pack("<H", len(name)) + name.encode() + struct.pack("<HBQ", v.ndim, kinds[v.dtype],
                                                                             size + len(body))
        header += struct.pack(f"<{v.ndim}Q", *v.shape)
        body += v.tobytes()
    return header + body


def sound_fields():
    f4, u1 = np.dtype("<f4"), np.dtype("u1")
    return {"description": np.zeros(4, u1), "phi_i": np.zeros(1, f4), "theta_i": np.array([0, 0.8, 1.5], f4),
            "sigma": np.ones((2, 4), f4), "ndf": np.ones((2, 4), f4), "vndf": np.ones((1, 3, 5, 5), f4),
            "luminance": np.ones((1, 3, 4, 4), f4), "rgb": np.ones((1, 3, 3, 4, 4), f4), "jacobian": np.ones(1, u1)}


def self_test():
    check_rules(emit(sound_fields()))

    def broken(name, change):
        fields = sound_fields()
        change(fields)
        try:
            check_rules(emit(fields))
        except Broken:
            return
        raise SystemExit(f"not refused: {name}")

    def put(name, value):
        return lambda f: f.__setitem__(name, value)

    def black_slice(f):
        f["vndf"] = f["vndf"].copy()
        f["vndf"][0, 1] = 0

    f4 = np.dtype("<f4")
    broken("missing luminance", lambda f: f.pop("luminance"))
    broken("doubles", put("ndf", np.ones((2, 4))))
    broken("theta_i that falls", put("theta_i", np.array([0, 1.5, 0.8], f4)))
    broken("theta_i beyond pi/2", put("theta_i", np.array([0, 0.8, 1.7], f4)))
    broken("no jacobian", put("jacobian", np.zeros(1, "u1")))
    broken("colours of another size", put("rgb", np.ones((1, 3, 3, 5, 5), f4)))
    broken("black slice", black_slice)
    broken("negative density", put("luminance", -np.ones((1, 3, 4, 4), f4)))
    broken("nan", put("rgb", np.full((1, 3, 3, 4, 4), np.nan, f4)))
    broken("one row", put("sigma", np.ones((1, 4), f4)))

    def half_turn(f):
        f["phi_i"] = np.array([-math.pi, -1, 0], f4)
        for name in ("vndf", "luminance", "rgb"):
            f[name] = np.repeat(f[name], 3, axis=0)
    broken("half a turn", half_turn)
    data = emit(sound_fields())
    for cut in (4, len(data) // 2, len(data) - 1):
        try:
            check_rules(data[:cut])
        except (Broken, struct.error, ValueError, UnicodeDecodeError):
            continue
        raise SystemExit(f"not refused: {cut} bytes")
    # A density that is not the one drawn from.
    material = Material(*check_rules(data))
    incidence_density = Density.at
    check_drawing(material, 0.4, 0)
    Density.at = lambda self, x, y: incidence_density(self, x, y) * (0.5 + x)
    try:
        check_drawing(material, 0.4, 0)
    except Broken:
        print("broken files and wrong densities are refused")
        return 0
    finally:
        Density.at = incidence_density
    raise SystemExit("not refused: a wrong density")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) < 3:
        print(__doc__, file=sys.stderr)
        return 1
    source, program, *named = sys.argv[1:]
    for path in named:
        check_file(program, path)
    with tempfile.TemporaryDirectory() as folder:
        for number, (given, options) in enumerate(MADE):
            given = given if given.startswith("kurt:") else str(pathlib.Path(source) / "tests/vectors/rgl" / given)
            path = pathlib.Path(folder) / f"{number}.bsdf"
            subprocess.run([program, "convert", given, str(path), *options.split()], capture_output=True, check=True)
            check_file(program, path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
