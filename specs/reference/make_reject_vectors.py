#!/usr/bin/env python3
"""Files that break one rule of specs/sbrdf.md each, all checksums repaired around it.

usage: make_reject_vectors.py ACCEPT_FOLDER REJECT_FOLDER            writes those that are not there yet
       make_reject_vectors.py --check ACCEPT_FOLDER REJECT_FOLDER    exit code 1 unless all are as they are made here

Vectors are frozen: what the reject folder holds already is left as it is. A file's name begins with the rule that is
broken.
"""
import copy
import math
import pathlib
import struct
import sys
import zlib

import zstandard

from sbrdf_reference import DICTIONARY, MAGIC, Container, Index, IndexReader, payload_of
from sbrdfz_reference import count


def signed(value):
    return count(2 * value if value >= 0 else -2 * value - 1)


def f64(value):
    return struct.pack("<d", value)


def nodes(*degrees):
    return count(len(degrees)) + bytes([66]) + struct.pack(f"<{len(degrees)}d", *degrees)


# Written by an encoder that was given such a value in the guide of guide-lossless-split: a number that large is in its
# statistics as well, so that no change of a few fields makes these files.
BY_AN_ENCODER = {"SB-8-4-guide-inf", "SB-8-4-guide-nan"}


class Parts:
    """A file taken apart: the bytes of each field of the index by name, in order, and the payloads of its chunks."""

    def __init__(self, file):
        container = Container(file)
        self.minor = container.minor
        self.fields = {}
        self.reader = IndexReader(container.index)
        self.read_fields()
        self.payloads = []
        at = container.chunks_begin
        for size in self.sizes:
            self.payloads.append(payload_of(file[at:at + size]) if size else None)
            at += size

    def field(self, name, read):
        begin = self.reader.at
        value = read()
        self.fields[name] = self.reader.data[begin:self.reader.at]
        return value

    def read_fields(self):
        reader, field = self.reader, self.field

        field("frame", lambda: reader.number("B"))
        frame, isotropic = self.fields["frame"][0] & 15, self.fields["frame"][0] & 16
        for axis in range(4):
            stored = not (axis == 0 and isotropic or axis == 3 and frame == 1)
            field(f"axis {axis}", lambda: self.one_axis(reader) if stored else None)
        parts = field("parts", lambda: reader.number("B"))
        field("theta max", lambda: reader.count() if parts & 8 else None)
        self.mask = field("mask", lambda: self.read_mask(reader) if parts & 16 else None)
        precision = field("precision", reader.count)
        field("lowest", lambda: reader.signed() if precision else None)
        domain = field("domain", lambda: reader.number("B"))
        channels = field("channel count", reader.count)
        field("names", lambda: [reader.take(reader.count()) for _ in range(channels)])
        channels = channels or 3
        field("grey", lambda: [reader.count() for _ in range(channels if domain & 16 else 0)])
        domain &= 15
        self.ranges = field("ranges", lambda: [(reader.signed(), reader.count()) for _ in range(channels)])
        field("references", lambda: [reader.count() for _ in range(channels if domain == 2 else 0)])
        field("halvings", lambda: reader.take(1 if domain == 2 else 0))
        field("guide ratio", lambda: reader.numbers("d", int(parts & 1 and not isotropic)))
        field("guide count", lambda: reader.count() if parts & 1 else None)
        samples = field("samples", reader.count)
        field("base channel", reader.count)
        field("activity shift", lambda: reader.number("B"))
        field("token count", lambda: reader.number("B"))
        for group in range(4):
            if (group < 2 or samples) and (group % 2 == 0 or channels > 1):
                field(f"group {group}", lambda: reader.take(8 if reader.number("B") & 128 else 0))
        field("guide distributions", lambda: reader.take(2 * (parts & 1)))
        field("flags", lambda: self.flags(reader) if samples or parts & 1 else None)
        self.metadata = field("metadata", lambda: (reader.count(), reader.take(reader.count())) if parts & 4 else None)
        split = parts & 2
        field("pieces", lambda: reader.take(reader.count()) if split else None)
        field("blocks", lambda: [reader.count() for _ in range(20 if split else 0)])
        chunk_count = field("chunk count", lambda: reader.count() if split else 1 + bool(parts & 16))
        self.sizes = [reader.count() for _ in range(chunk_count)]

    @staticmethod
    def read_mask(reader):
        return reader.number("B"), [reader.count() for _ in range(4)], reader.count()

    @staticmethod
    def one_axis(reader):
        size, form = reader.count(), reader.number("B")
        if form == 66:
            reader.take(8 * size)
        elif form != 64:
            for _ in range(min(size - 1, 1) if 32 <= form < 64 else size - 1):
                reader.count()

    @staticmethod
    def flags(reader):
        bits = reader.number("B")
        reader.take((bits & 7) * (8 if bits & 8 else 1))

    def emit(self, index_tail=b"", file_tail=b"", chunk_count=None, sizes=None, **header):
        """The file; `sizes` replaces some of the sizes of chunks, `header` some of its fields."""
        chunks = b""
        stated = []
        for payload in self.payloads:
            chunk = b"" if payload is None else payload + struct.pack("<I", zlib.crc32(payload))
            stated.append(len(chunk))
            chunks += chunk
        for k, size in (sizes or {}).items():
            stated[k] = size
        fields = dict(self.fields)
        if fields["chunk count"]:
            fields["chunk count"] = count(len(stated)) if chunk_count is None else chunk_count
        index = b"".join(fields.values()) + b"".join(count(size) for size in stated) + index_tail
        index = index[:header.get("index_end")]
        size = header.get("index_size", count(len(index)))
        head = header.get("magic", MAGIC) + bytes([header.get("major", 1), header.get("minor", self.minor)]) + size + index
        return head + struct.pack("<I", zlib.crc32(head) ^ header.get("flip", 0)) + chunks + file_tail

    def changed(self, **fields):
        """A copy with other bytes in some fields; `_` in a name stands for a blank."""
        other = copy.deepcopy(self)
        for name, value in fields.items():
            other.fields[name.replace("_", " ")] = value
        return other

    def with_payload(self, k, payload):
        other = copy.deepcopy(self)
        other.payloads[k] = payload
        return other

    def without_chunk(self, k):
        other = copy.deepcopy(self)
        del other.payloads[k]
        return other

    def altered(self, field, position, value):
        """A copy with some bytes of a field replaced."""
        before = self.fields[field]
        return self.changed(**{field: before[:position] + value + before[position + len(value):]})

    def chunk_of_crossings(self):
        return 1

    def last_chunk(self):
        return max(k for k in range(2, len(self.payloads)) if self.payloads[k] is not None)


