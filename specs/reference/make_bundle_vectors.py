#!/usr/bin/env python3
"""Bundles that keep all rules of specs/sbrdfz.md, and bundles that break one each, all checksums repaired around it.

usage: make_bundle_vectors.py SLICED_FOLDER FOLDER    reads some of the sliced vectors; writes FOLDER/accept and reject

Vectors are frozen: what the folders hold already is left as it is. A rejected file's name begins with the rule that is
broken.
"""
import pathlib
import struct
import sys
import zlib

import zstandard

from sbrdf_reference import Container
from sbrdfz_reference import MAGIC, count, summary_of

NAMES = ("elevation-crossings-only", "elevation-isotropic-split", "guide", "worked-example")


def sealed(data):
    return data + struct.pack("<I", zlib.crc32(data))


class Entry:
    """A material taken apart, with all that the index says of it; any of it may be changed before it is put together."""

    def __init__(self, name, file, dictionary=None):
        container = Container(file)
        self.name = name.encode()
        self.head = file[4:6] + container.index
        self.index_size, self.body = len(container.index), file[container.chunks_begin:]
        self.body_size, self.stored = len(self.body), self.head
        if dictionary is not None:
            options = zstandard.ZstdCompressionParameters.from_level(
                19, write_content_size=0, write_checksum=0, write_dict_id=0)
            data = zstandard.ZstdCompressionDict(dictionary) if dictionary else None
            packed = zstandard.ZstdCompressor(dict_data=data, compression_params=options).compress(self.head)[4:]
            self.stored = min(self.head, packed, key=len)
        self.stored_size, self.flip = len(self.stored), 0

    def changed(self, **fields):
        other = object.__new__(Entry)
        other.__dict__ = {**self.__dict__, **fields}
        return other

    def row(self):
        sizes = (self.index_size, self.stored_size, self.body_size)
        return count(len(self.name)) + self.name + b"".join(map(count, sizes))

    def content(self):
        chunk = sealed(self.stored)
        return chunk[:-1] + bytes([chunk[-1] ^ self.flip]) + self.body


def bundle(entries, dictionary=b"", **header):
    """`header` replaces some of what is stated; a value with `_flip` spoils a checksum."""
    index = header.get("count", count(len(entries))) + count(header.get("dictionary_size", len(dictionary)))
    index = index + b"".join(entry.row() for entry in entries) + header.get("index_tail", b"")
    index = index[:header.get("index_end")]
    content = b""
    if dictionary:
        content = sealed(dictionary)
        content = content[:-1] + bytes([content[-1] ^ header.get("dictionary_flip", 0)])
    content += b"".join(entry.content() for entry in entries) + header.get("tail", b"")
    size = 32 + len(index) + len(content)
    start = header.get("magic", MAGIC) + struct.pack(
        "<HHIQI", header.get("major", 1), header.get("minor", 0), header.get("index_size", len(index)),
        size + header.get("more", 0), zlib.crc32(index) ^ header.get("index_flip", 0))
    return start + struct.pack("<I", zlib.crc32(start) ^ header.get("header_flip", 0)) + index + content


def accepted(files):
    heads = [Entry(name, file).head for name, file in files.items()]
    raw = heads[0] + heads[1]
    made = zstandard.train_dictionary(1024, [head[k:] for head in heads for k in range(0, 120, 4)], dict_id=7).as_bytes()

    def entries(dictionary=None):
        return [Entry(name, file, dictionary) for name, file in files.items()]

    yield "plain", bundle(entries())
    yield "one-material", bundle(entries()[:1])
    yield "compressed-without-dictionary", bundle(entries(b""))
    yield "raw-dictionary", bundle(entries(raw), raw)
    yield "made-dictionary", bundle(entries(made), made)
    yield "newer-minor", bundle(entries(), minor=3, index_tail=b"\x2a", tail=b"\x2a")
    first = entries()[0]
    yield "names", bundle([first.changed(name=name.encode()) for name in sorted(("B", "a b", "z", "\u00e9", "\U0001f600"))])


