#!/usr/bin/env python3
"""Textures as others read them. KTX2 and DDS files go through readers that are written here from the specifications alone,
field by field; BC6H in DDS and EXR through oiiotool; KTX2, DDS and EXR through ktx-parse and three.js where node and the
folder that SBRDF_NODE_MODULES names have them; KTX2 through `ktx validate` where it is installed.

usage: check_textures.py CONVERT_TEXTURE

Without numpy or zstandard nothing is checked, and the exit code is 77.
"""
import base64
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import zstandard
except ImportError as missing:
    print(missing)
    sys.exit(77)

WIDTH, HEIGHT = 36, 20
KTX2_FORMATS = ("rgba16f", "rgba32f", "e5b9g9r9", "bc6h", "bc6h-signed")


def run(*arguments, code=0):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, check=False)
    assert done.returncode == code, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout if code == 0 else done.stderr


# ---- Texels ----------------------------------------------------------------------------------------------------------


def colours(draw, sign):
    """Values of all sizes; some too large, some too small, some below 0."""
    rgb = np.exp2(draw.uniform(-30, 17, (HEIGHT, WIDTH, 1))) * draw.uniform(0, 1, (HEIGHT, WIDTH, 3)) ** 3
    rgb[draw.uniform(size=rgb.shape) < 0.05] = 0
    rgb[0, :4] = [[65504, 65520, 1e30], [65408, 65409, 65472], [511.5, 511.75, 511.25], [2.0**-25, 2.0**-24, 2.0**-26]]
    return (rgb * np.where(draw.uniform(size=rgb.shape) < 0.1, -1, 1) if sign else rgb).astype("<f4")


def with_alpha(rgb, kind):
    return np.concatenate([rgb, np.ones((HEIGHT, WIDTH, 1))], axis=2).astype(kind)


def shared_exponent(rgb):
    """EXT_texture_shared_exponent: "how to convert floating-point to shared exponent"."""
    rgb = np.clip(rgb.astype(float), 0, 511 / 512 * 2.0**16)
    largest = rgb.max(axis=2)
    with np.errstate(divide="ignore"):
        before = np.maximum(-16, np.floor(np.log2(largest))) + 1 + 15
    exponent = before + (np.floor(largest / np.exp2(before - 24) + 0.5) == 512)
    mantissas = np.floor(rgb / np.exp2(exponent - 24)[..., None] + 0.5).astype("<u4")
    return mantissas[..., 0] | mantissas[..., 1] << 9 | mantissas[..., 2] << 18 | exponent.astype("<u4") << 27


def from_shared_exponent(texels):
    mantissas = np.stack([texels & 511, texels >> 9 & 511, texels >> 18 & 511], axis=-1)
    return (mantissas * np.exp2((texels >> 27).astype(float) - 24)[..., None]).astype("<f4")


def expected_texels(name, rgb):
    if name == "rgba32f":
        return with_alpha(rgb, "<f4")
    if name == "rgba16f":
        return with_alpha(np.clip(rgb, -65504, 65504), "<f2")
    return shared_exponent(rgb)


# ---- BC6H blocks of known content ------------------------------------------------------------------------------------

WEIGHTS = np.array([0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64])


def bc6h_block(ends, indices):
    """The mode with ten bits for each channel of two ends, and four for each texel's place between them."""
    bits, at = 3, 5
    for end in ends:
        for channel in end:
            bits |= (int(channel) & 1023) << at
            at += 10
    for k, index in enumerate(indices):
        bits |= int(index) << at
        at += 3 if k == 0 else 4
    assert at == 128
    return bits.to_bytes(16, "little")


def bc6h_halves(ends, indices, sign):
    """Microsoft, "BC6H Format": the halves of 4 x 4 texels."""
    ends = ends.astype(int)
    if sign:
        size = np.abs(ends)
        full = np.where(size >= 511, 0x7FFF, np.where(size == 0, 0, ((size << 15) + 0x4000) >> 9)) * np.sign(ends)
    else:
        full = np.where(ends == 0, 0, np.where(ends == 1023, 0xFFFF, ((ends << 16) + 0x8000) >> 10))
    weights = WEIGHTS[indices][:, None]
    mixed = (full[0] * (64 - weights) + full[1] * weights + 32) >> 6
    halves = (np.abs(mixed) * 31 >> 5) | np.where(mixed < 0, 0x8000, 0) if sign else mixed * 31 >> 6
    return halves.astype("<u2").reshape(4, 4, 3)