def container_vectors(base, split, guided):
    plain = base.emit()
    flipped = bytearray(split.emit())
    flipped[flipped.index(split.payloads[split.chunk_of_crossings() + 1])] ^= 1
    empty = base.with_payload(0, b"").emit()
    yield "SB-1-1-magic", base.emit(magic=b"\x89SBR")
    yield "SB-1-3-major-0", base.emit(major=0)
    yield "SB-1-3-major-2", base.emit(major=2)
    yield "SB-1-4-header-cut", plain[:6]
    yield "SB-1-4-head-cut", plain[:50]
    yield "SB-1-4-index-behind-the-end", base.emit(index_size=count(len(plain)))
    yield "SB-1-5-index-size", base.emit(index_size=count(2**25 + 1))
    yield "SB-1-5-needless-byte", base.emit(index_size=b"\x81\x00")
    yield "SB-1-6-head-checksum", base.emit(flip=1)
    yield "SB-1-7-chunk-checksum", bytes(flipped)
    yield "SB-1-7-empty-chunk", empty
    yield "SB-1-7-no-chunk", base.with_payload(0, None).emit()
    yield "SB-1-7-no-guide", guided.with_payload(0, None).emit()
    yield "SB-1-7-no-crossings", split.with_payload(split.chunk_of_crossings(), None).emit()


