#!/usr/bin/env python3
"""Reference reader of bundles of sliced BRDFs, written from specs/sbrdfz.md alone.

usage: sbrdfz_reference.py BUNDLE [FOLDER]

Prints name, size and SHA-256 of every file in the bundle as JSON, and writes the files into FOLDER if one is given. Exit
codes: 0 ok, 2 a file cannot be read or written, 3 refused, 4 unsupported; messages begin with the rule that is broken.
"""
import hashlib
import json
import pathlib
import struct
import sys
import unicodedata
import zlib

import zstandard

MAGIC, SLICED_MAGIC = b"\x89SBRDZ\r\n", b"\x89SBF"
FRAME_MAGIC, DICTIONARY_MAGIC = b"\x28\xb5\x2f\xfd", b"\x37\xa4\x30\xec"


class Refused(Exception):
    """A file that breaks the rule `clause`; `unsupported` where another reader may know what this one does not."""

    def __init__(self, clause, message, unsupported=False):
        super().__init__(f"[{clause}] {message}")
        self.unsupported = unsupported


def need(condition, clause, message):
    if not condition:
        raise Refused(clause, message)


class Counts:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, size):
        need(self.at + size <= len(self.data), "SZ-2-1", "the index ends too early")
        self.at += size
        return self.data[self.at - size:self.at]

    def count(self):
        value, shift = 0, 0
        while True:
            byte = self.take(1)[0]
            value |= (byte & 127) << shift
            need(shift <= 56, "SZ-2-1", "a count of more than nine bytes")
            if byte < 128:
                need(byte != 0 or shift == 0, "SZ-2-1", "a count with a needless byte")
                return value
            shift += 7


def count(value):
    groups = bytearray()
    while value > 127:
        groups.append(value & 127 | 128)
        value >>= 7
    return bytes(groups) + bytes([value])


def check_name(name):
    need(1 <= len(name) <= 255, "SZ-2-3", f"a name of {len(name)} bytes")
    try:
        text = name.decode("utf-8")
    except UnicodeDecodeError as error:
        raise Refused("SZ-2-3", "a name that is not UTF-8") from error
    need(text not in (".", "..") and "/" not in text, "SZ-2-3", f"the name {text!r}")
    need(all(unicodedata.category(c) != "Cc" for c in text), "SZ-2-3", "a control character in a name")
    return text


class Material:
    def __init__(self, counts):
        self.name_bytes = counts.take(counts.count())
        self.index_size, self.stored_size, self.body_size = (counts.count() for _ in range(3))
        self.head_size = 2 + self.index_size

    def check(self):
        self.name = check_name(self.name_bytes)
        need(self.index_size <= 2**25, "SZ-2-5", "index too large")
        least = max(1, -(-self.head_size // 4096))
        need(least <= self.stored_size <= self.head_size, "SZ-2-6", f"{self.head_size} bytes in {self.stored_size}")

    def bundled_size(self):
        return self.stored_size + 4 + self.body_size

    def compressed(self):
        return self.stored_size < self.head_size


def checked(data, clause, message):
    """What is in front of its checksum."""
    need(zlib.crc32(data[:-4]) == struct.unpack("<I", data[-4:])[0], clause, message)
    return data[:-4]


class Bundle:
    def __init__(self, file):
        self.file = file
        need(file[:8] == MAGIC, "SZ-1-1", "not a bundle")
        need(len(file) >= 32, "SZ-1-4", "the file ends within its header")
        major, self.minor, index_size, file_size, index_checksum, header_checksum = struct.unpack_from("<HHIQII", file, 8)
        need(zlib.crc32(file[:28]) == header_checksum, "SZ-1-2", "checksum of the header")
        if major != 1:
            raise Refused("SZ-1-3", f"major version {major}", unsupported=True)
        need(file_size == len(file), "SZ-1-4", f"{len(file)} bytes, the header says {file_size}")
        need(index_size <= min(2**24, len(file) - 32), "SZ-1-5", f"index of {index_size} bytes")
        index = file[32:32 + index_size]
        need(zlib.crc32(index) == index_checksum, "SZ-1-6", "checksum of the index")
        self.read_index(index)
        self.read_dictionary(32 + index_size)

    def read_index(self, index):
        counts = Counts(index)
        number = counts.count()
        self.dictionary_size = counts.count()
        need(1 <= number <= min(2**20, len(index) // 5), "SZ-2-2", f"{number} materials")
        need(self.dictionary_size <= 2**20, "SZ-3-1", f"a dictionary of {self.dictionary_size} bytes")
        self.materials = []
        for _ in range(number):
            material = Material(counts)
            material.check()
            need(not self.materials or self.materials[-1].name_bytes < material.name_bytes, "SZ-2-4", "names do not rise")
            self.materials.append(material)
        need(counts.at == len(index) or self.minor > 0, "SZ-2-1", "the index goes on behind its last material")

    def read_dictionary(self, at):
        end = at + (self.dictionary_size + 4 if self.dictionary_size else 0)
        size = end + sum(material.bundled_size() for material in self.materials)
        need(size == len(self.file) or (self.minor > 0 and size < len(self.file)), "SZ-2-7", f"the parts end at {size}")
        self.dictionary = None
        if self.dictionary_size:
            need(any(material.compressed() for material in self.materials), "SZ-3-3", "no head needs the dictionary")
            content = checked(self.file[at:end], "SZ-3-2", "checksum of the dictionary")
            made = content[:4] == DICTIONARY_MAGIC
            kind = zstandard.DICT_TYPE_FULLDICT if made else zstandard.DICT_TYPE_RAWCONTENT
            self.dictionary = zstandard.ZstdCompressionDict(content, dict_type=kind)
        for material in self.materials:
            material.at = end
            end += material.bundled_size()

    def head(self, material):
        end = material.at + material.stored_size + 4
        stored = checked(self.file[material.at:end], "SZ-4-1", f"checksum of the head of {material.name}")
        if not material.compressed():
            return stored
        try:
            decompressor = zstandard.ZstdDecompressor(dict_data=self.dictionary).decompressobj()
            head = decompressor.decompress(FRAME_MAGIC + stored)
        except zstandard.ZstdError as error:
            raise Refused("SZ-4-2", f"{material.name}: {error}") from error
        whole = decompressor.eof and not decompressor.unused_data
        need(whole and len(head) == material.head_size, "SZ-4-2", f"{material.name}: {len(head)} bytes")
        return head

    def files(self):
        """Names and bytes of the `.sbrdf` files."""
        for material in self.materials:
            head = self.head(material)
            start = SLICED_MAGIC + head[:2] + count(material.index_size) + head[2:]
            body = self.file[material.at + material.stored_size + 4:material.at + material.bundled_size()]
            yield material.name, start + struct.pack("<I", zlib.crc32(start)) + body


def summary_of(file):
    return [{"name": name, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
            for name, content in Bundle(file).files()]


def main():
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 1
    try:
        file = pathlib.Path(sys.argv[1]).read_bytes()
        print(json.dumps(summary_of(file), indent=1))
        for name, content in Bundle(file).files() if len(sys.argv) == 3 else ():
            (pathlib.Path(sys.argv[2]) / f"{name}.sbrdf").write_bytes(content)
    except OSError as error:
        print(error, file=sys.stderr)
        return 2
    except Refused as refused:
        print(refused, file=sys.stderr)
        return 4 if refused.unsupported else 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
