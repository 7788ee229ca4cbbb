#!/usr/bin/env python3
"""A small isotropic material in the layout of specs/rgl.md, made of a formula, and values of it worked out from that page.

usage: make_rgl_material.py FOLDER    writes small.bsdf and small_reference.csv

The material is a rough gold: GGX normals, colours that fade towards grazing. The values are those of section 3 of the
page, in double precision and one step at a time: no code is shared with the program that they check. Files that are
there already are left as they are.
"""
import bisect
import math
import pathlib
import random
import struct
import sys

ALPHA = 0.4
COLOURS = (0.95, 0.72, 0.35)
THETA_I = [0, 0.35, 0.7, 1.0, 1.25, 1.45]
SQUARE, PALETTE, PROFILE = 16, 10, 16  # nodes along an axis of vndf, of rgb, and along x of ndf and sigma
F32 = struct.Struct("<f")


def single(value):
    return F32.unpack(F32.pack(value))[0]


def normals(theta):
    """GGX distribution of microfacet normals."""
    return ALPHA ** 2 / (math.pi * (math.cos(theta) ** 2 * (ALPHA ** 2 - 1) + 1) ** 2)


def area(theta):
    return 0.5 * (math.cos(theta) + math.sqrt(math.cos(theta) ** 2 + (ALPHA * math.sin(theta)) ** 2))


def visible_normals(theta_i, x, y):
    """As a density over the square: the solid angle of a piece of it is in proportion to x sin(theta)."""
    theta, phi = x * x * math.pi / 2, (2 * y - 1) * math.pi
    cosine = math.cos(theta) * math.cos(theta_i) + math.sin(theta) * math.cos(phi) * math.sin(theta_i)
    return normals(theta) * max(0, cosine) * x * math.sin(theta)


def colour(theta_i, channel, x):
    fade = (1 - x) ** 5
    return (COLOURS[channel] + (1 - COLOURS[channel]) * fade) * (0.6 + 0.4 * math.cos(theta_i))


def steps(count):
    return [k / (count - 1) for k in range(count)]


def fields():
    """Name, element type, shape and elements of each field; f32 is type 10, u8 type 1."""
    profile = [x * x * math.pi / 2 for x in steps(PROFILE)] * 2
    text = list(b"Rough gold, made of a formula")
    return [
        ("description", 1, [len(text)], text),
        ("phi_i", 10, [1], [0]),
        ("theta_i", 10, [len(THETA_I)], THETA_I),
        ("sigma", 10, [2, PROFILE], [area(theta) for theta in profile]),
        ("ndf", 10, [2, PROFILE], [normals(theta) for theta in profile]),
        ("vndf", 10, [1, len(THETA_I), SQUARE, SQUARE],
         [visible_normals(theta, x, y) for theta in THETA_I for y in steps(SQUARE) for x in steps(SQUARE)]),
        ("jacobian", 1, [1], [1]),
        ("rgb", 10, [1, len(THETA_I), 3, PALETTE, PALETTE],
         [colour(theta, c, x) for theta in THETA_I for c in range(3) for _ in range(PALETTE) for x in steps(PALETTE)]),
    ]


def emit(contents):
    offset = 18 + sum(2 + len(name) + 2 + 1 + 8 + 8 * len(shape) for name, _, shape, _ in contents)
    header, elements = b"tensor_file\0\x01\x00" + struct.pack("<I", len(contents)), b""
    for name, kind, shape, values in contents:
        header += struct.pack("<H", len(name)) + name.encode() + struct.pack("<HBQ", len(shape), kind, offset)
        header += struct.pack(f"<{len(shape)}Q", *shape)
        coded = bytes(values) if kind == 1 else struct.pack(f"<{len(values)}f", *values)
        offset += len(coded)
        elements += coded
    return header + elements


class Grid:
    """Bilinear over the unit square, nodes at both ends."""

    def __init__(self, values, x_count, scale=1):
        self.rows = [[v * scale for v in values[k:k + x_count]] for k in range(0, len(values), x_count)]

    @staticmethod
    def place(position, count):
        k = min(int(position * (count - 1)), count - 2)
        return k, position * (count - 1) - k

    def row(self, y):
        k, t = self.place(y, len(self.rows))
        return [(1 - t) * a + t * b for a, b in zip(self.rows[k], self.rows[k + 1])]

    def at(self, x, y):
        return along(self.row(y), x)


