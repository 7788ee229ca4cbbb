#!/usr/bin/env python3
"""OpenImageIO and our decoder make the same halves, bit by bit, of 100,000 random BC6H blocks of every mode, the reserved
ones included, unsigned and signed.

usage: check_bc6h.py DUMP_BC6H [BLOCKS]

Exit code 77 where oiiotool is missing.
"""
import array
import collections
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile

SKIPPED = 77
ACROSS = 400  # blocks in a row of the image
DXGI_FORMATS = {"unsigned": 95, "signed": 96}  # BC6H_UF16, BC6H_SF16
TWO_BIT_MODES = (0, 1)
FIVE_BIT_MODES = (2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15)
RESERVED_MODES = (19, 23, 27, 31)


def random_block(draw):
    """A mode, and 16 bytes that have it; now and then with all other bits 0 or 1, where special cases lie."""
    mode = draw.choice(TWO_BIT_MODES + FIVE_BIT_MODES + RESERVED_MODES)
    kind = draw.random()
    bits = 0 if kind < 0.01 else (1 << 128) - 1 if kind < 0.02 else draw.getrandbits(128)
    if kind > 0.9:  # a few bits set or cleared: small numbers and extreme ones
        bits &= draw.getrandbits(128) & draw.getrandbits(128)
    elif kind > 0.8:
        bits |= draw.getrandbits(128) | draw.getrandbits(128)
    mask = 3 if mode in TWO_BIT_MODES else 31
    return mode, (bits & ~mask | mode).to_bytes(16, "little")


def dds(kind, height, blocks):
    """A DDS file with the DX10 header: one image, no smaller ones."""
    width, size = 4 * ACROSS, len(blocks)
    header = struct.pack("<7I44x", 124, 0x81007, height, width, size, 0, 0)  # caps, height, width, format, linear size
    pixel_format = struct.pack("<2I4s20x", 32, 4, b"DX10")
    return (b"DDS " + header + pixel_format + struct.pack("<5I", 0x1000, 0, 0, 0, 0) +
            struct.pack("<5I", DXGI_FORMATS[kind], 3, 0, 1, 0) + blocks)


def halves_of_exr(path, height):
    """For each row the halves of R, G and B: the file is not compressed and ends with its rows, channels by name."""
    width = 4 * ACROSS
    row_size = 8 + 3 * 2 * width
    content = path.read_bytes()[-height * row_size:]
    for row in range(height):
        at = row * row_size
        assert struct.unpack_from("<2I", content, at) == (row, row_size - 8), "not a row of the image"
        halves = array.array("H", content[at + 8:at + row_size])
        yield halves[2 * width:], halves[width:2 * width], halves[:width]


def decoded_by_oiio(folder, kind, blocks):
    height = len(blocks) // 16 // ACROSS * 4
    (folder / "in.dds").write_bytes(dds(kind, height, blocks))
    subprocess.run(["oiiotool", folder / "in.dds", "-d", "half", "--compression", "none", "-o", folder / "out.exr"],
                   check=True)
    return halves_of_exr(folder / "out.exr", height)


def decoded_by_us(program, folder, kind, blocks):
    (folder / "blocks").write_bytes(blocks)
    subprocess.run([program, kind, folder / "blocks", folder / "halves"], check=True)
    return array.array("H", (folder / "halves").read_bytes())


def compare(program, folder, kind, modes, blocks):
    """The number of texels' channels that differ, by mode; and an example."""
    ours = decoded_by_us(program, folder, kind, blocks)
    differing, example = collections.Counter(), None
    for row, channels in enumerate(decoded_by_oiio(folder, kind, blocks)):
        first = row // 4 * ACROSS
        for channel, theirs in enumerate(channels):
            for x in range(4):
                start = first * 48 + (row % 4 * 4 + x) * 3 + channel
                mine = ours[start:start + 48 * ACROSS:48]
                if mine == theirs[x::4]:
                    continue
                for k, (a, b) in enumerate(zip(mine, theirs[x::4])):
                    if a != b:
                        differing[modes[first + k]] += 1
                        block = blocks[16 * (first + k):16 * (first + k + 1)]
                        example = example or f"{block.hex()}: texel {row % 4 * 4 + x}, channel {channel}: {a:#06x} {b:#06x}"
    return differing, example


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 1
    if not shutil.which("oiiotool"):
        print("skipped: no oiiotool")
        return SKIPPED
    count = int(sys.argv[2]) if len(sys.argv) == 3 else 100_000
    failed = False
    for kind in DXGI_FORMATS:
        draw = random.Random(f"bc6h {kind}")
        modes, blocks = zip(*(random_block(draw) for _ in range(count // ACROSS * ACROSS)))
        assert len(set(modes)) == 18
        with tempfile.TemporaryDirectory() as name:
            differing, example = compare(sys.argv[1], pathlib.Path(name), kind, modes, b"".join(blocks))
        print(f"{kind}: {len(blocks)} blocks; numbers that differ, by mode: {dict(differing) or 'none'}")
        if example:
            failed = True
            print(f"  {example}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
