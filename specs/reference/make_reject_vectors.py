#!/usr/bin/env python3
"""Files that break one rule of specs/sbrdf.md each, all checksums repaired around it.

usage: make_reject_vectors.py ACCEPT_FOLDER REJECT_FOLDER

Vectors are frozen: what the reject folder holds already is left as it is. A file's name begins with the rule that is
broken.
"""
import copy
import pathlib
import struct
import sys
import zlib

import zstandard

from sbrdf_reference import DICTIONARY, FLAG_CONTEXTS, MAGIC, RESIDUAL_CONTEXTS, Container, IndexReader, payload_of


def count(value):
    groups = bytearray()
    while value > 127:
        groups.append(value & 127 | 128)
        value >>= 7
    return bytes(groups) + bytes([value])


def f32s(*values):
    return struct.pack(f"<{len(values)}f", *values)


def f64(value):
    return struct.pack("<d", value)


def nodes(*degrees):
    return bytes([2]) + count(len(degrees)) + struct.pack(f"<{len(degrees)}d", *degrees)


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

        def used(contexts):
            mask = reader.take((contexts + 7) // 8)
            return reader.take(sum(bin(byte).count("1") for byte in mask))

        def one_axis():
            form = reader.number("B")
            size = reader.count()
            return reader.take(8 if form == 0 else (2 if form == 1 else 8) * size)

        field("frame", lambda: reader.number("B"))
        field("symmetries", lambda: reader.number("B"))
        for axis in range(4):
            field(f"axis {axis}", one_axis)
        domain = field("domain", lambda: reader.number("B"))
        channels = field("channel count", reader.count)
        field("names", lambda: [reader.take(reader.count()) for _ in range(channels)])
        field("log", lambda: reader.numbers("f", 2 * channels if domain == 2 else 0))
        field("ranges", lambda: reader.numbers("f", 2 * channels))
        guide = field("guide", lambda: reader.number("B"))
        field("guide ratio", lambda: reader.numbers("d", guide))
        field("guide count", lambda: reader.count() if guide else None)
        field("samples", reader.count)
        precision = field("precision", lambda: reader.number("B"))
        field("bound", lambda: reader.numbers("d", precision))
        field("per octave", lambda: reader.count() if precision else None)
        field("ratio", lambda: reader.numbers("d", precision))
        field("lowest", lambda: reader.numbers("i", precision))
        field("base channel", reader.count)
        field("activity shift", lambda: reader.number("B"))
        field("token count", lambda: reader.number("B"))
        field("distributions", lambda: used(RESIDUAL_CONTEXTS))
        field("flags", lambda: used(FLAG_CONTEXTS))
        field("pieces", lambda: reader.take(reader.count()))
        field("blocks", lambda: [reader.count() for _ in range(20)])
        field("metadata size", reader.count)
        chunk_count = field("chunk count", reader.count)
        self.sizes = [reader.count() for _ in range(chunk_count)]

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
        fields["chunk count"] = count(len(stated)) if chunk_count is None else chunk_count
        index = b"".join(fields.values()) + b"".join(count(size) for size in stated) + index_tail
        index = index[:header.get("index_end")]
        file_size = 32 + len(index) + len(chunks) + len(file_tail)
        start = header.get("magic", MAGIC) + struct.pack(
            "<HHIQI", header.get("major", 1), header.get("minor", self.minor), header.get("index_size", len(index)),
            header.get("file_size", file_size), zlib.crc32(index) ^ header.get("index_flip", 0))
        return start + struct.pack("<I", zlib.crc32(start) ^ header.get("header_flip", 0)) + index + chunks + file_tail

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
        return 2

    def first_chunk_of_samples(self):
        return next(k for k in range(3, len(self.payloads)) if self.payloads[k] is not None)


def container_vectors(base, guided):
    plain = base.emit()
    payload = base.payloads[-1] or base.payloads[base.first_chunk_of_samples()]
    flipped = bytearray(plain)
    flipped[plain.rindex(payload)] ^= 1
    metadata = base.payloads[0]
    empty = base.emit().replace(metadata + struct.pack("<I", zlib.crc32(metadata)), struct.pack("<I", 0))
    yield "SB-1-1-magic", base.emit(magic=b"\x89SBRDF\n\n")
    yield "SB-1-2-header-checksum", base.emit(header_flip=1)
    yield "SB-1-3-major-0", base.emit(major=0)
    yield "SB-1-3-major-2", base.emit(major=2)
    yield "SB-1-4-one-byte-less", plain[:-1]
    yield "SB-1-4-one-byte-more", plain + b"\0"
    yield "SB-1-4-header-cut", plain[:31]
    yield "SB-1-4-states-less", base.emit(file_size=len(plain) - 1)
    yield "SB-1-5-index-size", base.emit(index_size=2**24 + 1)
    yield "SB-1-5-index-behind-the-end", base.emit(index_size=len(plain) - 31)
    yield "SB-1-6-index-checksum", base.emit(index_flip=1)
    yield "SB-1-7-chunk-checksum", bytes(flipped)
    yield "SB-1-7-empty-chunk", repaired(empty, base.emit(sizes={0: 4}))
    yield "SB-1-7-no-metadata", base.with_payload(0, None).emit()
    yield "SB-1-7-no-guide", guided.with_payload(1, None).emit()
    yield "SB-1-7-no-crossings", base.with_payload(base.chunk_of_crossings(), None).emit()


def repaired(file, like):
    """`file` with header and index of `like`, whose chunks differ, and its own size."""
    index_size = struct.unpack_from("<I", like, 12)[0]
    own_index_size = struct.unpack_from("<I", file, 12)[0]
    body = like[32:32 + index_size] + file[32 + own_index_size:]
    start = like[:16] + struct.pack("<QI", 32 + len(body), zlib.crc32(like[32:32 + index_size]))
    return start + struct.pack("<I", zlib.crc32(start)) + body


def count_vectors(base):
    n = base.fields["samples"]
    yield "SB-2-1-index-goes-on", base.emit(index_tail=b"\0")
    yield "SB-2-1-index-cut", base.emit(index_end=len(b"".join(base.fields.values())) - 20)
    yield "SB-2-1-needless-byte", base.changed(samples=n[:-1] + bytes([n[-1] | 128, 0])).emit()
    yield "SB-2-1-count-of-2-to-the-32", base.changed(samples=bytes([128] * 4 + [16])).emit()
    yield "SB-2-1-count-of-six-bytes", base.changed(samples=bytes([255] * 5 + [1])).emit()


def frame_vectors(base, half_difference):
    for frame in (0, 3):
        yield f"SB-2-2-frame-{frame}", base.changed(frame=bytes([frame])).emit()
    yield "SB-2-3-symmetries-8", base.changed(symmetries=b"\x08").emit()

    def axes(**which):
        return base.changed(**which).emit()

    both = ("axis_2", "axis_3")
    yield "SB-2-4-form-3", base.altered("axis 0", 0, b"\x03").emit()
    yield "SB-2-4-no-nodes", axes(axis_0=b"\x01\x00")
    yield "SB-2-4-4097-nodes", axes(axis_0=b"\x00" + count(4097) + f64(0.01))
    yield "SB-2-4-begins-with-1", axes(axis_0=nodes(1, 180))
    yield "SB-2-4-equal-nodes", axes(axis_0=nodes(0, 180, 180))
    yield "SB-2-4-nodes-too-close", axes(axis_0=nodes(0, 180, 180.0009))
    yield "SB-2-4-not-a-number", axes(axis_0=nodes(0, float("nan")))
    yield "SB-2-4-infinite", axes(axis_0=nodes(0, float("inf")))
    yield "SB-2-4-azimuth-360", axes(axis_1=nodes(0, 360))
    yield "SB-2-4-difference-azimuth-180", half_difference.changed(axis_1=nodes(0, 180)).emit()
    yield "SB-2-4-polar-91", axes(**{axis: nodes(0, 91) for axis in both})
    yield "SB-2-4-elevations-differ", axes(axis_3=nodes(0, 28, 56, 80.5))
    yield "SB-2-4-isotropic-azimuths", axes(symmetries=b"\x01")
    yield "SB-2-4-no-counterpart", axes(axis_1=nodes(0, 100, 180))
    yield "SB-2-4-mirror-without-node", axes(symmetries=b"\x02", axis_0=nodes(0, 100, 260))
    large = count(60) + f64(6)
    yield "SB-2-4-large-lattice", axes(axis_0=b"\x00" + large, axis_1=b"\x00" + large,
                                       **{axis: nodes(*range(0, 90, 3)) for axis in both})


def channel_vectors(base, log):
    size = len(base.fields["ranges"]) // 8
    yield "SB-2-5-domain-0", base.changed(domain=b"\x00").emit()
    yield "SB-2-5-domain-3", base.changed(domain=b"\x03").emit()
    yield "SB-2-6-no-channels", base.changed(channel_count=b"\x00", names=b"", ranges=b"").emit()
    yield "SB-2-6-4097-channels", base.changed(channel_count=count(4097), names=bytes(4097)).emit()
    for what, value in (("zero", 0.0), ("negative", -1.0), ("infinite", float("inf")), ("not-a-number", float("nan"))):
        yield f"SB-2-7-reference-{what}", log.altered("log", 0, f32s(value)).emit()
        yield f"SB-2-7-floor-{what}", log.altered("log", 4 * size, f32s(value)).emit()
    yield "SB-2-8-least-infinite", base.altered("ranges", 0, f32s(-float("inf"))).emit()
    yield "SB-2-8-greatest-not-a-number", base.altered("ranges", 4, f32s(float("nan"))).emit()
    yield "SB-2-8-least-above-greatest", base.altered("ranges", 0, f32s(2, 1)).emit()


def amount_vectors(base, half_difference_linear, guided):
    ratio = {"guide": b"\x01", "guide_ratio": f64(1), "guide_count": count(10)}
    yield "SB-2-9-guide-2", guided.changed(guide=b"\x02").emit()
    yield "SB-2-9-ratio-too-small", guided.changed(guide_ratio=f64(0.0009)).emit()
    yield "SB-2-9-ratio-too-large", guided.changed(guide_ratio=f64(1001)).emit()
    yield "SB-2-9-ratio-not-a-number", guided.changed(guide_ratio=f64(float("nan"))).emit()
    yield "SB-2-9-samples", guided.changed(guide_count=count(2**20 + 1)).emit()
    yield "SB-2-9-elevation-frame", base.changed(**ratio).emit()
    yield "SB-2-9-linear", half_difference_linear.changed(**ratio).emit()
    yield "SB-2-14-samples", base.changed(samples=count(2**26 + 1)).emit()
    yield "SB-2-14-samples-for-the-size", base.changed(samples=count(2**25)).emit()
    yield "SB-2-14-crossings-for-the-size", base.changed(
        axis_0=b"\x00" + count(24) + f64(1), axis_1=b"\x00" + count(240) + f64(1.5),
        **{axis: nodes(*[2.5 * k for k in range(12)]) for axis in ("axis_2", "axis_3")},
        channel_count=count(120), names=bytes(120), ranges=bytes(8 * 120)).emit()


def coding_vectors(base):
    yield "SB-2-10-precision-2", base.changed(precision=b"\x02").emit()
    for what, value in (("0", 0.0), ("1", 1.0), ("not-a-number", float("nan"))):
        yield f"SB-2-11-bound-{what}", base.changed(bound=f64(value)).emit()
    for what, value in (("0", 0), ("too-many", 2**20 + 1)):
        yield f"SB-2-11-per-octave-{what}", base.changed(per_octave=count(value)).emit()
    for what, value in (("1", 1.0), ("above-2", 2.0000001), ("not-a-number", float("nan"))):
        yield f"SB-2-11-ratio-{what}", base.changed(ratio=f64(value)).emit()
    for what, value in (("low", -2**29 - 1), ("high", 2**29 + 1)):
        yield f"SB-2-11-lowest-{what}", base.changed(lowest=struct.pack("<i", value)).emit()
    yield "SB-2-12-base-channel", base.changed(base_channel=base.fields["channel count"]).emit()
    yield "SB-2-12-activity-shift", base.changed(activity_shift=b"\x20").emit()
    yield "SB-2-12-tokens-15", base.changed(token_count=b"\x0f").emit()
    yield "SB-2-12-tokens-75", base.changed(token_count=b"\x4b").emit()
    yield "SB-2-12-distribution-112", base.altered("distributions", 9, b"\x70").emit()
    yield "SB-2-12-distribution-255", base.altered("distributions", 9, b"\xff").emit()
    for what, pieces in (("none", []), ("begin-with-2", [2, 3, 4, 5, 6]), ("equal", [1, 2, 2, 3, 4]),
                         ("level-17", [1, 2, 3, 4, 17]), ("17-of-them", list(range(1, 18)))):
        yield f"SB-2-13-{what}", base.changed(pieces=count(len(pieces)) + bytes(pieces)).emit()
    yield "SB-2-15-metadata-size", base.changed(metadata_size=count(2**24 + 1)).emit()
    yield "SB-2-15-chunks", base.emit(chunk_count=count(2**31))


def chunk_vectors(base, guided):
    last = len(base.payloads) - 1
    empty = next(k for k in range(3, last + 1) if base.payloads[k] is None)
    yield "SB-3-1-one-less", base.without_chunk(empty).emit()
    more = copy.deepcopy(base)
    more.payloads.append(None)
    yield "SB-3-1-one-more", more.emit()
    yield "SB-3-2-ends-late", base.emit(file_tail=b"\0")
    used = max(k for k in range(last + 1) if base.payloads[k] is not None)
    yield "SB-3-2-ends-early", base.emit(sizes={used: len(base.payloads[used]) + 5})
    for clause, parts, k in (("SB-8-1", base, base.chunk_of_crossings()), ("SB-8-2", guided, 1),
                             ("SB-8-3", base, base.first_chunk_of_samples())):
        payload = parts.payloads[k]
        yield f"{clause}-first-state", parts.with_payload(k, b"\xff\xff\0\0" + payload[4:]).emit()
        yield f"{clause}-no-state", parts.with_payload(k, payload[:3]).emit()
        yield f"{clause}-half-a-word", parts.with_payload(k, payload + b"\0").emit()
        yield f"{clause}-word-less", parts.with_payload(k, payload[:-2]).emit()
        yield f"{clause}-word-more", parts.with_payload(k, payload + b"\0\0").emit()
        # Only what the last symbol leaves over changes with the lowest bits of the last word.
        yield f"{clause}-last-state", parts.with_payload(k, payload[:-2] + bytes([payload[-2] ^ 1, payload[-1]])).emit()
    yield "SB-8-1-unused-context", base.changed(distributions=bytes(9)).emit()
    guide_count = IndexReader(guided.fields["guide count"]).count()
    yield "SB-8-2-sample-less", guided.changed(guide_count=count(guide_count - 1)).emit()
    yield "SB-8-2-sample-more", guided.changed(guide_count=count(guide_count + 1)).emit()
    samples = IndexReader(base.fields["samples"]).count()
    yield "SB-8-3-sample-less", base.changed(samples=count(samples - 1)).emit()
    yield "SB-8-3-sample-more", base.changed(samples=count(samples + 1)).emit()
    yield "SB-8-3-no-chunk", base.with_payload(base.first_chunk_of_samples(), None).emit()
    yield "SB-8-3-unused-context", base.changed(flags=bytes(6)).emit()


def compressed(text, content_size=True, dictionary=DICTIONARY):
    raw = zstandard.ZstdCompressionDict(dictionary, dict_type=zstandard.DICT_TYPE_RAWCONTENT) if dictionary else None
    return zstandard.ZstdCompressor(level=19, dict_data=raw, write_content_size=content_size).compress(text)


def value_vectors(base, lossless):
    yield "SB-8-4-lossy-overflow", base.changed(lowest=struct.pack("<i", 2**29)).emit()
    text = b'{"source":{"format":"kurt"}}'

    def metadata(payload, size=len(text)):
        return base.with_payload(0, payload).changed(metadata_size=count(size)).emit()

    yield "SB-8-5-other-size", metadata(compressed(text), len(text) + 1)
    yield "SB-8-5-no-size", metadata(compressed(text, content_size=False))
    yield "SB-8-5-not-zstd", metadata(text)
    yield "SB-8-5-cut", metadata(compressed(text)[:-1])
    least, greatest = struct.unpack_from("<2f", base.fields["ranges"])
    yield "SB-8-6-least", base.altered("ranges", 0, f32s(least - 1)).emit()
    yield "SB-8-6-greatest", base.altered("ranges", 4, f32s(greatest * 2)).emit()
    yield "SB-8-6-lossless", lossless.altered("ranges", len(lossless.fields["ranges"]) - 4, f32s(1e30)).emit()


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    accept, reject = map(pathlib.Path, sys.argv[1:])
    reject.mkdir(parents=True, exist_ok=True)
    base, log, lossless, half_difference, linear, guided = (
        Parts((accept / f"{name}.sbrdf").read_bytes())
        for name in ("elevation-linear", "elevation-log-lossless", "elevation-log-lossless", "half-difference-log",
                     "half-difference-linear", "guide-ratio"))
    vectors = [
        *container_vectors(base, guided), *count_vectors(base), *frame_vectors(base, half_difference),
        *channel_vectors(base, log), *amount_vectors(base, linear, guided), *coding_vectors(base),
        *chunk_vectors(base, guided), *value_vectors(base, lossless)
    ]
    for name, content in vectors:
        path = reject / f"{name}.sbrdf"
        if not path.exists():
            path.write_bytes(content)
            print(name, len(content))
    return 0


if __name__ == "__main__":
    sys.exit(main())