def along(row, x):
    k, t = Grid.place(x, len(row))
    return (1 - t) * row[k] + t * row[k + 1]


def integral(row, x=1.0):
    """Of the broken line through the row, from 0 to x."""
    k, t = Grid.place(x, len(row))
    whole = sum((a + b) / 2 for a, b in zip(row[:k], row[1:k + 1]))
    return (whole + t * (row[k] + along(row, x)) / 2) / (len(row) - 1)


class Material:
    def __init__(self, contents):
        self.by_name = {name: [single(v) for v in values] for name, kind, _, values in contents if kind == 10}
        self.sigma = Grid(self.by_name["sigma"], PROFILE)
        self.ndf = Grid(self.by_name["ndf"], PROFILE)
        self.vndf = [self.normalised(values) for values in self.parts("vndf", SQUARE ** 2)]
        self.rgb = [Grid(values, PALETTE) for values in self.parts("rgb", PALETTE ** 2)]

    def parts(self, name, size):
        values = self.by_name[name]
        return [values[k:k + size] for k in range(0, len(values), size)]

    @staticmethod
    def normalised(values):
        rows = Grid(values, SQUARE).rows
        return Grid(values, SQUARE, 1 / integral([integral(row) for row in rows]))

    def slices(self, theta_i):
        """Numbers of the slices on both sides, and their weights."""
        nodes = self.by_name["theta_i"]
        at = min(max(theta_i, nodes[0]), nodes[-1])
        k = min(bisect.bisect_right(nodes, at) - 1, len(nodes) - 2)
        t = (at - nodes[k]) / (nodes[k + 1] - nodes[k])
        return ((k, 1 - t), (k + 1, t))

    def f_r_cos(self, theta_i, theta_v, phi):
        """The azimuth is that of the viewer less that of the light."""
        i = (math.sin(theta_i), 0, math.cos(theta_i))
        v = (math.sin(theta_v) * math.cos(phi), math.sin(theta_v) * math.sin(phi), math.cos(theta_v))
        h = [a + b for a, b in zip(i, v)]
        theta_m = math.atan2(math.hypot(h[0], h[1]), h[2])
        x, y = math.sqrt(theta_m * 2 / math.pi), math.atan2(h[1], h[0]) / (2 * math.pi) + 0.5
        part = below = across = 0
        for k, weight in self.slices(theta_i):
            row = self.vndf[k].row(y)
            below += weight * integral([integral(r) for r in self.vndf[k].rows], y)
            part += weight * integral(row, x)
            across += weight * integral(row)
        s_x = part / across if across > 0 else 0
        scale = self.ndf.at(x, y) / (4 * self.sigma.at(math.sqrt(theta_i * 2 / math.pi), 0.5))
        return [scale * sum(weight * self.rgb[3 * k + c].at(s_x, below) for k, weight in self.slices(theta_i))
                for c in range(3)]


def reference(material):
    draw = random.Random(1)
    lines = ["# f_r cos(theta_v), worked out by specs/reference/make_rgl_material.py",
             "file,theta_i,phi_i,theta_v,phi_v,R,G,B"]
    for _ in range(60):
        theta_i, theta_v = (round(draw.uniform(0, 88), 2) for _ in range(2))
        phi_i, phi_v = (round(draw.uniform(0, 360), 2) for _ in range(2))
        values = material.f_r_cos(math.radians(theta_i), math.radians(theta_v), math.radians(phi_v - phi_i))
        lines.append(",".join(["small.bsdf", *map(str, (theta_i, phi_i, theta_v, phi_v)), *(f"{v:.9g}" for v in values)]))
    return "\n".join(lines) + "\n"


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    contents = fields()
    for name, made in (("small.bsdf", emit(contents)), ("small_reference.csv", reference(Material(contents)).encode())):
        path = pathlib.Path(sys.argv[1]) / name
        if not path.exists():
            path.write_bytes(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