def count_vectors(base):
    n = base.fields["samples"]
    yield "SB-2-1-index-goes-on", base.emit(index_tail=b"\0")
    yield "SB-2-1-index-cut", base.emit(index_end=-20)
    yield "SB-2-1-needless-byte", base.changed(samples=n[:-1] + bytes([n[-1] | 128, 0])).emit()
    yield "SB-2-1-count-of-2-to-the-32", base.changed(samples=bytes([128] * 4 + [16])).emit()
    yield "SB-2-1-count-of-six-bytes", base.changed(samples=bytes([255] * 5 + [1])).emit()


def frame_vectors(base, half_difference):
    for frame in (0, 3):
        yield f"SB-2-2-frame-{frame}", base.changed(frame=bytes([frame])).emit()
    yield "SB-2-3-symmetries-8", base.changed(frame=b"\x81").emit()

    def axes(**which):
        return base.changed(**which).emit()

    yield "SB-2-4-form-21", axes(axis_0=b"\x01\x15")
    yield "SB-2-4-form-67", axes(axis_0=b"\x01\x43")
    yield "SB-2-4-form-of-a-turn", axes(axis_2=b"\x04\x40")
    yield "SB-2-4-no-nodes", axes(axis_0=b"\x00\x00")
    yield "SB-2-4-4097-nodes", axes(axis_0=count(4097) + b"\x40")
    yield "SB-2-4-begins-with-1", axes(axis_0=nodes(1, 180))
    yield "SB-2-4-equal-nodes", axes(axis_0=nodes(0, 180, 180))
    yield "SB-2-4-nodes-too-close", axes(axis_0=nodes(0, 180, 180.0009))
    yield "SB-2-4-not-a-number", axes(axis_0=nodes(0, float("nan")))
    yield "SB-2-4-infinite", axes(axis_0=nodes(0, float("inf")))
    yield "SB-2-4-azimuth-360", axes(axis_1=nodes(0, 360))
    yield "SB-2-4-difference-azimuth-180", half_difference.changed(axis_1=nodes(0, 180)).emit()
    yield "SB-2-4-polar-91", axes(axis_2=nodes(0, 91))
    yield "SB-2-4-no-counterpart", axes(axis_1=nodes(0, 100, 180))
    yield "SB-2-4-mirror-without-node", axes(frame=b"\x21", axis_0=nodes(0, 100, 260))
    yield "SB-2-4-large-lattice", axes(axis_0=b"\x3c\x40", axis_1=b"\x3c\x40", axis_2=nodes(*range(0, 90, 3)))


def channel_vectors(base, log):
    yield "SB-2-5-domain-0", base.changed(domain=b"\x00").emit()
    yield "SB-2-5-domain-3", base.changed(domain=b"\x03").emit()
    yield "SB-2-18-all-0", log.changed(domain=b"\x12", grey=count(0) * len(log.ranges)).emit()
    yield "SB-2-18-1025", log.changed(domain=b"\x12", grey=count(1025) * len(log.ranges)).emit()
    yield "SB-2-6-4097-channels", base.changed(channel_count=count(4097), names=bytes(4097)).emit()
    for what, step in (("zero", 0), ("infinite", 0x7f800000), ("not-a-number", 0x7fc00000), ("too-large", 2**31)):
        yield f"SB-2-7-reference-{what}", log.altered("references", 0, count(step)).emit()
    for what, step in (("infinite", -0x7f800000), ("too-small", -2**31)):
        yield f"SB-2-8-least-{what}", log.changed(ranges=ranges_of(log, 0, step, 0)).emit()
    for what, step in (("not-a-number", 0x7fc00000), ("too-large", 2**31)):
        yield f"SB-2-8-greatest-{what}", log.changed(ranges=ranges_of(log, 0, 0, step)).emit()