def bc6h_texture(draw, sign):
    blocks, halves = b"", np.zeros((HEIGHT, WIDTH, 3), "<u2")
    for y in range(0, HEIGHT, 4):
        for x in range(0, WIDTH, 4):
            ends = draw.integers(-511, 512, (2, 3)) if sign else draw.integers(0, 1024, (2, 3))
            indices = draw.integers(0, 16, 16)
            indices[0] &= 7
            blocks += bc6h_block(ends, indices)
            halves[y : y + 4, x : x + 4] = bc6h_halves(ends, indices, sign)
    return blocks, halves


# ---- KTX 2.0 and the Khronos Data Format Specification 1.3 -----------------------------------------------------------

VK_FORMAT = {"rgba16f": 97, "rgba32f": 109, "e5b9g9r9": 123, "bc6h": 143, "bc6h-signed": 144}
TYPE_SIZE = {"rgba16f": 2, "rgba32f": 4, "e5b9g9r9": 4, "bc6h": 1, "bc6h-signed": 1}
BLOCK = {"rgba16f": 8, "rgba32f": 16, "e5b9g9r9": 4, "bc6h": 16, "bc6h-signed": 16}
FLOAT, SIGNED, EXPONENT = 0x80, 0x40, 0x20
ONE, MINUS_ONE = 0x3F800000, 0xBF800000
SAMPLES = {  # bit offset, bits, channel with qualifiers, lower, upper
    "rgba16f": [(16 * k, 16, c | FLOAT | SIGNED, MINUS_ONE, ONE) for k, c in enumerate((0, 1, 2, 15))],
    "rgba32f": [(32 * k, 32, c | FLOAT | SIGNED, MINUS_ONE, ONE) for k, c in enumerate((0, 1, 2, 15))],
    "e5b9g9r9": [(0, 9, 0, 0, 8448), (27, 5, EXPONENT, 15, 31), (9, 9, 1, 0, 8448), (27, 5, 1 | EXPONENT, 15, 31),
                 (18, 9, 2, 0, 8448), (27, 5, 2 | EXPONENT, 15, 31)],
    "bc6h": [(0, 128, FLOAT, 0, ONE)],
    "bc6h-signed": [(0, 128, FLOAT | SIGNED, MINUS_ONE, ONE)],
}


def check_descriptor(name, descriptor):
    total, vendor, version, model, sides, planes_low, planes_high = struct.unpack_from("<7I", descriptor)
    samples = SAMPLES[name]
    assert total == len(descriptor) == 4 + 24 + 16 * len(samples)
    assert vendor == 0 and version == 2 | (total - 4) << 16
    blocks = name.startswith("bc6h")
    assert model == (133 if blocks else 1) | 1 << 8 | 1 << 16  # BT.709, linear, straight alpha
    assert sides == (0x0303 if blocks else 0)
    assert (planes_low, planes_high) == (BLOCK[name], 0)
    for k, (offset, bits, channel, lower, upper) in enumerate(samples):
        found = struct.unpack_from("<HBB4B2I", descriptor, 28 + 16 * k)
        assert found == (offset, bits - 1, channel, 0, 0, 0, 0, lower, upper), (name, k, found)


def key_values(content, start):
    found, at = [], 0
    while at < len(content):
        (size,) = struct.unpack_from("<I", content, at)
        key, value = content[at + 4 : at + 4 + size].split(b"\0", 1)
        end = at + 4 + size
        assert not any(content[end : end + -(start + end) % 4])
        found.append((key.decode(), value))
        at = end + -(start + end) % 4
    assert at == len(content)
    assert [key for key, _ in found] == sorted(key for key, _ in found)
    return dict(found)


