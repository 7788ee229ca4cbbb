#!/usr/bin/env python3
"""Atlases as `sbrdf atlas` writes them: every pair of texels and container that is allowed, with headers read here from
the specifications of KTX2, DDS and EXR; what the report says against the files on disk and against `sbrdf compare`; and
bad input of all kinds, after which nothing has changed on disk.

usage: check_atlas.py SBRDF
"""
import json
import pathlib
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile

import jsonschema

SPECS = pathlib.Path(__file__).resolve().parents[2] / "specs"
SCHEMA = jsonschema.Draft202012Validator(json.loads((SPECS / "atlas.schema.json").read_text()))
ALLOWED = {
    ("rgb32f", "exr"): "rgb32f",
    ("rgb32f", "ktx2"): "rgba32f",
    ("rgb32f", "dds"): "rgba32f",
    ("rgba16f", "exr"): "rgba16f",
    ("rgba16f", "ktx2"): "rgba16f",
    ("e5b9g9r9", "ktx2"): "e5b9g9r9",
    ("e5b9g9r9", "dds"): "e5b9g9r9",
}
TEXEL_BYTES = {"rgb32f": 12, "rgba32f": 16, "rgba16f": 8, "e5b9g9r9": 4}
VULKAN = {"rgba16f": 97, "rgba32f": 109, "e5b9g9r9": 123}
DXGI = {"rgba32f": 2, "e5b9g9r9": 67}
PAIRS = "theta_i,phi_i,theta_v,phi_v\n" + "".join(
    f"{t},{p},{v},{q}\n" for t in (0, 12, 60, 90) for p in (0, 100) for v in (0, 30, 75, 91) for q in (10, 200)
)


def call(*arguments, text=None, most_bytes=None):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    return subprocess.run(
        [str(a) for a in arguments],
        input=text,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        restore_signals=False,
        preexec_fn=limit if most_bytes is not None else None,
    )


def run(*arguments, text=None):
    done = call(*arguments, text=text)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def content(folder):
    return {path.name: path.read_bytes() if path.is_file() else None for path in folder.iterdir()}


def refused(folder, code, says, *arguments, most_bytes=None):
    """The program fails with the code, says why in one line, and leaves the folder as it was."""
    before = content(folder)
    done = call(*arguments, most_bytes=most_bytes)
    assert done.returncode == code, (arguments, done.returncode, done.stderr)
    words = (says,) if isinstance(says, str) else says
    assert all(word in done.stderr for word in words), (arguments, done.stderr)
    assert done.stderr.count("\n") == 1 and done.stdout == "", (arguments, done.stdout, done.stderr)
    after = content(folder)
    assert after == before, (arguments, sorted(after.keys() ^ before.keys()))


# ---- Headers of textures ---------------------------------------------------------------------------------------------


def ktx2_header(data):
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    vulkan, _, width, height, depth, layers, faces, levels, scheme = struct.unpack_from("<9I", data, 12)
    assert (depth, layers, faces, levels) == (0, 0, 1, 1)
    offset, size, whole = struct.unpack_from("<3Q", data, 80)
    assert offset + size == len(data), "the level ends the file"
    texel = next(name for name, number in VULKAN.items() if number == vulkan)
    return {"texel": texel, "width": width, "height": height, "zstd": scheme == 2, "texel_bytes": whole}


def dds_header(data):
    assert data[:4] == b"DDS " and data[84:88] == b"DX10"
    height, width = struct.unpack_from("<2I", data, 12)
    texel = next(name for name, number in DXGI.items() if number == struct.unpack_from("<I", data, 128)[0])
    return {"texel": texel, "width": width, "height": height, "zstd": False, "texel_bytes": len(data) - 148}


def exr_header(data):
    assert data[:4] == b"\x76\x2f\x31\x01"
    at, attributes = 8, {}
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        kind_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<I", data, kind_end + 1)
        attributes[data[at:name_end].decode()] = data[kind_end + 5 : kind_end + 5 + size]
        at = kind_end + 5 + size
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    assert (left, top) == (0, 0)
    channels, at = {}, 0
    while attributes["channels"][at] != 0:
        end = attributes["channels"].index(b"\0", at)
        channels[attributes["channels"][at:end].decode()] = struct.unpack_from("<I", attributes["channels"], end + 1)[0]
        at = end + 17
    assert {"R", "G", "B"} <= set(channels) <= {"R", "G", "B", "A"} and len(set(channels.values())) == 1, channels
    texel = "rgba16f" if channels["R"] == 1 else "rgb32f"
    count = (right + 1) * (bottom + 1)
    size = count * TEXEL_BYTES[texel]
    return {"texel": texel, "width": right + 1, "height": bottom + 1, "zstd": False, "texel_bytes": size}