def ranges_of(parts, channel, least, most):
    """The field with other steps for one channel."""
    steps = [(low, low + above) for low, above in parts.ranges]
    steps[channel] = (least, most)
    return b"".join(signed(low) + count(high - low) for low, high in steps)


def amount_vectors(base, half_difference_linear, guided):
    def with_guide(parts):
        fields = dict(parts.fields)
        return parts.changed(parts=bytes([fields["parts"][0] | 1]), guide_ratio=f64(1), guide_count=count(10)).emit()

    yield "SB-2-16-parts-32", guided.changed(parts=b"\x21").emit()
    yield "SB-2-16-theta-max-in-elevation", base.changed(parts=b"\x0c", theta_max=count(7000)).emit()
    yield "SB-2-9-ratio-too-small", guided.changed(guide_ratio=f64(0.0009)).emit()
    yield "SB-2-9-ratio-too-large", guided.changed(guide_ratio=f64(1001)).emit()
    yield "SB-2-9-ratio-not-a-number", guided.changed(guide_ratio=f64(float("nan"))).emit()
    yield "SB-2-9-samples", guided.changed(guide_count=count(2**20 + 1)).emit()
    yield "SB-2-9-elevation-frame", with_guide(base)
    yield "SB-2-9-linear", with_guide(half_difference_linear)
    yield "SB-2-14-samples", base.changed(samples=count(2**26 + 1)).emit()
    yield "SB-2-14-samples-for-the-size", base.changed(samples=count(2**25)).emit()
    yield "SB-2-14-crossings-for-the-size", base.changed(
        axis_0=b"\x18\x40", axis_1=b"\xf0\x01\x40", axis_2=nodes(*[2.5 * k for k in range(12)]),
        channel_count=count(120), names=bytes(120), ranges=bytes(2 * 120)).emit()


def coding_vectors(base, split, guided):
    yield "SB-2-11-bound", base.changed(precision=count(500001)).emit()
    for what, value in (("low", -2**29 - 1), ("high", 2**29 + 1)):
        yield f"SB-2-11-lowest-{what}", base.changed(lowest=signed(value)).emit()
    yield "SB-2-12-base-channel", base.changed(base_channel=count(len(base.ranges))).emit()
    yield "SB-2-12-activity-shift", base.changed(activity_shift=b"\x20").emit()
    yield "SB-2-12-tokens-15", base.changed(token_count=b"\x0f").emit()
    yield "SB-2-12-tokens-75", base.changed(token_count=b"\x4b").emit()
    yield "SB-2-12-distribution-112", guided.changed(guide_distributions=b"\x00\x70").emit()
    yield "SB-2-12-flags-of-7-depths", base.altered("flags", 0, b"\x07").emit()
    for what, pieces in (("none", []), ("begin-with-2", [2, 3, 4, 5, 6]), ("equal", [1, 2, 2, 3, 4]),
                         ("level-17", [1, 2, 3, 4, 17]), ("17-of-them", list(range(1, 18)))):
        yield f"SB-2-13-{what}", split.changed(pieces=count(len(pieces)) + bytes(pieces)).emit()
    packed = base.metadata[1]
    yield "SB-2-15-metadata-size", base.changed(metadata=count(2**24 + 1) + count(len(packed)) + packed).emit()
    yield "SB-2-15-chunks", split.emit(chunk_count=count(2**31))


