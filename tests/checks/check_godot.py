#!/usr/bin/env python3
"""Runs the example for Godot 3 on a virtual display, drawn by the processor, and compares its picture with the one
that engine_sphere.py makes of `sbrdf eval`.

usage: check_godot.py EXAMPLE SBRDF

Without numpy, oiiotool, Xvfb or godot3 nothing is checked, and the exit code is 77; with SBRDF_REQUIRE_SHADER_TOOLS in
the environment it is 1.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import engine_sphere as sphere
import numpy as np


def start_display():
    """The display's process and its name."""
    read, write = os.pipe()
    display = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "640x640x24", "-nolisten", "tcp"],
                               pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as answer:
        number = answer.readline().strip()
    assert number, "Xvfb did not start"
    return display, f":{number}"


def draw(example, prefix, folder, display):
    environment = os.environ | {"DISPLAY": display, "HOME": str(folder), "LIBGL_ALWAYS_SOFTWARE": "1",
                                "GALLIUM_DRIVER": "llvmpipe"}
    picture = folder / "picture.png"
    done = subprocess.run(["godot3", "--audio-driver", "Dummy", "--path", example, f"--atlas={prefix}",
                           f"--picture={picture}"], env=environment, capture_output=True, text=True, timeout=120,
                          check=False)
    said = done.stdout + done.stderr
    assert done.returncode == 0 and picture.exists() and "SHADER ERROR" not in said, (done.returncode, said)
    return picture


def read_picture(path, side):
    plain = path.with_suffix(".ppm")
    subprocess.run(["oiiotool", path, "--ch", "R,G,B", "-o", plain], check=True)
    return np.frombuffer(plain.read_bytes()[-3 * side * side :], "u1").reshape(side, side, 3)


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    program = sys.argv[2]
    for tool in ("Xvfb", "godot3", "oiiotool"):
        if shutil.which(tool) is None:
            sphere.missing(tool)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        example = shutil.copytree(sys.argv[1], folder / "example")
        display, display_name = start_display()
        try:
            for name in sphere.MATERIALS:
                sphere.make_atlas(program, folder / name, "--container", "exr")
                picture = draw(example, folder / name, folder, display_name)
                sphere.check_picture(f"Godot, {name}", read_picture(picture, sphere.SIDE),
                                     sphere.expected_picture(program, folder / f"{name}.json"))
        finally:
            display.terminate()
            display.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
