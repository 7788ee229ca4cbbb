#!/usr/bin/env python3
"""Shaders of atlases in a browser (WebGL 2, drawn by the processor), with three.js:

- the example draws the sphere that engine_sphere.py makes of `sbrdf eval`, from KTX2, EXR and DDS files;
- 100,000 pairs of directions, of which horizon, poles and planes of symmetry have more than their share, give what
  `sbrdf eval` gives for the same atlas.

usage: check_web.py EXAMPLE SBRDF MODULES [DATA] [--llvmpipe]

three.js is fetched into the folder MODULES by `npm ci`. DATA holds the measured files, unless SBRDF_TEST_DATA names
their folder. Without numpy, chromium, npm or three.js nothing is checked, and the exit code is 77; with
SBRDF_REQUIRE_SHADER_TOOLS in the environment it is 1. --llvmpipe has Mesa draw instead of SwiftShader.
"""
import functools
import http.server
import json
import os
import pathlib
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import engine_sphere as sphere
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
WIDTH, HEIGHT = 400, 250  # of the texture of pairs
MOST_RELATIVE, MOST_MEAN = 2e-3, 5e-5
PATIENCE = 240  # seconds for one drawing


# ---- three.js --------------------------------------------------------------------------------------------------------


def fetch_modules(example, folder):
    """The folder node_modules with what package-lock.json asks for."""
    folder.mkdir(parents=True, exist_ok=True)
    lock = (example / "package-lock.json").read_bytes()
    done = folder / "installed.json"
    if done.exists() and done.read_bytes() == lock:
        return folder / "node_modules"
    for name in ("package.json", "package-lock.json"):
        shutil.copy(example / name, folder / name)
    for _ in range(2):
        npm = subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--fetch-retries=0"], cwd=folder,
                             capture_output=True, text=True, check=False)
        if npm.returncode == 0:
            done.write_bytes(lock)
            return folder / "node_modules"
    sphere.missing(f"three.js, which npm does not fetch: {npm.stderr.strip()}")
    return None


# ---- The browser -----------------------------------------------------------------------------------------------------


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves a folder, and puts what is posted into a queue, with the time."""

    def __init__(self, answers, *arguments, **named):
        self.answers = answers
        super().__init__(*arguments, **named)

    def do_POST(self):
        content = self.rfile.read(int(self.headers["Content-Length"]))
        self.answers.put((self.path[1:], content, time.monotonic()))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_):
        pass


def start_browser(folder, port, llvmpipe):
    drawn_by = ["--use-angle=gl-egl", "--ignore-gpu-blocklist"] if llvmpipe else ["--use-angle=swiftshader",
                                                                                  "--enable-unsafe-swiftshader"]
    # Without a sandbox, which root and most containers lack: all pages are our own.
    command = ["chromium", "--headless=new", "--no-sandbox", "--use-gl=angle", *drawn_by, "--disable-dev-shm-usage",
               "--disable-background-networking", "--no-first-run", f"--user-data-dir={folder / 'profile'}",
               "--enable-logging=stderr", f"http://127.0.0.1:{port}/check_web.html"]
    with open(folder / "browser.log", "wb") as log:
        return subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True,
                                env=os.environ | {"HOME": str(folder), "LIBGL_ALWAYS_SOFTWARE": "1"})


def end_browser(browser):
    """With all processes that it started."""
    os.killpg(browser.pid, signal.SIGTERM)
    try:
        browser.wait(timeout=10)
    except subprocess.TimeoutExpired:
        os.killpg(browser.pid, signal.SIGKILL)
        browser.wait()


def said_by_pages(folder):
    """The browser's log from the first message of a page on, such as that of a shader that does not compile."""
    log = folder / "browser.log"
    text = log.read_text(errors="replace") if log.exists() else ""
    return text[text.find(":CONSOLE") :][:3000]


def answers_of(folder, jobs, llvmpipe):
    """What the browser drew for each job, in their order, as bytes, and the seconds that it took."""
    (folder / "jobs.json").write_text(json.dumps(jobs))
    answers = queue.Queue()
    handler = functools.partial(Handler, answers, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    browser = start_browser(folder, server.server_address[1], llvmpipe)
    try:
        last = 0
        while True:
            kind, content, now = answers.get(timeout=PATIENCE)
            assert kind != "error", content.decode()
            if kind == "end":
                return
            if kind == "renderer":
                print("drawn by", content.decode())
            else:
                yield content, now - last
            last = now
    except queue.Empty:
        raise AssertionError("the browser is silent") from None
    finally:
        end_browser(browser)
        server.shutdown()


# ---- Pairs of directions ---------------------------------------------------------------------------------------------


def draw_pairs():
    """A third anywhere, a third about the mirror direction, a third with one direction near a pole, at the horizon, or
    on a plane of symmetry. Unit vectors [n, 3] in float32."""
    draw = np.random.default_rng(5)
    count = WIDTH * HEIGHT
    theta_i, theta_v = draw.uniform(0, 90, (2, count))
    phi_i, phi_v = draw.uniform(0, 360, (2, count))
    kind = np.arange(count) % 3
    where = np.arange(count) // 3 % 4
    near = kind == 1
    spread = 20 * draw.uniform(size=(count)) ** 3
    theta_v[near] = np.clip(theta_i + spread * draw.uniform(-0.5, 0.5, count), 0, 90)[near]
    phi_v[near] = (phi_i + 180 + spread * draw.uniform(-0.5, 0.5, count))[near]
    special = [(kind == 2) & (where == k) for k in range(4)]
    theta_i[special[0]] = draw.uniform(size=special[0].sum()) ** 3
    theta_v[special[1]] = 90 - draw.uniform(size=special[1].sum()) ** 2
    phi_v[special[2]] = phi_i[special[2]] + 90 * draw.integers(0, 4, special[2].sum())
    theta_v[special[3]] = theta_i[special[3]]
    # The ends themselves.
    theta_i[special[0]][::50] = 0
    theta_v[special[1]][::50] = 90

    def unit(theta, phi):
        theta, phi = np.radians(theta), np.radians(phi)
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1).astype("<f4")

    return unit(theta_i, phi_i), unit(theta_v, phi_v)