def read_ktx2(name, content, zstd, keys):
    """The texels, after everything before them has been compared with what the specification asks for."""
    assert content[:12] == bytes([0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A])
    vk, size, width, height, depth, layers, faces, levels, scheme = struct.unpack_from("<9I", content, 12)
    assert (vk, size, width, height) == (VK_FORMAT[name], TYPE_SIZE[name], WIDTH, HEIGHT)
    assert (depth, layers, faces, levels, scheme) == (0, 0, 1, 1, 2 if zstd else 0)
    dfd_offset, dfd_size, kvd_offset, kvd_size, sgd_offset, sgd_size = struct.unpack_from("<4I2Q", content, 48)
    offset, size, unpacked = struct.unpack_from("<3Q", content, 80)
    assert dfd_offset == 80 + 24 and kvd_offset == dfd_offset + dfd_size and (sgd_offset, sgd_size) == (0, 0)
    check_descriptor(name, content[dfd_offset : dfd_offset + dfd_size])
    found = key_values(content[kvd_offset : kvd_offset + kvd_size], kvd_offset)
    expected = {"KTXorientation": b"rd\0", "KTXwriter": b"sbrdf\0"}
    assert found == expected | {key: text.encode() + b"\0" for key, text in keys.items()}, found
    end = kvd_offset + kvd_size
    alignment = 1 if zstd else max(BLOCK[name], 4)  # powers of two: the least common multiple is the larger one
    assert offset % alignment == 0 and end <= offset < end + alignment and not any(content[end:offset])
    assert offset + size == len(content)
    level = content[offset:]
    if zstd:
        assert zstandard.frame_content_size(level) == unpacked
        level = zstandard.ZstdDecompressor().decompress(level)
    assert len(level) == unpacked == WIDTH * HEIGHT * BLOCK[name] // (16 if name.startswith("bc6h") else 1)
    return level


# ---- DDS with the DX10 header ----------------------------------------------------------------------------------------

DXGI = {"rgba32f": 2, "e5b9g9r9": 67, "bc6h": 95, "bc6h-signed": 96}


def read_dds(name, content):
    magic, size, flags, height, width, pitch, depth, levels = struct.unpack_from("<4s7I", content)
    blocks = name.startswith("bc6h")
    level = content[148:]
    assert (magic, size, height, width, depth, levels) == (b"DDS ", 124, HEIGHT, WIDTH, 0, 1)
    assert flags == 0x1007 | 0x20000 | (0x80000 if blocks else 0x8)
    assert pitch == (len(level) if blocks else WIDTH * BLOCK[name])
    assert not any(content[32:76])
    assert struct.unpack_from("<2I4s5I", content, 76) == (32, 4, b"DX10", 0, 0, 0, 0, 0)
    assert struct.unpack_from("<5I", content, 108) == (0x1000, 0, 0, 0, 0)
    assert struct.unpack_from("<5I", content, 128) == (DXGI[name], 3, 0, 1, 0)
    return level


# ---- EXR -------------------------------------------------------------------------------------------------------------


def plain_exr(path, kind):
    """R, G, B of an image in scan lines without compression: the file ends with its lines, channels by name."""
    size = 8 + 3 * WIDTH * np.dtype(kind).itemsize
    lines = np.frombuffer(path.read_bytes()[-HEIGHT * size :], "u1").reshape(HEIGHT, size)[:, 8:]
    return np.ascontiguousarray(lines).view(kind).reshape(HEIGHT, 3, WIDTH).transpose(0, 2, 1)[:, :, ::-1]


def seen_by_oiiotool(path, kind):
    plain = path.with_suffix(".plain.exr")
    run("oiiotool", path, "-d", "half" if kind != "<f4" else "float", "--compression", "none", "-o", plain)
    return plain_exr(plain, kind)


# ---- Checks ----------------------------------------------------------------------------------------------------------


