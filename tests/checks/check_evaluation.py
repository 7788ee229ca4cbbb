#!/usr/bin/env python3
"""`sbrdf eval` and the reference evaluation agree, on every accepted vector and on files that are made here.

usage: check_evaluation.py SOURCE_DIR SBRDF
       check_evaluation.py SOURCE_DIR SBRDF --full DATA_DIR [--pairs N]    12 further files made of measured materials

Values may differ by 2e-5 of themselves or by 4e-7 of the largest stored value: the program evaluates in float. In the
half/difference frame a pair on the border of a cell, to the rounding of its coordinates, may have the value of either
side: they differ where `min` or `max` stands for the sum. Coordinates of the elevation frame have the same bits.
"""
import argparse
import io
import itertools
import math
import pathlib
import random
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
RELATIVE, OF_LARGEST = 2e-5, 4e-7
ROUNDING = 1e-11  # of a coordinate, degrees
POLAR = (0, 1e-6, 1e-3, 1, 30, 45, 60, 79.999999, 80, 80.000001, 85, 89.999999, 90, 90.000001, 120)
AZIMUTHS = (0, 360, 180, 90, 270, 45, 1e-9, 179.999999, 180.000001, 359.999999, -30, 725)

# Name, source, options: both frames and domains, guides, shares of grey, symmetries, other theta_max and precisions.
MADE = (
    ("elevation", "kurt:fabric112", "--samples 900 --placement 28/60 --domain log"),
    ("theta-max", "kurt:Brushed alum", "--samples 300 --frame half-difference --theta-max 62.5 --search-evaluations 4"),
    ("measured", "kurt:wood01", "--samples 500 --placement 40/90 --refine measured --precision lossless"),
)
FULL = (
    ("fabric112", "kurt:fabric112", "--samples 2500 --placement 20/60"),
    ("alum", "kurt:Brushed alum", "--samples 800 --frame half-difference --search-evaluations 20"),
    ("satin", "kurt:Purple satin", "--samples 1500 --placement 20/45 --domain log --theta-max 65"),
    ("wood", "kurt:wood01", "--samples 600 --search-evaluations 20 --no-mirrors --precision lossless"),
    ("velvet", "kurt:Red velvet", "--samples 400 --refine measured --frame half-difference --search-evaluations 8"),
    ("silk", "vch_silk_blue_rgb.bsdf", "--samples 500 --search-evaluations 20"),
    ("mint-guided-with-shares", "chm_mint_rgb.bsdf", "--samples 500 --search-evaluations 60"),
    ("malachite-split", "cc_green_malachite_rgb.bsdf", "--samples 900 --search-evaluations 12 --chunks split"),
    ("orange-linear", "chm_orange_rgb.bsdf", "--samples 400 --domain linear --search-evaluations 12"),
    ("felt-lossless", "acrylic_felt_green_rgb.bsdf", "--samples 200 --precision lossless --search-evaluations 12"),
    ("merl", "MERL:aurora_white_rgb.bsdf", "--samples 500 --search-evaluations 12"),
    ("merl-with-mask", "MASKED:kurt:fabric002", "--samples 300 --search-evaluations 8 --theta-max 85"),
)


