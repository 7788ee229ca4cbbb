#!/usr/bin/env python3
"""Tables of other programs: what the program reads and writes agrees with readers that are written here, from the pages
specs/ngan.md and specs/utia.md alone.

usage: check_foreign_tables.py SBRDF

Without numpy nothing is checked, and the exit code is 77.
"""
import itertools
import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("numpy is missing")
    sys.exit(77)

ROUNDING = 3e-6  # of a value: the program evaluates in float


def run(program, *arguments, given=""):
    done = subprocess.run([program, *map(str, arguments)], input=given, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{program} {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def evaluated(program, source, pairs):
    """An array of pairs x channels."""
    lines = ["theta_i,phi_i,theta_v,phi_v", *(",".join(map(repr, map(float, pair))) for pair in pairs)]
    rows = run(program, "eval", source, given="\n".join(lines) + "\n").splitlines()[1:]
    return np.array([[float(x) for x in row.split(",")[4:]] for row in rows])


def check(name, found, expected):
    if found.shape != expected.shape:
        raise SystemExit(f"{name}: {found.shape} values, not {expected.shape}")
    worst = (np.abs(found - expected) / np.maximum(np.abs(expected), 1e-9 * np.abs(expected).max())).max()
    if not worst <= ROUNDING:
        raise SystemExit(f"{name}: differs by {worst:.3g} of a value")
    print(f"{name}: {len(found)} directions differ by at most {worst:.2g} of a value")


# ---- Readers ---------------------------------------------------------------------------------------------------------


def read_ngan(path, interleaved=False, edge=False):
    """Values [channel, theta_in, theta_out, phi_diff, phi_in], and the nodes along the four axes."""
    content = path.read_bytes()
    header = np.frombuffer(content, "<i4", 16)
    shape, channels = tuple(header[:4]), header[10]
    assert header[6] == 1 and header[7] == 0
    values = np.frombuffer(content, "<f4", offset=64).astype(float)
    values = np.moveaxis(values.reshape(*shape, channels), -1, 0) if interleaved else values.reshape(channels, *shape)
    ranges = (90, 90, 180 if header[9] else 360, 360)
    nodes = [(np.arange(n) + (0 if edge else 0.5)) * r / n for n, r in zip(shape, ranges)]
    return values, nodes


def read_utia(path):
    """Values [channel, theta_i, phi_i, theta_v, phi_v], and the nodes along the four axes."""
    values = np.fromfile(path, "<f8").reshape(3, 6, 48, 6, 48)
    return values, [15.0 * np.arange(6), 7.5 * np.arange(48)] * 2


def interpolated(values, nodes, places):
    """Linear along each axis; azimuths (axes of which the last node is above 90) go round, thetas hold their ends."""
    result = []
    for place in places:
        corner = values
        for at, axis in zip(place, nodes):
            if axis[-1] > 90:
                closed = np.append(axis, axis[0] + 360)
                at = axis[0] + (at - axis[0]) % 360
                k = min(np.searchsorted(closed, at, side="right") - 1, len(axis) - 1)
                weight = (at - closed[k]) / (closed[k + 1] - closed[k])
                corner = (1 - weight) * corner[:, k] + weight * corner[:, (k + 1) % len(axis)]
            else:
                k = np.clip(np.searchsorted(axis, at, side="right") - 1, 0, len(axis) - 2)
                weight = np.clip((at - axis[k]) / (axis[k + 1] - axis[k]), 0, 1)
                corner = (1 - weight) * corner[:, k] + weight * corner[:, k + 1]
        result.append(corner)
    return np.array(result)


# ---- Pairs and places ------------------------------------------------------------------------------------------------


def pair_of_ngan(place):
    theta_in, theta_out, phi_diff, phi_in = place
    return theta_in, phi_in, theta_out, phi_in + phi_diff


def some_nodes(nodes, draw, count):
    return [tuple(draw.choice(axis) for axis in nodes) for _ in range(count)]


def closed_form(theta_i, phi_i, theta_v, phi_v):
    """Three channels, anisotropic, and another function with light and viewer exchanged."""
    a, b, c, d = np.radians((theta_i, phi_i, theta_v, phi_v))
    return 2 + a * np.sin(b), 2 + 0.3 * c * np.cos(2 * d + 0.4), 1.5 + a * np.cos(b - d) + 0.2 * c


# ---- Checks ----------------------------------------------------------------------------------------------------------


def check_ngan_reading(program, folder, draw):
    shape, path = (5, 6, 8, 12), folder / "made.dat"
    nodes = [(np.arange(n) + 0.5) * r / n for n, r in zip(shape, (90, 90, 360, 360))]
    values = np.array([closed_form(*pair_of_ngan(place)) for place in itertools.product(*nodes)]).T.reshape(3, *shape)
    header = np.array([*shape, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0, 0], "<i4")
    path.write_bytes(header.tobytes() + values.astype("<f4").tobytes())
    places = some_nodes(nodes, draw, 200)
    expected = np.array([closed_form(*pair_of_ngan(place)) for place in places])
    check("ngan, at nodes", evaluated(program, path, map(pair_of_ngan, places)), expected)
    places = [tuple(draw.uniform((0, 0, -360, 0), (90, 90, 360, 360))) for _ in range(300)]
    expected = interpolated(read_ngan(path)[0], nodes, places)
    check("ngan, between nodes", evaluated(program, path, map(pair_of_ngan, places)), expected)


def check_ngan_conventions(program, folder, draw):
    """Channels side by side and values at edges, through a table that does not need an option to be evaluated."""
    shape, path, out = (4, 5, 6, 7), folder / "side.dat", folder / "side.bin"
    values = draw.uniform(0.5, 2, (*shape, 3)).astype("<f4")
    header = np.array([*shape, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0, 0], "<i4")
    path.write_bytes(header.tobytes() + values.tobytes())
    run(program, "convert", path, out, "--ngan-channels", "interleaved", "--ngan-position", "edge")
    table, nodes = read_utia(out)
    indices = [tuple(draw.integers(0, n) for n in table.shape[1:]) for _ in range(300)]
    pairs = [tuple(axis[k] for axis, k in zip(nodes, index)) for index in indices]
    places = [(ti, tv, pv - pi, pi) for ti, pi, tv, pv in pairs]
    expected = interpolated(*read_ngan(path, interleaved=True, edge=True), places)
    check("ngan, other conventions", np.array([table[(slice(None), *index)] for index in indices]), expected)


def check_ngan_writing(program, folder, draw):
    path = folder / "written.dat"
    for options in ((), ("--ngan-half",), ("--ngan-position", "edge", "--ngan-channels", "interleaved")):
        run(program, "convert", "kurt:fabric112", path, "--ngan-shape", "7,8,10,9", *options)
        values, nodes = read_ngan(path, interleaved="interleaved" in options, edge="edge" in options)
        assert (nodes[2][-1] < 180) == ("--ngan-half" in options)
        indices = [tuple(draw.integers(0, n) for n in values.shape[1:]) for _ in range(200)]
        places = [tuple(axis[k] for axis, k in zip(nodes, index)) for index in indices]
        expected = evaluated(program, "kurt:fabric112", map(pair_of_ngan, places))
        check(f"ngan written {' '.join(options)}", np.array([values[(slice(None), *index)] for index in indices]), expected)


def check_utia_reading(program, folder, draw):
    path, nodes = folder / "made.bin", [15.0 * np.arange(6), 7.5 * np.arange(48)] * 2
    grid = np.meshgrid(*nodes, indexing="ij")
    np.array(closed_form(*grid)).astype("<f8").tofile(path)
    pairs = some_nodes(nodes, draw, 200)
    check("utia, at nodes", evaluated(program, path, pairs), np.array([closed_form(*pair) for pair in pairs]))
    pairs = [tuple(draw.uniform((0, -360, 0, 0), (90, 360, 90, 360))) for _ in range(300)]
    check("utia, between nodes", evaluated(program, path, pairs), interpolated(*read_utia(path), pairs))


def check_utia_writing(program, folder, draw):
    path = folder / "written.bin"
    for scale, options in ((1, ()), (0.01, ("--utia-scale", "100"))):
        run(program, "convert", "kurt:fabric112", path, *options)
        assert path.stat().st_size == 1990656
        values, nodes = read_utia(path)
        indices = [tuple(draw.integers(0, n) for n in values.shape[1:]) for _ in range(300)]
        pairs = [tuple(axis[k] for axis, k in zip(nodes, index)) for index in indices]
        expected = scale * evaluated(program, "kurt:fabric112", pairs)
        check(f"utia written {' '.join(options)}", np.array([values[(slice(None), *index)] for index in indices]), expected)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    program, draw = sys.argv[1], np.random.default_rng(5)
    with tempfile.TemporaryDirectory() as name:
        for part in (check_ngan_reading, check_ngan_conventions, check_ngan_writing, check_utia_reading,
                     check_utia_writing):
            part(program, pathlib.Path(name), draw)
    return 0


if __name__ == "__main__":
    sys.exit(main())
