"""The sphere that the examples for engines draw, as `sbrdf eval` has it; for check_web.py and check_godot.py.

The sphere of radius 1 is at the origin, the camera at (0, 0, 4) looks along -z with a field of view of 32 degrees, the
light comes from (-2, 3, 4) and lets a white surface that faces it be white: a pixel is pi f_r cos(theta_i), cut off at
1, by the curve of sRGB. The tangent leads around the axis y. Pixels are compared where the viewer is less than 80
degrees from the normal, which leaves out the rim, 1.5 % of the radius, where a sphere of triangles is not round.
"""
import math
import os
import subprocess
import sys


def missing(what):
    """Skips the test for want of something, or fails where nothing may be wanting."""
    required = "SBRDF_REQUIRE_SHADER_TOOLS" in os.environ
    print("missing:" if required else "skipped for want of", what)
    sys.exit(1 if required else 77)


try:
    import numpy as np
except ImportError:
    missing("numpy")

SIDE = 512
DISTANCE = 4.0
TO_LIGHT = np.array([-2.0, 3.0, 4.0]) / math.sqrt(29)
FIELD_OF_VIEW = math.radians(32)
LEAST_COSINE = math.cos(math.radians(80))
TOLERANCE = 2  # of 255

# Two anisotropic materials, one in either frame, so that shaders have most lines that there are: (file, slicing).
MATERIALS = {
    "alum": ("kurt:Brushed alum", ("--placement", "14/36", "--samples", "4000")),
    "fabric112": ("kurt:fabric112", ("--frame", "half-difference", "--samples", "800", "--search-evaluations", "20")),
}


def run(*arguments, text=None):
    done = subprocess.run([str(a) for a in arguments], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def make_atlas(program, prefix, *options, material=None):
    """Files of the prefix, which begins with the material's name, and a sliced one beside them, made once for each."""
    name = prefix.name.split(".")[0]
    sliced = prefix.with_name(f"{name}.sbrdf")
    if not sliced.exists():
        source, slices = material or MATERIALS[name]
        run(program, "convert", source, sliced, *slices)
    run(program, "atlas", sliced, prefix, "--max-error", "2", *options)


def evaluated(program, manifest, w_i, w_v):
    """f_r [n, 3] of unit vectors [n, 3]."""
    angles = [np.degrees(f) for w in (w_i.astype(float), w_v.astype(float))
              for f in (np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]), np.arctan2(w[:, 1], w[:, 0]))]
    rows = "\n".join(map("%.9g,%.9g,%.9g,%.9g".__mod__, zip(*angles)))
    table = run(program, "eval", manifest, text=f"theta_i,phi_i,theta_v,phi_v\n{rows}\n")
    return np.loadtxt(table.splitlines()[1:], delimiter=",", usecols=(4, 5, 6))


def compared_pixels():
    """Which pixels [SIDE, SIDE] are compared, and of these w_i and w_v [n, 3] in the surface's frame."""
    row, column = (np.mgrid[0:SIDE, 0:SIDE] + 0.5) * 2 / SIDE - 1
    ray = np.stack([column, -row, np.full_like(row, -1 / math.tan(FIELD_OF_VIEW / 2))], axis=-1)
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.array([0, 0, DISTANCE])
    along = -ray @ eye
    below_root = along**2 - DISTANCE**2 + 1
    normal = eye + (along - np.sqrt(np.maximum(below_root, 0)))[..., None] * ray
    seen = (below_root > 0) & (-(normal * ray).sum(axis=-1) > LEAST_COSINE)
    z = normal[seen]
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    frame = np.stack([x, np.cross(z, x), z], axis=1)
    return seen, frame @ TO_LIGHT, -np.einsum("nij,nj->ni", frame, ray[seen])


def expected_picture(program, manifest):
    """Which pixels are compared, and these [n, 3], from 0 to 255."""
    seen, w_i, w_v = compared_pixels()
    light = np.zeros((seen.sum(), 3))
    lit = w_i[:, 2] > 0
    light[lit] = math.pi * w_i[lit, 2:] * evaluated(program, manifest, w_i[lit], w_v[lit])
    light = np.clip(light, 0, 1)
    curve = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return seen, np.round(255 * curve).astype(int)


def check_picture(name, picture, expected):
    """A picture [SIDE, SIDE, 3] of bytes, or what stands there as such."""
    seen, colours = expected
    assert picture.shape == (SIDE, SIDE, 3), picture.shape
    difference = np.abs(picture[seen].astype(int) - colours)
    print(f"{name}: {seen.sum()} pixels, the largest difference is {difference.max()} of 255, "
          f"{(difference > 1).any(axis=1).sum()} pixels by more than 1; values {colours.min()} to {colours.max()}")
    assert colours.max() - colours.min() > 100, f"{name}: a sphere that shows nothing"
    assert difference.max() <= TOLERANCE, name
    assert not picture[0].any() and not picture[:, -1].any(), f"{name}: the background is black"