def run(program, *arguments, given=""):
    done = subprocess.run([program, *map(str, arguments)], input=given, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{program} {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


# ---- Pairs -----------------------------------------------------------------------------------------------------------


def of_elevation(s, u, theta_v, theta_i):
    return theta_i, (s + u) / 2, theta_v, (s - u) / 2


def of_half_difference(phi_h, phi_d, theta_d, theta_h):
    """The light and, turned by 180 degrees about the half vector, the viewer."""
    phi_h, phi_d, theta_d, theta_h = map(math.radians, (phi_h, phi_d, theta_d, theta_h))
    angles = []
    for azimuth in (phi_d, phi_d + math.pi):
        x, y, z = math.sin(theta_d) * math.cos(azimuth), math.sin(theta_d) * math.sin(azimuth), math.cos(theta_d)
        x, z = x * math.cos(theta_h) + z * math.sin(theta_h), z * math.cos(theta_h) - x * math.sin(theta_h)
        angles += [math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(y, x) + phi_h)]
    return tuple(angles)


def on_borders(decoded, draw, count):
    """Pairs with coordinates at nodes, some of all axes, some of a few."""
    of = of_elevation if decoded.index.frame == 1 else of_half_difference
    azimuths = ((0, 720), (0, 360)) if decoded.index.frame == 1 else ((0, 360), (0, 180))
    ranges = (*azimuths, (0, 90), (0, 90))
    for _ in range(count):
        yield of(*(draw.choice(nodes) if draw.random() < 0.6 and len(nodes) > 1 else draw.uniform(*spanned)
                   for nodes, spanned in zip(decoded.lattice.axes, ranges)))


def around(centre, draw):
    return centre + draw.choice((-1, 1)) * 10**draw.uniform(-9, 0.5)


def mirror_like(draw):
    """The half vector is the normal, or close to it."""
    theta, phi = draw.choice((0, 10, 40, 70, draw.uniform(0, 90))), draw.choice((0, 90, draw.uniform(0, 360)))
    if draw.random() < 0.5:
        return theta, phi, theta, phi + 180
    return theta, phi, abs(around(theta, draw)), around(phi + 180, draw)


def pairs_of(decoded, draw, count):
    theta_max = decoded.index.theta_max
    found = [(theta_i, phi_i, theta_v, phi_v) for theta_i in (0, 1e-6, theta_max, 90.5)
             for theta_v in (0, 35, theta_max, 88) for phi_i, phi_v in ((0, 180), (360, 0), (50, 77))]
    found += [(0, 0, 0, 0), (0, 10, 0, 200), (90, 0, 90, 180), (90, 0, 90, 0), (40, 20, 40, 20), (40, 200, 40, 560)]
    while len(found) < count:
        kind = draw.randrange(5)
        if kind == 0:
            found += on_borders(decoded, draw, 1)
        elif kind == 1:
            found.append((draw.choice(POLAR), draw.choice(AZIMUTHS), draw.choice(POLAR), draw.choice(AZIMUTHS)))
        elif kind == 2:
            found.append(mirror_like(draw))
        elif kind == 3:
            found.append((draw.uniform(0, theta_max), draw.choice(AZIMUTHS), abs(around(theta_max, draw)), 33))
        else:
            found.append((draw.uniform(0, 90), draw.uniform(0, 360), draw.uniform(0, 90), draw.uniform(0, 360)))
    return [tuple(max(x, 0) if k % 2 == 0 else x for k, x in enumerate(pair)) for pair in found[:max(count, 60)]]


# ---- Comparing -------------------------------------------------------------------------------------------------------


class Worst:
    """The largest differences of a file."""

    def __init__(self, largest):
        self.largest = largest
        self.relative, self.of_largest, self.share, self.where = 0.0, 0.0, 0.0, ""
        self.borders = 0  # pairs that are in another cell than the program says

    def allowed(self, mine, program):
        return max(RELATIVE * max(abs(mine), abs(program)), OF_LARGEST * self.largest)

    def add(self, row, mine, program):
        difference = abs(mine - program)
        size = max(abs(mine), abs(program))
        allowed = self.allowed(mine, program)
        self.of_largest = max(self.of_largest, difference / self.largest if self.largest else difference)
        if difference > OF_LARGEST * self.largest:
            self.relative = max(self.relative, difference / size)
        share = difference / allowed if allowed else (math.inf if difference else 0.0)
        if not share <= self.share:
            self.share, self.where = share, f"{row}: reference {mine!r}, program {program!r}"


def on_other_sides(evaluation, pair):
    """Values of the cells that the pair may also belong to, as its coordinates are within rounding of their border."""
    x = evaluation.coordinates(*pair)
    places = []
    for axis, nodes in enumerate(evaluation.lattice.axes):
        near = [node for node in (*nodes, 0.0) if len(nodes) > 1 and abs(x[axis] - node) < ROUNDING]
        places.append([x[axis], *(max(node + side * ROUNDING, 0.0) for node in near for side in (-1, 1))])
        if axis < 2 and len(nodes) > 1 and near and min(near) == 0:
            places[-1].append(nodes[-1] - ROUNDING)
    return [evaluation.f_r_at(list(place)) for place in itertools.product(*places)]


def nearest(values, theirs):
    """For each channel the value that is nearest to the program's."""
    return [min(column, key=lambda mine: abs(mine - value)) for column, value in zip(zip(*values), theirs)]


def compare(reference, program, path, count):
    from sbrdf_evaluation import Evaluation  # pylint: disable=import-outside-toplevel
    decoded = reference.Decoded(path.read_bytes())
    pairs = pairs_of(decoded, random.Random(path.stem), count)
    csv = "theta_i,phi_i,theta_v,phi_v\n" + "".join(",".join(map(repr, pair)) + "\n" for pair in pairs)
    out = io.StringIO()
    reference.evaluate(decoded, io.StringIO(csv), out)
    mine, theirs = out.getvalue().splitlines(), run(program, "eval", path, "--filled", given=csv).splitlines()
    if mine[0] != theirs[0] or len(mine) != len(theirs):
        raise SystemExit(f"{path.name}: the columns or rows differ: {mine[0]} / {theirs[0]}")
    worst = Worst(max(abs(end) for spanned in decoded.index.ranges for end in spanned))
    evaluation = Evaluation(decoded)
    for pair, a, b in zip(pairs, mine[1:], theirs[1:]):
        a, b = ([float(value) for value in line.split(",")[4:]] for line in (a, b))
        differs = any(abs(x - y) > worst.allowed(x, y) for x, y in zip(a, b))
        if differs and decoded.index.frame == 2 and max(pair[0], pair[2]) <= 90:
            a = nearest(on_other_sides(evaluation, pair), b)
            worst.borders += 1
        for x, y in zip(a, b):
            worst.add(pair, x, y)
    return worst


def source_of(name, program, data, folder):
    """The file or model to convert; of some a table is made first."""
    kind, _, rest = name.partition(":")
    if kind not in ("MERL", "MASKED"):
        return name if kind == "kurt" else data / name
    table = folder / "table.binary"
    run(program, "convert", rest if rest.startswith("kurt:") else data / rest, table)
    if kind == "MASKED":
        make_hole(table)
    return table


def make_hole(table):
    """Marks a box of cells of a MERL table as not measured: -1 in all channels."""
    content = bytearray(table.read_bytes())
    cells = 90 * 90 * 180
    for theta_h in range(20, 30):
        for theta_d in range(50, 60):
            for phi_d in range(180):
                for channel in range(3):
                    at = 12 + 8 * (channel * cells + (theta_h * 90 + theta_d) * 180 + phi_d)
                    content[at:at + 8] = b"\0\0\0\0\0\0\xf0\xbf"
    table.write_bytes(content)


def made_files(program, data, folder, wanted):
    for name, source, options in wanted:
        path = folder / f"{name}.sbrdf"
        run(program, "convert", source_of(source, program, data, folder), path, *options.split())
        yield path


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("program")
    parser.add_argument("--full", type=pathlib.Path, metavar="DATA_DIR")
    parser.add_argument("--pairs", type=int)
    arguments = parser.parse_args()
    root, program = arguments.root, arguments.program
    sys.path.insert(0, str(root / "specs" / "reference"))
    import sbrdf_reference as reference  # pylint: disable=import-outside-toplevel
    count = arguments.pairs or (6000 if arguments.full else 120)
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        vectors = sorted((root / "tests" / "vectors" / "sbrdf" / "accept").glob("*.sbrdf"))
        made = made_files(program, arguments.full, pathlib.Path(name), FULL if arguments.full else MADE)
        print(f"{'file':36} {'pairs':>6} {'relative':>9} {'of largest':>10} {'on borders':>10}")
        for path in (*vectors, *made):
            worst = compare(reference, program, path, count)
            print(f"{path.stem:36} {count:6} {worst.relative:9.1e} {worst.of_largest:10.1e} {worst.borders:10}",
                  flush=True)
            if worst.share > 1:
                failed += 1
                print(f"  beyond what is allowed: {worst.share:.3g} times, at {worst.where}")
    return 1 if failed or not vectors else 0


if __name__ == "__main__":
    sys.exit(main())