def check_values(name, values, expected, w_i, w_v):
    values = np.frombuffer(values, "<f4").reshape(-1, 4)[:, :3]
    assert values.shape == expected.shape and np.isfinite(values).all(), name
    scale = np.maximum(np.abs(expected).max(axis=1), 1e-3 * np.abs(expected).mean())
    relative = np.abs(values - expected).max(axis=1) / scale
    # Where both lie on the horizon, opposite each other, the half vector is what rounding makes of it.
    opposite = np.linalg.norm(w_i + w_v, axis=1) < 0.01
    k = np.where(opposite, 0, relative).argmax()
    print(f"{name}: {(~opposite).sum()} pairs differ by {relative[k]:.2g} of the largest channel at most, at {w_i[k]}, "
          f"{w_v[k]}; {opposite.sum()} opposite ones by {relative[opposite].max():.2g}; mean {relative.mean():.2g}")
    assert relative[k] <= MOST_RELATIVE and relative[opposite].max() <= 10 * MOST_RELATIVE, name
    assert relative.mean() <= MOST_MEAN, name


# ---- Materials -------------------------------------------------------------------------------------------------------

SPHERES = (  # prefix, which begins with the material; container; how texels are stored
    ("fabric112.halves", "ktx2", ("--texel", "rgba16f")),
    ("fabric112.packed", "ktx2", ("--texel", "e5b9g9r9", "--zstd")),
    ("alum.halves", "exr", ("--texel", "rgba16f")),
    ("alum.blocks", "dds", ("--texel", "bc6h", "--fast")),
)


def measured_table(program, folder, data):
    """A MERL table of a measured isotropic material, or none."""
    path = pathlib.Path(os.environ.get("SBRDF_TEST_DATA") or data or ".") / "rgl" / "chm_orange_rgb.bsdf"
    if not path.exists():
        print("no measured material:", path)
        assert "SBRDF_REQUIRE_TEST_DATA" not in os.environ, path
        return None
    sphere.run(program, "convert", path, folder / "chm_orange.binary")
    return folder / "chm_orange.binary"


def make_jobs(program, folder, data):
    """What a browser is asked for; the files lie in the folder."""
    jobs = []
    for name, container, options in SPHERES:
        sphere.make_atlas(program, folder / name, "--container", container, *options)
        jobs.append({"name": name, "atlas": f"{name}.{container}"})
    materials = dict(sphere.MATERIALS)
    table = measured_table(program, folder, data)
    if table is not None:
        materials["chm_orange"] = (table, ("--samples", "1000"))
    for name, material in materials.items():
        sphere.make_atlas(program, folder / f"{name}.float", "--texel", "rgb32f", material=material)
        jobs.append({"name": f"{name}.float", "atlas": f"{name}.float.ktx2", "pairs": "pairs.bin", "width": WIDTH,
                     "height": HEIGHT})
    return jobs


def check(program, folder, data, llvmpipe):
    w_i, w_v = draw_pairs()
    filled = [np.pad(w, ((0, 0), (0, 1))) for w in (w_i, w_v)]
    (folder / "pairs.bin").write_bytes(np.concatenate(filled).astype("<f4").tobytes())
    jobs = make_jobs(program, folder, data)
    print("made", len(jobs), "atlases")
    for job, (answer, seconds) in zip(jobs, answers_of(folder, jobs, llvmpipe), strict=True):
        manifest = folder / f"{job['name']}.json"
        if "pairs" in job:
            expected = sphere.evaluated(program, manifest, w_i, w_v)
            check_values(job["name"], answer, expected, w_i.astype(float), w_v.astype(float))
        else:
            picture = np.frombuffer(answer, "u1").reshape(sphere.SIDE, sphere.SIDE, 4)[::-1, :, :3]
            sphere.check_picture("three.js, " + job["name"], picture, sphere.expected_picture(program, manifest))
        print(f"  drawn in {seconds:.1f} s")


def main():
    arguments = [a for a in sys.argv[1:] if a != "--llvmpipe"]
    if len(arguments) not in (3, 4):
        print(__doc__, file=sys.stderr)
        return 1
    example, program, modules = pathlib.Path(arguments[0]), arguments[1], pathlib.Path(arguments[2])
    for tool in ("chromium", "npm"):
        if shutil.which(tool) is None:
            sphere.missing(tool)
    node_modules = fetch_modules(example, modules)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = pathlib.Path(name)
        for path in (*(example / n for n in ("index.html", "main.js", "atlas.js")), *HERE.glob("check_web.[hj]*")):
            shutil.copy(path, folder)
        (folder / "node_modules").symlink_to(node_modules.resolve())
        try:
            check(program, folder, (arguments + [None])[3], "--llvmpipe" in sys.argv)
        except AssertionError:
            print(said_by_pages(folder))
            raise
    return 0


if __name__ == "__main__":
    sys.exit(main())