def check_texels(program, folder, draw):
    """Texels are those of numpy, and what is said of them is true."""
    made = {}
    for name in ("rgba16f", "rgba32f", "e5b9g9r9"):
        rgb = colours(draw, sign=True)
        (folder / "in.rgb").write_bytes(rgb.tobytes())
        clamped, negative = map(int, run(program, "write", name, WIDTH, HEIGHT, folder / "in.rgb",
                                         folder / f"{name}.texels").split())
        made[name] = (folder / f"{name}.texels").read_bytes()
        expected = expected_texels(name, rgb)
        assert made[name] == expected.tobytes(), name
        largest = {"rgba16f": 65504, "rgba32f": np.inf, "e5b9g9r9": 65408}[name]
        below = rgb < 0 if name == "e5b9g9r9" else np.zeros(rgb.shape, bool)
        assert clamped == ((np.abs(rgb) > largest) & ~below).sum() and negative == below.sum()
        if name == "e5b9g9r9":
            run(program, "write", name, WIDTH, HEIGHT, folder / "e5b9g9r9.texels", folder / "e.ktx2")
            run(program, "read", folder / "e.ktx2", folder / "out.rgb")
            assert (folder / "out.rgb").read_bytes() == from_shared_exponent(expected).tobytes()
    print("texels are those of numpy, and so are the counts of what did not fit")
    return made


def check_ktx2(program, folder, made):
    files = []
    texts = ("", "abcd", "abcdefgh", "abcdefghijkl")  # texels then begin behind padding of every length
    variants = [(False, {}), *((False, {"key": text}) for text in texts), (True, {}),
                (True, {"zebra": "z", "Alpha": "is 1", "unicode": "\u03b8"})]
    for name in KTX2_FORMATS:
        for k, (zstd, keys) in enumerate(variants):
            path = folder / f"{name}.{k}{'.zstd' if zstd else ''}.ktx2"
            run(program, "write", name, WIDTH, HEIGHT, folder / f"{name}.texels", path,
                *(f"{key}={text}" for key, text in keys.items()))
            assert read_ktx2(name, path.read_bytes(), zstd, keys) == made[name], path
            assert run(program, "read", path, folder / "back.texels") == f"{name} {WIDTH} {HEIGHT}\n"
            assert (folder / "back.texels").read_bytes() == made[name]
            files.append(path)
    error = run(program, "write", "rgb32f", WIDTH, HEIGHT, folder / "in.rgb", folder / "x.ktx2", code=4)
    assert "rgba32f" in error
    print(f"KTX2: every field of {len(files)} files is as specified")
    return files


def check_dds(program, folder, made, halves):
    files = []
    for name in DXGI:
        path = folder / f"{name}.dds"
        run(program, "write", name, WIDTH, HEIGHT, folder / f"{name}.texels", path)
        assert read_dds(name, path.read_bytes()) == made[name], path
        assert run(program, "read", path, folder / "back.texels") == f"{name} {WIDTH} {HEIGHT}\n"
        assert (folder / "back.texels").read_bytes() == made[name]
        files.append(path)
        if name in halves:
            assert np.array_equal(seen_by_oiiotool(path, "<u2"), halves[name]), f"oiiotool sees another {name}"
    assert "half" in run(program, "write", "rgba16f", WIDTH, HEIGHT, folder / "rgba16f.texels", folder / "x.dds", code=4)
    print("DDS: every field is as specified; oiiotool sees the BC6H texels that were put in, bit for bit")
    return files


def check_exr(program, folder, draw):
    rgb = colours(draw, sign=True)
    (folder / "in.rgb").write_bytes(rgb.tobytes())
    expected = {"rgb32f": rgb, "rgba32f": rgb, "rgba16f": np.clip(rgb, -65504, 65504).astype("<f2")}
    files = {}
    for name, values in expected.items():
        path = folder / f"{name}.{'half' if name == 'rgba16f' else 'float'}.exr"
        run(program, "write", name, WIDTH, HEIGHT, folder / "in.rgb", path)
        seen = seen_by_oiiotool(path, values.dtype.str)
        assert seen.tobytes() == values.tobytes(), name
        header = run("exrheader", path)
        assert "zip" in header and f"(0 0) - ({WIDTH - 1} {HEIGHT - 1})" in header, header
        # And an image that another program wrote.
        run("oiiotool", path, "--eraseattrib", ".*", "--compression", "piz", "-o", folder / "other.exr")
        back = "rgb32f" if name == "rgba32f" else name
        assert run(program, "read", folder / "other.exr", folder / "back.rgb") == f"{back} {WIDTH} {HEIGHT}\n"
        assert (folder / "back.rgb").read_bytes() == values.astype("<f4").tobytes()
        files[path] = values
    print("EXR: oiiotool sees the texels bit for bit, and what it writes is read")
    return files