READERS = {"ktx2": ktx2_header, "dds": dds_header, "exr": exr_header}


# ---- What is written -------------------------------------------------------------------------------------------------


def check_report(report, folder, prefix, container, zstd):
    names = [f"{prefix}.{container}", f"{prefix}.glsl", f"{prefix}.json"]
    assert [pathlib.Path(path) for path in report["files"]] == [folder / name for name in names], report["files"]
    manifest = json.loads((folder / names[2]).read_text())
    SCHEMA.validate(manifest)
    header = READERS[container]((folder / names[0]).read_bytes())
    assert header["zstd"] == zstd
    for where in (report, manifest["texture"]):
        assert {key: where[key] for key in ("texel", "width", "height")} == {
            key: header[key] for key in ("texel", "width", "height")
        }, (where, header)
        assert where["bytes"] == (folder / names[0]).stat().st_size
    assert report["texel"] == ALLOWED[report["asked"], container] and report["container"] == container
    assert report["texels"] == header["width"] * header["height"]
    assert report["texel_bytes"] == header["texel_bytes"] == report["texels"] * TEXEL_BYTES[report["texel"]]
    assert manifest["texture"]["file"] == names[0] and manifest["shader"] == names[1]
    assert manifest["errors"] == report["errors"]
    assert "sbrdf_eval" in (folder / names[1]).read_text()
    assert report["mre_percent"] == report["errors"]["to_source"]["mre_percent"]
    assert report["rel_l1_percent"] == report["errors"]["to_source"]["rel_l1_percent"]
    worst = max(report["errors"]["to_slices"][key] for key in ("mre_percent", "rel_l1_percent"))
    assert report["reached"] == (worst <= report["max_error_percent"]), report


def check_errors(program, source, report, manifest):
    """Two draws of directions around highlights."""
    arguments = ("--directions", "highlight", "--count", "100000", "--json", "--theta-max", "80")
    measured = json.loads(run(program, "compare", source, manifest, *arguments))
    for key in ("mre_percent", "rel_l1_percent"):
        ratio = measured[key] / report[key]
        assert 0.8 < ratio < 1.25, (key, measured[key], report[key])
    return measured


def values(program, file):
    rows = run(program, "eval", file, text=PAIRS).strip().split("\n")
    assert rows[0].split(",")[4:] == ["R", "G", "B"], rows[0]
    return [[float(field) for field in row.split(",")] for row in rows[1:]]


def check_pairs(program, folder, sliced):
    seen = {}
    for (texel, container), stored in ALLOWED.items():
        prefix = f"{texel}-{container}"
        out = folder / prefix
        for zstd in (False, True) if container == "ktx2" else (False,):
            options = ("--texel", texel, "--container", container, "--max-error", "3", "--json")
            report = json.loads(run(program, "atlas", sliced, out, *options, *(("--zstd",) if zstd else ())))
            report["asked"] = texel
            check_report(report, folder, prefix, container, zstd)
        manifest = f"{out}.json"
        check_errors(program, sliced, report, manifest)
        info = run(program, "info", manifest)
        assert f"{report['width']} x {report['height']} texels, {stored}" in info and "R, G, B" in info, info
        rows = values(program, manifest)
        assert all(row[4:] == [0, 0, 0] for row in rows if row[2] > 90), "0 below the horizon"
        seen.setdefault((stored, report["width"], report["height"]), rows)
        assert seen[stored, report["width"], report["height"]] == rows, f"the same texels in another file: {prefix}"
    for texel in ("rgb32f", "rgba16f", "e5b9g9r9"):
        for container in ("exr", "ktx2", "dds"):
            if (texel, container) not in ALLOWED:
                options = ("--texel", texel, "--container", container)
                refused(folder, 1, f"--container {container}", program, "atlas", sliced, folder / "not", *options)
            elif container != "ktx2":
                options = ("--texel", texel, "--container", container, "--zstd")
                refused(folder, 1, "--zstd is for --container ktx2", program, "atlas", sliced, folder / "not", *options)
    for option in (("--texel", "rgb8"), ("--container", "png"), ("--max-error", "0"), ("--samples", "0")):
        done = call(program, "atlas", sliced, folder / "not", *option)
        assert done.returncode == 1 and option[0] in done.stderr, (option, done.stderr)