def chunk_vectors(base, split, guided):
    last = len(split.payloads) - 1
    empty = next(k for k in range(2, last + 1) if split.payloads[k] is None)
    yield "SB-3-1-one-less", split.without_chunk(empty).emit()
    more = copy.deepcopy(split)
    more.payloads.append(None)
    yield "SB-3-1-one-more", more.emit()
    yield "SB-3-2-ends-late", base.emit(file_tail=b"\0")
    yield "SB-3-2-one-byte-less", base.emit()[:-1]
    used = split.last_chunk()
    yield "SB-3-2-ends-early", split.emit(sizes={used: len(split.payloads[used]) + 5})
    for clause, parts, k in (("SB-8-1", split, split.chunk_of_crossings()), ("SB-8-2", guided, 0),
                             ("SB-8-3", split, split.last_chunk())):
        payload = parts.payloads[k]
        yield f"{clause}-first-state", parts.with_payload(k, b"\xff\xff\0\0" + payload[4:]).emit()
        yield f"{clause}-no-state", parts.with_payload(k, payload[:3]).emit()
        yield f"{clause}-half-a-word", parts.with_payload(k, payload + b"\0").emit()
        yield f"{clause}-word-less", parts.with_payload(k, payload[:-2]).emit()
        yield f"{clause}-word-more", parts.with_payload(k, payload + b"\0\0").emit()
        # Only what the last symbol leaves over changes with the lowest bits of the last word.
        yield f"{clause}-last-state", parts.with_payload(k, payload[:-2] + bytes([payload[-2] ^ 1, payload[-1]])).emit()
    yield "SB-8-2-a-chunk-for-no-guide", split.with_payload(0, bytes(20)).emit()
    yield "SB-8-3-whole-word-more", base.with_payload(0, base.payloads[0] + b"\0\0").emit()
    yield "SB-8-3-whole-word-less", base.with_payload(0, base.payloads[0][:-2]).emit()
    guide_count = IndexReader(guided.fields["guide count"]).count()
    yield "SB-8-2-sample-less", guided.changed(guide_count=count(guide_count - 1)).emit()
    yield "SB-8-2-sample-more", guided.changed(guide_count=count(guide_count + 1)).emit()
    for which, parts in (("", split), ("whole-", base)):
        samples = IndexReader(parts.fields["samples"]).count()
        yield f"SB-8-3-{which}sample-less", parts.changed(samples=count(samples - 1)).emit()
        yield f"SB-8-3-{which}sample-more", parts.changed(samples=count(samples + 1)).emit()
    yield "SB-8-3-no-chunk", split.with_payload(split.last_chunk(), None).emit()


def compressed(text):
    packer = zlib.compressobj(9, wbits=-15, zdict=DICTIONARY)
    return packer.compress(text) + packer.flush()


def packed_runs(*lengths, tail=b"", content_size=True):
    content = b"".join(map(count, lengths)) + tail
    return content, zstandard.ZstdCompressor(write_content_size=content_size).compress(content)


def mask_vectors(masked):
    frame, cells, size = masked.mask
    last = len(masked.payloads) - 1
    total = math.prod(cells)

    def stating(mask_frame=frame, mask_cells=cells, mask_size=size):
        return masked.changed(mask=bytes([mask_frame]) + b"".join(map(count, mask_cells)) + count(mask_size))

    def holding(content, payload, stated=None):
        return stating(mask_size=len(content) if stated is None else stated).with_payload(last, payload).emit()

    yield "SB-1-7-no-mask", masked.with_payload(last, None).emit()
    yield "SB-2-4-theta-max-0", masked.changed(theta_max=count(0)).emit()
    yield "SB-2-4-theta-max-9001", masked.changed(theta_max=count(9001)).emit()
    yield "SB-2-17-frame-0", stating(mask_frame=0).emit()
    yield "SB-2-17-frame-3", stating(mask_frame=3).emit()
    yield "SB-2-17-no-cells", stating(mask_cells=[0] + cells[1:]).emit()
    yield "SB-2-17-4097-along-an-axis", stating(mask_cells=[4097, 1, 1, 1]).emit()
    yield "SB-2-17-too-many-cells", stating(mask_cells=[4096, 4096, 5, 1]).emit()
    yield "SB-2-17-size-0", stating(mask_size=0).emit()
    yield "SB-2-17-size-too-large", stating(mask_size=2**27 + 1).emit()
    yield "SB-8-7-cells-missing", holding(*packed_runs(1, total - 2))
    yield "SB-8-7-cells-too-many", holding(*packed_runs(1, total))
    yield "SB-8-7-empty-run", holding(*packed_runs(1, 0, total - 1))
    yield "SB-8-7-cut-count", holding(*packed_runs(total, tail=b"\x80"))
    yield "SB-8-7-needless-byte", holding(*packed_runs(total - 1, tail=b"\x81\x00"))
    yield "SB-8-7-no-size", holding(*packed_runs(total, content_size=False))
    content, packed = packed_runs(total)
    yield "SB-8-7-bytes-behind", holding(content, packed + b"\0")
    yield "SB-8-7-other-size", holding(content, packed, len(content) + 1)
    yield "SB-8-7-not-zstd", holding(content, content)