def check_with_node(ktx2_files, dds_files, exr_files, made):
    modules = os.environ.get("SBRDF_NODE_MODULES", "")
    needed = [pathlib.Path(modules) / name for name in ("ktx-parse", "three")]
    if not shutil.which("node") or not modules or not all(path.is_dir() for path in needed):
        print("SKIPPED: ktx-parse and three.js; set SBRDF_NODE_MODULES to a folder that has both")
        return
    script = pathlib.Path(__file__).with_name("read_textures.mjs")
    lines = run("node", script, modules, *ktx2_files, *dds_files, *exr_files).splitlines()
    loaded = 0
    for line in lines:
        answer = json.loads(line)
        path = pathlib.Path(answer["file"])
        name = path.name.split(".")[0]
        if "parsed" in answer:
            check_parsed(name, answer["parsed"], path, made[name])
        if "three" not in answer:
            # What three.js does not take: raw BC6H in KTX2, and other DDS than BC6H.
            assert (path.suffix == ".ktx2") == name.startswith("bc6h") and path.suffix != ".exr", answer["refused"]
            continue
        found = answer["three"]
        assert (found["width"], found["height"]) == (WIDTH, HEIGHT), found
        texels = base64.b64decode(found["texels"])
        if path.suffix == ".exr":  # rows from below, with an alpha of 1
            values = exr_files[path]
            assert texels == with_alpha(values[::-1], values.dtype).tobytes(), path
        else:
            assert found["format"] == name and texels == made[name], path
        loaded += 1
    print(f"ktx-parse reads all {len(ktx2_files)} KTX2 files, and three.js {loaded} of {len(lines)} files, bit for bit")


def check_parsed(name, parsed, path, texels):
    zstd = ".zstd." in path.name
    assert (parsed["vkFormat"], parsed["typeSize"]) == (VK_FORMAT[name], TYPE_SIZE[name])
    assert (parsed["pixelWidth"], parsed["pixelHeight"], parsed["levelCount"]) == (WIDTH, HEIGHT, 1)
    keys = [key for key, _ in parsed["keyValue"]]
    assert keys == sorted(keys) and dict(parsed["keyValue"])["KTXorientation"] == "rd"
    (descriptor,) = parsed["dataFormatDescriptor"]
    assert len(descriptor["samples"]) == len(SAMPLES[name]) and descriptor["bytesPlane"][0] == BLOCK[name]
    (level,) = parsed["levels"]
    content = base64.b64decode(level["levelData"])
    assert (zstandard.ZstdDecompressor().decompress(content) if zstd else content) == texels


def check_with_ktx(files):
    if not shutil.which("ktx"):
        print("SKIPPED: `ktx validate`, which is not installed")
        return
    for path in files:
        run("ktx", "validate", "--warnings-as-errors", path)
    print("`ktx validate` has no objection")


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 1
    program = pathlib.Path(sys.argv[1]).resolve()
    draw = np.random.default_rng(20)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made, halves = check_texels(program, folder, draw), {}
        for kind in ("bc6h", "bc6h-signed"):
            made[kind], halves[kind] = bc6h_texture(draw, kind == "bc6h-signed")
            (folder / f"{kind}.texels").write_bytes(made[kind])
        ktx2_files = check_ktx2(program, folder, made)
        dds_files = check_dds(program, folder, made, halves)
        exr_files = check_exr(program, folder, draw)
        check_with_node(ktx2_files, dds_files, exr_files, made)
        check_with_ktx(ktx2_files)
    return 0


if __name__ == "__main__":
    sys.exit(main())