def check_conversions(program, folder, sliced):
    manifest = folder / "rgb32f-exr.json"
    for kind, most in (("binary", 2), ("sbrdf", 8)):
        for source, name in ((manifest, f"of_atlas.{kind}"), (sliced, f"of_slices.{kind}")):
            run(program, "convert", source, folder / name, *(("--samples", "600") if kind == "sbrdf" else ()))
        pair = (folder / f"of_slices.{kind}", folder / f"of_atlas.{kind}")
        measured = json.loads(run(program, "compare", *pair, "--step", "15", "--json"))
        assert measured["rel_l1_percent"] < most, (kind, measured["rel_l1_percent"])
        for path in pair:
            path.unlink()
    # An atlas of an atlas, and of a model that has no slices yet.
    run(program, "atlas", manifest, folder / "again", "--samples", "300", "--max-error", "10")
    report = json.loads(
        run(program, "atlas", "kurt:wood01", folder / "wood", "--samples", "400", "--max-error", "5", "--json")
    )
    assert report["mre_percent"] > report["errors"]["to_slices"]["mre_percent"], "slices have an error of their own"
    check_errors(program, "kurt:wood01", report, folder / "wood.json")
    # As few texels as reach the error; of the rest the report says that it is not reached.
    coarse = json.loads(run(program, "atlas", sliced, folder / "coarse", "--max-error", "20", "--json"))
    fine = json.loads(run(program, "atlas", sliced, folder / "fine", "--max-error", "0.001", "--json"))
    assert coarse["reached"] and not fine["reached"] and coarse["texels"] < fine["texels"]
    assert fine["errors"]["to_slices"]["mre_percent"] < coarse["errors"]["to_slices"]["mre_percent"]
    # The same input gives the same files.
    before = content(folder)
    run(program, "atlas", sliced, folder / "coarse", "--max-error", "20")
    assert content(folder) == before, "a rerun replaces its own files by the same"


def members(json_value, path=()):
    """Every member of every object, the first one of a list for all."""
    if isinstance(json_value, list):
        json_value = dict(enumerate(json_value[:1]))
    elif isinstance(json_value, dict):
        yield from ((path, key) for key in json_value)
    else:
        return
    for key, value in json_value.items():
        yield from members(value, (*path, key))


def check_schema(program, folder, sliced):
    """The schema describes all that is written, and nothing that the program would not read."""
    run(program, "atlas", "kurt:wood01", folder / "paper", "--layout", "paper")
    run(program, "atlas", sliced, folder / "part", "--theta-max", "30", "--max-error", "5")
    run(program, "atlas", sliced, folder / "blocks", "--texel", "bc6h", "--fast", "--max-error", "10")
    optional = {"first_row", "filter", "colour_space", "texels_crc32", "rows_wrap", "ring", "dense_along", "cells"}
    optional |= {"clamped_texels", "errors", "source", "tiles", "texels", "azimuth_step_deg", "theta_max_deg"}
    for prefix in ("paper", "part", "blocks", "coarse"):
        manifest = json.loads((folder / f"{prefix}.json").read_text())
        SCHEMA.validate(manifest)
        for path, key in members(manifest):
            less = json.loads(json.dumps(manifest))
            at = less
            for step in path:
                at = at[step]
            kept = at.pop(key)
            assert key in optional or not SCHEMA.is_valid(less), (prefix, path, key, "may be left out")
            at[key] = kept
            at["unheard_of"] = 1
            assert not SCHEMA.is_valid(less), (prefix, path, "may have any member")
            del at["unheard_of"]
        for path in folder.glob(f"{prefix}*"):
            if prefix != "coarse":
                path.unlink()


# ---- What is refused -------------------------------------------------------------------------------------------------