def value_vectors(base, lossless):
    # The ranges are those of the greatest values, where the series of steps ends; the values are beyond it.
    ranges = (signed(1) + count(0)) * len(base.ranges)
    lowest = 128 * Index(Container(base.emit())).scale.per_octave - 2
    yield "SB-8-4-bounded-overflow", base.changed(lowest=signed(lowest), ranges=ranges).emit()
    text = b'{"source":{"format":"kurt"}}'

    def metadata(packed, size=len(text)):
        return base.changed(metadata=count(size) + count(len(packed)) + packed).emit()

    yield "SB-8-5-other-size", metadata(compressed(text), len(text) + 1)
    yield "SB-8-5-not-deflate", metadata(b"\xff" + text)
    yield "SB-8-5-cut", metadata(compressed(text)[:-1])
    yield "SB-8-5-goes-on", metadata(compressed(text) + b"\0")
    least, above = base.ranges[0]
    yield "SB-8-6-least", base.changed(ranges=ranges_of(base, 0, least - 1, least + above)).emit()
    yield "SB-8-6-greatest", base.changed(ranges=ranges_of(base, 0, least, least + above + 1)).emit()
    yield "SB-8-6-lossless", lossless.changed(ranges=ranges_of(lossless, 0, lossless.ranges[0][0], 0x7f000000)).emit()


def all_vectors(accept):
    base, split, log, lossless, half_difference, linear, guided, guided_split, masked = (
        Parts((accept / f"{name}.sbrdf").read_bytes())
        for name in ("elevation-linear", "elevation-odd-steps-split", "elevation-log-lossless", "elevation-log-lossless",
                     "half-difference-log", "half-difference-linear", "guide-ratio", "guide-lossless-split", "mask"))
    return dict([
        *container_vectors(base, split, guided_split), *count_vectors(base), *frame_vectors(base, half_difference),
        *channel_vectors(base, log), *amount_vectors(base, linear, guided), *coding_vectors(base, split, guided),
        *chunk_vectors(base, split, guided_split), *value_vectors(base, lossless),
        *mask_vectors(masked)
    ])


def problems(made, reject):
    held = {path.stem: path.read_bytes() for path in reject.glob("*.sbrdf")}
    for name in sorted(made.keys() | held.keys()):
        if name not in held:
            yield f"{name} is missing"
        elif name not in made and name not in BY_AN_ENCODER:
            yield f"{name} is not made here"
        elif name in made and made[name] != held[name]:
            yield f"{name} is made otherwise"


def main():
    arguments = sys.argv[1:]
    checks = arguments[:1] == ["--check"]
    if len(arguments) != (3 if checks else 2):
        print(__doc__, file=sys.stderr)
        return 1
    accept, reject = map(pathlib.Path, arguments[-2:])
    made = all_vectors(accept)
    if checks:
        found = list(problems(made, reject))
        print(*found, sep="\n", end="\n" if found else "")
        return 1 if found else 0
    reject.mkdir(parents=True, exist_ok=True)
    for name, content in made.items():
        path = reject / f"{name}.sbrdf"
        if not path.exists():
            path.write_bytes(content)
            print(name, len(content))
    return 0


if __name__ == "__main__":
    sys.exit(main())