def rejected(files):
    first, second = (Entry(name, file) for name, file in list(files.items())[:2])
    raw = first.head + second.head
    packed = Entry(NAMES[1], files[NAMES[1]], raw)
    both = [first, second]
    yield "SZ-1-1-magic", bundle(both, magic=b"\x89SBRDZ\n\n")
    yield "SZ-1-2-header", bundle(both, header_flip=1)
    yield "SZ-1-3-major-0", bundle(both, major=0)
    yield "SZ-1-3-major-2", bundle(both, major=2)
    yield "SZ-1-4-longer", bundle(both, more=-1)
    yield "SZ-1-4-shorter", bundle(both, more=1)
    yield "SZ-1-4-cut-in-header", bundle(both)[:31]
    yield "SZ-1-5-index-beyond-the-end", bundle(both, index_size=2**24)
    yield "SZ-1-6-index", bundle(both, index_flip=1)
    yield "SZ-2-1-ends-early", bundle(both, index_end=-1)
    yield "SZ-2-1-goes-on", bundle(both, index_tail=b"\0")
    yield "SZ-2-1-needless-byte", bundle(both, count=b"\x82\x00")
    yield "SZ-2-1-ten-bytes", bundle(both, count=b"\x82" + b"\x80" * 8 + b"\x01")
    yield "SZ-2-2-no-material", bundle([], tail=first.content())
    yield "SZ-2-2-too-many", bundle(both, count=count(2**20))
    for what, name in (("empty", b""), ("too-long", b"a" * 256), ("dot", b"."), ("dots", b".."), ("slash", b"a/b"),
                       ("control", b"a\n"), ("c1-control", b"a\xc2\x85"), ("not-utf-8", b"a\xff"), ("cut", b"a\xc3"),
                       ("too-long-form", b"\xc0\xaf"), ("surrogate", b"\xed\xa0\x80")):
        yield f"SZ-2-3-{what}", bundle([first.changed(name=name)])
    yield "SZ-2-4-falls", bundle([second, first])
    yield "SZ-2-4-twice", bundle([first, first])
    yield "SZ-2-5-index", bundle([first.changed(index_size=2**25 + 1, stored_size=9000)])
    yield "SZ-2-6-nothing", bundle([first.changed(stored_size=0)])
    yield "SZ-2-6-more", bundle([first.changed(stored_size=len(first.head) + 1)])
    yield "SZ-2-6-too-little", bundle([first.changed(index_size=2**24, stored_size=4000)])
    yield "SZ-2-7-ends-late", bundle(both, tail=b"\0")
    yield "SZ-2-7-ends-early", bundle([first, second.changed(body_size=second.body_size + 1)])
    yield "SZ-2-7-wraps", bundle([first.changed(body_size=2**63 - 1), second.changed(body_size=2**63 - 1)])
    yield "SZ-3-1-dictionary", bundle(both, dictionary_size=2**20 + 1)
    yield "SZ-3-2-dictionary", bundle([packed], raw, dictionary_flip=1)
    yield "SZ-3-3-no-use", bundle(both, raw)
    yield "SZ-4-1-head", bundle([first, second.changed(flip=1)])
    yield "SZ-4-1-compressed-head", bundle([packed.changed(flip=1)], raw)
    yield "SZ-4-2-other-dictionary", bundle([packed], raw[:40])
    yield "SZ-4-2-no-frame", bundle([first.changed(stored=first.head[:-1], stored_size=len(first.head) - 1)])
    yield "SZ-4-2-larger", bundle([packed.changed(index_size=packed.index_size - 1)], raw)
    yield "SZ-4-2-smaller", bundle([packed.changed(index_size=packed.index_size + 1)], raw)
    cut = packed.stored[:-1]
    yield "SZ-4-2-cut", bundle([packed.changed(stored=cut, stored_size=len(cut))], raw)
    longer = packed.stored + b"\0"
    yield "SZ-4-2-goes-on", bundle([packed.changed(stored=longer, stored_size=len(longer))], raw)


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 1
    files = {name: (pathlib.Path(sys.argv[1]) / f"{name}.sbrdf").read_bytes() for name in NAMES}
    for kind, vectors in (("accept", accepted(files)), ("reject", rejected(files))):
        folder = pathlib.Path(sys.argv[2]) / kind
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in vectors:
            path = folder / f"{name}.sbrdfz"
            if path.exists():
                continue
            path.write_bytes(content)
            if kind == "accept":
                rows = ",\n".join(f" {row}" for row in map(repr, summary_of(content))).replace("'", '"')
                path.with_suffix(".json").write_text(f"[\n{rows}\n]\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