def check_bad_atlases(program, folder):
    """Manifests and textures that are not what they should be."""
    manifest, texture = folder / "coarse.json", folder / "coarse.ktx2"
    kept = {path: path.read_bytes() for path in (manifest, texture)}

    def with_files(says, code=3, **files):
        for path, data in kept.items():
            path.unlink(missing_ok=True)
            data = files.get(path.suffix[1:], data)
            if data is not None:
                path.write_bytes(data)
        refused(folder, code, says, program, "compare", "kurt:wood01", manifest, "--random", "10")
        refused(folder, code, says, program, "info", manifest)
        for path, data in kept.items():
            path.write_bytes(data)

    def changed(place, value):
        whole = json.loads(kept[manifest])
        at = whole
        for key in place[:-1]:
            at = at[key]
        at[place[-1]] = value
        return json.dumps(whole, separators=(",", ":")).encode()

    data = kept[texture]
    with_files(("coarse.ktx2", "not in its folder"), code=2, ktx2=None)
    for size in (0, 3, 50, 200, len(data) // 2, len(data) - 1):
        with_files("the texture coarse.ktx2", ktx2=data[:size])
    with_files(("the texture coarse.ktx2 has", "and the manifest says"), ktx2=(folder / "fine.ktx2").read_bytes())
    with_files("the texture coarse.ktx2", ktx2=b"no texture at all, but of some length" * 10)
    for size in (len('{"sbrdf":"atlas"'), 100, len(kept[manifest]) // 2, len(kept[manifest]) - 3):
        with_files("is no JSON", json=kept[manifest][:size])
    for name in ("../coarse.ktx2", str(texture), "sub/coarse.ktx2", ".."):
        with_files("'file' is no plain file name", json=changed(("texture", "file"), name))
    with_files("'version' is not 1", json=changed(("version",), 2))
    with_files("'nodes_deg'", json=changed(("frame", "axes", 1, "nodes_deg", 1), -3))
    with_files("is nested too deeply", json=kept[manifest][:-2] + b',"x":' + b"[" * 100000 + b"]" * 100000 + b"}")
    link = folder / "loop.ktx2"
    link.symlink_to("loop.ktx2")
    with_files("not in its folder", code=2, json=changed(("texture", "file"), "loop.ktx2"))
    link.unlink()


def check_bad_outputs(program, folder, sliced):
    atlas = (program, "atlas", sliced)
    refused(folder, 2, "cannot be used", *atlas, folder / "missing" / "a")
    refused(folder, 1, "OUT_PREFIX", *atlas, f"{folder}/")
    for name in ("theirs.json", "theirs.ktx2", "theirs.glsl"):
        (folder / name).write_text('{"mine": true}')
        refused(folder, 1, (name, "is of no atlas"), *atlas, folder / "theirs")
        (folder / name).unlink()
        (folder / name).mkdir()
        refused(folder, 2, (name, "directory"), *atlas, folder / "theirs")
        (folder / name).rmdir()
    # Inputs are not replaced: neither the manifest nor the texture that belongs to it.
    refused(folder, 1, ("coarse.ktx2", "is an input"), program, "atlas", folder / "coarse.json", folder / "coarse")
    moved = json.loads((folder / "coarse.json").read_text())
    (folder / "moved.json").write_text(json.dumps(moved, separators=(",", ":")))
    (folder / "coarse.json").rename(folder / "kept")
    refused(folder, 1, "coarse.ktx2", program, "atlas", folder / "moved.json", folder / "coarse")
    (folder / "kept").rename(folder / "coarse.json")
    (folder / "moved.json").unlink()
    shutil.copy(sliced, folder / "in.glsl")
    refused(folder, 1, ("in.glsl", "is an input"), program, "atlas", folder / "in.glsl", folder / "in")
    (folder / "in.glsl").unlink()
    # Names that JSON cannot hold.
    refused(folder, 1, "UTF-8", program, "atlas", sliced, str(folder) + "/caf\udce9")
    # A disk that is full, at first and when most is written; before and after there is an atlas of that name.
    for prefix in ("full", "coarse"):
        for most_bytes in (0, 1000, 9000, (folder / "coarse.ktx2").stat().st_size - 1):
            refused(folder, 2, "cannot be written", *atlas, folder / prefix, "--max-error", "20", most_bytes=most_bytes)


def check_other_channels(program, folder):
    angles = [(t, v, p) for t in (0, 40, 80) for v in (0, 40, 80) for p in (0, 90, 180, 270)]
    four = folder / "four.csv"
    rows = "".join(f"{t},0,{v},{p},1,2,3,{t + v}\n" for t, v, p in angles)
    four.write_text("theta_i,phi_i,theta_v,phi_v,a,b,c,d\n" + rows)
    refused(folder, 4, "textures hold three channels, and this material has 4", program, "atlas", four, folder / "not")
    refused(folder, 2, "nowhere.sbrdf", program, "atlas", folder / "nowhere.sbrdf", folder / "not")
    refused(folder, 1, "kurt:nobody", program, "atlas", "kurt:nobody", folder / "not")
    one = folder / "one.csv"
    rows = "".join(f"{t},0,{v},{p},{1 + t / 80}\n" for t, v, p in angles)
    one.write_text("theta_i,phi_i,theta_v,phi_v,f\n" + rows)
    run(program, "atlas", one, folder / "one", "--samples", "300", "--max-error", "5")
    rows = values(program, folder / "one.json")
    assert all(row[4] == row[5] == row[6] for row in rows), "one channel is grey"


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        sliced = folder / "wood01.sbrdf"
        run(program, "convert", "kurt:wood01", sliced, "--samples", "600")
        check_pairs(program, folder, sliced)
        check_conversions(program, folder, sliced)
        check_schema(program, folder, sliced)
        check_bad_atlases(program, folder)
        check_bad_outputs(program, folder, sliced)
        check_other_channels(program, folder)
    print("atlases are what their manifests and reports say, and bad ones are refused")
    return 0


if __name__ == "__main__":
    sys.exit(main())
