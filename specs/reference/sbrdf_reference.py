#!/usr/bin/env python3
"""Reference decoder of sliced BRDF files, written from specs/sbrdf.md and specs/conventions.md alone.

usage: sbrdf_reference.py FILE [--values OUT.f32] [--positions OUT.u32] [--eval PAIRS.csv]

Prints what the file holds as JSON, or with --eval what `sbrdf eval` prints (sbrdf_evaluation.py). Exit codes: 0 ok, 2
the file cannot be read, 3 refused, 4 unsupported; messages begin with the rule that is broken.
  --values     little-endian float32: crossings by number, samples slice by slice, the guide's; channel fastest
  --positions  little-endian u32: number of samples of each slice, then interval and fraction of every sample, slice by
               slice, then those of the guide, its nodes (fraction 0) included; with a mask its frame, the cells along
               its axes, and the lengths of its runs
  --eval       pairs of directions: CSV whose header begins with theta_i,phi_i,theta_v,phi_v, in degrees

Slow and plain on purpose: whole numbers are Python's, f64 arithmetic is written out in the order that the page states.
"""
import argparse
import contextlib
import json
import math
import struct
import sys
import zlib

import numpy
import zstandard

MAGIC = b"\x89SBF"
ELEVATION, HALF_DIFFERENCE = 1, 2
MAX_STEP = 2**31 - 1
FRACTIONS = 65536
RESIDUAL_CONTEXTS, FLAG_CONTEXTS, DISTRIBUTIONS = 66, 48, 112
KINDS = ("axial", "diagonal", "horizontal", "vertical")
DICTIONARY = (
    b'"zero_values":0,"negative_values":0,"symmetrised":true,"reciprocity_residual_percent":0.0,"error_bef'
    b'ore_rounding":{"coded_before_percent":[0.1],"error_of_whole":{"extracted":{"theta_max_deg":,"max_lev'
    b'el":,"difference_from_whole_percent":"extracted_before":[{"values_all_zero":true"findings":[{"what":'
    b'"negative stored rgb values","count":,"total":}],"refinement":"measured","description":"MERL table, '
    b'isotropic, half/difference angles","description":"Kurt model , 2 lobes","command":"sbrdf convert kur'
    b't:.bsdf .sbrdf --metadata full --samples --precision 0.1% --placement 14/36","symmetrised":false,"re'
    b'finement":"true","zero_values":0,"negative_values":0,"directions":12000,"measured_on":"random direct'
    b'ions that took no part in any choice, theta up to 80 degrees"}}{"source":{"format":"merl","sha256":"'
    b'{"source":{"format":"kurt"},"error":{"mre_percent":0.{"source":{"format":"rgl","sha256":""},"recipro'
    b'city_residual_percent":,"error":{"mre_percent":0.,"rel_l1_percent":0.}}')


class Refused(Exception):
    """A file that breaks the rule `clause`; `unsupported` where another reader may know what this one does not."""

    def __init__(self, clause, message, unsupported=False):
        super().__init__(f"[{clause}] {message}")
        self.unsupported = unsupported


def need(condition, clause, message):
    if not condition:
        raise Refused(clause, message)


def known(condition, clause, message):
    if not condition:
        raise Refused(clause, message, unsupported=True)


def as_f32(x):
    """`x` rounded to f32, as a Python float; infinite where it is too large."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)


# ---- 1. Container ----------------------------------------------------------------------------------------------------


def count_in(data, at, clause, most=2**32):
    """A number and where the next field begins."""
    value, shift = 0, 0
    while True:
        need(at < len(data), clause, "the file ends within a count")
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        need(value < most and shift < 35, clause, f"a count of {most} or more")
        if byte < 128:
            need(byte != 0 or shift == 0, clause, "a count with a needless byte")
            return value, at
        shift += 7


class Container:
    """Header fields, the bytes of the index, and the whole file for its chunks."""

    def __init__(self, file):
        need(file[:4] == MAGIC, "SB-1-1", "not a sliced BRDF file")
        need(len(file) >= 6, "SB-1-4", "the file ends within its header")
        self.major, self.minor = file[4:6]
        known(self.major == 1, "SB-1-3", f"major version {self.major}")
        need(len(file) >= 10, "SB-1-4", "the file ends within its head")
        size, at = count_in(file, 6, "SB-1-5", 2**25 + 1)
        end = at + size
        need(len(file) >= end + 4, "SB-1-4", "the file ends within its head")
        need(zlib.crc32(file[:end]) == struct.unpack_from("<I", file, end)[0], "SB-1-6", "checksum of the head")
        self.index = file[at:end]
        self.file = file
        self.chunks_begin = end + 4


def payload_of(chunk):
    need(len(chunk) >= 5, "SB-1-7", f"chunk of {len(chunk)} bytes")
    need(zlib.crc32(chunk[:-4]) == struct.unpack("<I", chunk[-4:])[0], "SB-1-7", "checksum of a chunk")
    return chunk[:-4]


# ---- 2. Index --------------------------------------------------------------------------------------------------------


class IndexReader:
    """Fields in order; one that is not all there, or a count that is not in its shortest form, breaks SB-2-1."""

    def __init__(self, data):
        self.data = data
        self.at = 0

    def left(self):
        return len(self.data) - self.at

    def take(self, size):
        need(size <= self.left(), "SB-2-1", "the index ends too early")
        self.at += size
        return self.data[self.at - size:self.at]

    def numbers(self, form, count):
        return struct.unpack(f"<{count}{form}", self.take(count * struct.calcsize("<" + form)))

    def number(self, form):
        return self.numbers(form, 1)[0]

    def count(self, most=2**32):
        value, self.at = count_in(self.data, self.at, "SB-2-1", most)
        return value

    def signed(self):
        folded = self.count(2**33)
        return folded // 2 if folded % 2 == 0 else -(folded + 1) // 2


class Index:
    """All fields of the index, checked one by one."""

    def __init__(self, container):
        reader = IndexReader(container.index)
        self.read_frame(reader)
        self.parts = reader.number("B")
        known(self.parts < 32, "SB-2-16", f"parts {self.parts}")
        known(self.frame == HALF_DIFFERENCE or not self.parts & 8, "SB-2-16", "theta_max in the elevation frame")
        self.theta_max = 80.0 if self.frame == HALF_DIFFERENCE else self.nodes[3][-1]
        if self.parts & 8:
            self.theta_max = reader.count() / 100
        self.mask = None
        if self.parts & 16:
            self.read_mask(reader)
        self.read_precision(reader)
        self.read_channels(reader)
        self.read_amounts(reader)
        self.read_statistics(reader)
        self.read_metadata(reader)
        self.read_layout(reader)
        if container.minor == 0:
            need(reader.left() == 0, "SB-2-1", f"{reader.left()} bytes behind the index")
        self.check_nodes()
        self.check_amounts(len(container.file))

    def read_frame(self, reader):
        bits = reader.number("B")
        self.frame, self.symmetries = bits & 15, bits >> 4
        known(self.frame in (ELEVATION, HALF_DIFFERENCE), "SB-2-2", f"frame {self.frame}")
        known(self.symmetries < 8, "SB-2-3", f"symmetries {self.symmetries}")
        turns = (360, 360 if self.frame == ELEVATION else 180, None, None)
        self.nodes = []
        for axis, turn in enumerate(turns):
            if axis == 0 and self.isotropic:
                self.nodes.append([0.0])
            elif axis == 3 and self.frame == ELEVATION:
                self.nodes.append(self.nodes[2])
            else:
                self.nodes.append(self.read_nodes(reader, turn))

    @property
    def isotropic(self):
        return bool(self.symmetries & 1)

    @property
    def whole(self):
        return not self.parts & 2

    @staticmethod
    def read_nodes(reader, turn):
        count = reader.count()
        form = reader.number("B")
        need(1 <= count <= 4096, "SB-2-4", f"{count} nodes")
        equal, unit = 32 <= form < 64, form - 32 if 32 <= form < 64 else form
        need(unit <= 20 or (unit == 64 and turn) or unit in (65, 66), "SB-2-4", f"form {form} of nodes")
        if unit == 64:
            return [k * (turn / count) for k in range(count)]
        if unit == 66:
            return list(reader.numbers("d", count))
        whole, difference = [0], 0
        for k in range(1, count):
            difference = difference if equal and k > 1 else reader.count()
            whole.append(whole[-1] + difference)
        return [x / 100 if unit == 65 else x / 2**unit for x in whole]

    def read_mask(self, reader):
        frame = reader.number("B")
        counts = [reader.count() for _ in range(4)]
        size = reader.count()
        known(frame in (1, 2), "SB-2-17", f"mask of frame {frame}")
        need(all(1 <= count <= 4096 for count in counts), "SB-2-17", f"mask of {counts} cells")
        need(math.prod(counts) <= 2**26, "SB-2-17", f"mask of {counts} cells")
        need(1 <= size <= 2**27, "SB-2-17", f"mask of {size} bytes")
        self.mask = (frame, counts, size)

    def check_nodes(self):
        need(0 < self.theta_max <= 90, "SB-2-4", f"theta_max {self.theta_max}")
        diagonal_end = 360 if self.frame == ELEVATION else 180
        for axis, nodes in enumerate(self.nodes):
            need(all(math.isfinite(x) for x in nodes), "SB-2-4", f"axis {axis}: nodes are not finite")
            need(nodes[0] == 0, "SB-2-4", f"axis {axis} begins with {nodes[0]}")
            need(all(b - a >= 0.001 for a, b in zip(nodes, nodes[1:])), "SB-2-4", f"axis {axis}: nodes do not rise")
            greatest = (360 - 0.001, diagonal_end - 0.001, 90, 90)[axis]
            need(nodes[-1] <= greatest, "SB-2-4", f"axis {axis} ends with {nodes[-1]}")
        if self.frame == ELEVATION:
            places = {rounded(u) for u in self.nodes[1]}
            need(all(rounded(360 - u) in places for u in self.nodes[1][1:]), "SB-2-4", "no node at 360 less another")
        points = math.prod(len(axis) for axis in padded_axes(self.frame, self.isotropic, self.nodes))
        known(points <= 2**21, "SB-2-4", f"{points} lattice points")

    def read_channels(self, reader):
        domain = reader.number("B")
        self.domain = domain & ~16
        known(self.domain in (1, 2), "SB-2-5", f"domain {self.domain}")
        count = reader.count()
        need(count <= 4096, "SB-2-6", f"{count} channels")
        self.channels = [] if count else ["R", "G", "B"]
        for _ in range(count):
            self.channels.append(reader.take(reader.count()).decode("utf-8", errors="replace"))
        self.grey = [reader.count() for _ in self.channels] if domain & 16 else []
        need(all(share <= 1024 for share in self.grey), "SB-2-18", "a share of grey above 1024")
        need(not domain & 16 or any(self.grey), "SB-2-18", "all shares of grey are 0")
        self.ranges = []
        for _ in self.channels:
            least = reader.signed()
            values = [self.scale.value(step, "SB-2-8") for step in (least, least + reader.count())]
            self.ranges.append(values)
        self.references, self.halvings = [], None
        if self.domain == 2:
            for _ in self.channels:
                self.references.append(self.scale.value(reader.count(), "SB-2-7"))
                need(self.references[-1] > 0, "SB-2-7", f"reference {self.references[-1]}")
            self.halvings = reader.number("B")

    def read_amounts(self, reader):
        self.guide_ratio, self.guide_count = None, 0
        if self.parts & 1:
            self.guide_ratio = 1.0 if self.isotropic else reader.number("d")
            self.guide_count = reader.count()
            need(0.001 <= self.guide_ratio <= 1000, "SB-2-9", f"guide of ratio {self.guide_ratio}")
            need(self.guide_count <= 2**20, "SB-2-9", f"guide of {self.guide_count} samples")
            need(self.frame == HALF_DIFFERENCE and self.domain == 2, "SB-2-9", "guide in this frame or domain")
        self.sample_count = reader.count()
        need(self.sample_count <= 2**26, "SB-2-14", f"{self.sample_count} samples")

    def check_amounts(self, file_size):
        sizes = [len(nodes) for nodes in self.nodes]
        crossings = sizes[0] * sizes[1] * max(1, sizes[2] - 1) * max(1, sizes[3] - 1) // 8
        values = (crossings + self.sample_count + self.guide_count) * len(self.channels)
        need(values <= 65536 + 1536 * file_size, "SB-2-14", f"{values} values in {file_size} bytes")

    def read_precision(self, reader):
        millionths = reader.count()
        need(millionths <= 500000, "SB-2-11", f"bound of {millionths} millionths")
        lowest = reader.signed() if millionths else 0
        need(abs(lowest) <= 2**29, "SB-2-11", f"lowest step {lowest}")
        self.scale = StepScale(millionths, lowest)

    def read_statistics(self, reader):
        self.base_channel = reader.count()
        need(self.base_channel < len(self.channels), "SB-2-12", f"base channel {self.base_channel}")
        self.activity_shift = reader.number("B")
        need(self.activity_shift <= 31, "SB-2-12", f"activity shift {self.activity_shift}")
        self.token_count = reader.number("B")
        need(16 <= self.token_count <= 74, "SB-2-12", f"{self.token_count} tokens")
        self.distributions = []
        for group in range(4):
            used = (group < 2 or self.sample_count) and (group % 2 == 0 or len(self.channels) > 1)
            self.distributions += self.read_group(reader) if used else [0] * 16
        self.distributions += [reader.number("B") if self.parts & 1 else 0 for _ in range(2)]
        need(max(self.distributions) < DISTRIBUTIONS, "SB-2-12", "number of a distribution")
        self.flags = [0] * FLAG_CONTEXTS
        if self.sample_count or self.parts & 1:
            bits = reader.number("B")
            depths, each = bits & ~8, bool(bits & 8)
            need(depths <= 6, "SB-2-12", f"flags of {depths} depths")
            for k in range(8 * depths):
                self.flags[k] = reader.number("B") if each or k % 8 == 0 else self.flags[k - 1]

    @staticmethod
    def read_group(reader):
        bits = reader.number("B")
        packed = reader.take(8) if bits & 128 else bytes([0x88] * 8)
        off = [nibble - 8 for byte in packed for nibble in (byte & 15, byte >> 4)]
        widths = [min(max((bits & 63) + c - 16 + off[c], 0), 55) for c in range(16)]
        return [2 * width + (bits >> 6 & 1) for width in widths]

    def read_metadata(self, reader):
        self.metadata, self.metadata_size = b"", 0
        if self.parts & 4:
            self.metadata_size = reader.count()
            packed = reader.count()
            need(self.metadata_size <= 2**24, "SB-2-15", f"metadata of {self.metadata_size} bytes")
            self.metadata = reader.take(packed)

    def read_layout(self, reader):
        self.pieces, self.blocks = [1], [[0] * 4] * 5
        if self.whole:
            self.chunk_sizes = [reader.count() for _ in range(1 + (self.mask is not None))]
            return
        count = reader.count()
        need(1 <= count <= 16, "SB-2-13", f"{count} pieces")
        self.pieces = list(reader.numbers("B", count))
        rising = all(a < b for a, b in zip(self.pieces, self.pieces[1:]))
        need(self.pieces[0] == 1 and rising and self.pieces[-1] <= 16, "SB-2-13", f"pieces {self.pieces}")
        self.blocks = [[reader.count() for _ in range(4)] for _ in range(5)]
        count = reader.count()
        need(count <= reader.left(), "SB-2-15", f"{count} chunks")
        self.chunk_sizes = [reader.count() for _ in range(count)]


# ---- 9. Numbering of crossings and slices ----------------------------------------------------------------------------


def padded_axes(frame, isotropic, nodes):
    axes = [list(axis) for axis in nodes]
    if len(axes[0]) > 1 and not isotropic:
        axes[0] = axes[0] + [x + 360 for x in axes[0]] + [720.0] if frame == ELEVATION else axes[0] + [360.0]
    if len(axes[1]) > 1:
        axes[1] = axes[1] + [360.0 if frame == ELEVATION else 180.0]
    return axes


def rounded(degrees):
    """In units of 1e-6 degrees."""
    return math.floor(degrees * 1e6 + 0.5)


def modulo(x, period):
    """The remainder and the number of whole periods taken off. Just below a period counts as the period."""
    turns = math.floor(x / period)
    rest = x - turns * period
    if period - rest < 1e-9:
        return 0.0, turns + 1
    return rest, turns


class Place:
    """A lattice point or a line: coordinate k is offset[k] + slope[k] p; a point has no slopes."""

    def __init__(self, offset, slope):
        self.offset = list(offset)
        self.slope = list(slope)

    def fixed_at_zero(self, axis):
        return self.slope[axis] == 0 and self.offset[axis] == 0

    def clear(self, axis):
        self.offset[axis], self.slope[axis] = 0.0, 0

    def negate(self, axis, plus=0.0):
        self.offset[axis], self.slope[axis] = plus - self.offset[axis], -self.slope[axis]

    def add(self, axis, other, sign):
        self.offset[axis] += sign * self.offset[other]
        self.slope[axis] += sign * self.slope[other]

    def moving_axis(self):
        return next((axis for axis in range(4) if self.slope[axis] != 0), 4)

    def key(self):
        coordinates = [-1 if self.slope[axis] else rounded(self.offset[axis]) for axis in (3, 2, 1, 0)]
        return (self.moving_axis(), *coordinates)


class Symmetry:
    """Images of points and lines in normal form."""

    def __init__(self, frame, symmetries):
        self.frame = frame
        self.isotropic = bool(symmetries & 1)
        present = [frame == ELEVATION, bool(symmetries & 2), bool(symmetries & 4)]
        self.combinations = [m for m in range(8) if all(present[bit] or not m >> bit & 1 for bit in range(3))]

    def images(self, place):
        for combination in self.combinations:
            image = Place(place.offset, place.slope)
            if combination & 1:
                image.negate(1)
                image.offset[2], image.offset[3] = image.offset[3], image.offset[2]
                image.slope[2], image.slope[3] = image.slope[3], image.slope[2]
            if combination & 2:
                image.negate(0)
                image.negate(1)
            if combination & 4:
                image.negate(0, 360.0 if self.frame == ELEVATION else 180.0)
                image.negate(1)
            if self.frame == ELEVATION:
                self.normalise_elevation(image)
            else:
                self.normalise_half_difference(image)
            yield image

    def normalise_elevation(self, image):
        light_up, viewer_up = image.fixed_at_zero(3), image.fixed_at_zero(2)
        if self.isotropic:
            image.clear(0)
        if (light_up and viewer_up) or (self.isotropic and (light_up or viewer_up)):
            image.clear(0)
            image.clear(1)
        elif light_up:
            image.add(0, 1, -1)
            image.clear(1)
        elif viewer_up:
            image.add(0, 1, +1)
            image.clear(1)
        s, u = image.offset[0], image.offset[1]
        if self.isotropic:
            u, _ = modulo(u, 360)
        elif image.slope[1] != 0:
            s, turns = modulo(s, 360)
            u, _ = modulo(u - 360 * turns, 720)
        else:
            u, turns = modulo(u, 360)
            s, _ = modulo(s - 360 * turns, 720)
        image.offset[0], image.offset[1] = s, u

    def normalise_half_difference(self, image):
        if self.isotropic:
            image.clear(0)
        if image.fixed_at_zero(2):
            image.clear(1)
        if image.fixed_at_zero(3):
            if self.isotropic:
                image.clear(1)
            elif not image.fixed_at_zero(2):
                image.add(1, 0, +1)
            image.clear(0)
        image.offset[0], _ = modulo(image.offset[0], 360)
        image.offset[1], _ = modulo(image.offset[1], 180)

    def representative(self, place):
        """The image with the least key, and that key."""
        best, best_key = None, None
        for image in self.images(place):
            key = image.key()
            if best is None or key < best_key:
                best, best_key = image, key
        return best, best_key

    def full_turn(self, axis):
        if self.frame == HALF_DIFFERENCE:
            return 360 if axis == 0 else 180
        return 360 if self.isotropic else 720


class Slice:
    """One slice: its place in the lattice, its extent, and its nodes as (position, crossing)."""

    def __init__(self, line, first_indices, symmetry, axes):
        self.kind = line.moving_axis()
        self.indices = first_indices
        self.line = line
        self.nodes = []
        self.mode, self.start, self.length = self.extent(symmetry, axes)

    def extent(self, symmetry, axes):
        if self.kind >= 2:
            return "bounded", 0.0, axes[self.kind][-1]
        itself = Place(self.line.offset, self.line.slope)
        itself.offset[self.kind], itself.slope[self.kind] = 0.0, 1
        period = symmetry.full_turn(self.kind)
        mirrors = []
        for image in symmetry.images(itself):
            if image.key() != itself.key():
                continue
            if image.slope[self.kind] > 0:
                period = math.gcd(period, round(image.offset[self.kind]))
            else:
                mirrors.append(image.offset[self.kind])
        if not mirrors:
            return "periodic", 0.0, float(period)
        return "mirrored", modulo(min(mirrors), period)[0] / 2, period / 2

    def bring_into_extent(self, x):
        if self.mode == "bounded":
            return x
        if self.mode == "periodic":
            return modulo(x, self.length)[0]
        x, _ = modulo(x - self.start, 2 * self.length)
        return self.start + (2 * self.length - x if x > self.length else x)

    def set_nodes(self, points):
        """`points` are (position, crossing) as met; of those at the same place the first is kept."""
        met = {}
        for position, crossing in points:
            position = self.bring_into_extent(position)
            met.setdefault(rounded(position), (position, crossing))
        self.nodes = [met[place] for place in sorted(met)]
        if self.mode == "mirrored":
            ends = (self.nodes[0][0] - self.start, self.start + self.length - self.nodes[-1][0])
            known(max(ends) < 1e-6, "SB-2-4", "a mirrored slice without a node at one of its ends")

    def interval_ends(self, interval):
        """Positions of the crossings around an interval."""
        first = self.nodes[interval][0]
        if interval + 1 < len(self.nodes):
            return first, self.nodes[interval + 1][0]
        return first, self.nodes[0][0] + self.length


class Lattice:
    """Crossings and slices of a frame."""

    def __init__(self, index):
        self.symmetry = Symmetry(index.frame, index.symmetries)
        self.axes = padded_axes(index.frame, index.isotropic, index.nodes)
        self.sizes = [len(axis) for axis in self.axes]
        self.crossing_at = {}  # of lattice indices
        self.crossing_indices = []  # where a crossing is first met
        self.crossing_coordinates = []
        self.slices = []
        self.crossing_numbers = {}  # of keys
        self.slice_numbers = {}
        self.number_crossings()
        self.number_slices()

    def walk(self, sizes):
        for k3 in range(sizes[3]):
            for k2 in range(sizes[2]):
                for k1 in range(sizes[1]):
                    for k0 in range(sizes[0]):
                        yield k0, k1, k2, k3

    def number_crossings(self):
        numbers = self.crossing_numbers
        for indices in self.walk(self.sizes):
            point = Place([self.axes[axis][k] for axis, k in enumerate(indices)], [0] * 4)
            standing, key = self.symmetry.representative(point)
            if key not in numbers:
                numbers[key] = len(numbers)
                self.crossing_indices.append(indices)
                self.crossing_coordinates.append(standing.offset)
            self.crossing_at[indices] = numbers[key]

    def number_slices(self):
        numbers, points = self.slice_numbers, []
        for axis in range(4):
            if self.sizes[axis] == 1:
                continue
            others = [1 if other == axis else size for other, size in enumerate(self.sizes)]
            for indices in self.walk(others):
                offset = [0.0 if other == axis else self.axes[other][k] for other, k in enumerate(indices)]
                line = Place(offset, [int(other == axis) for other in range(4)])
                standing, key = self.symmetry.representative(line)
                if standing.moving_axis() == 4:
                    continue
                if key not in numbers:
                    numbers[key] = len(numbers)
                    self.slices.append(Slice(standing, indices, self.symmetry, self.axes))
                    points.append([])
                slope, start = standing.slope[standing.moving_axis()], standing.offset[standing.moving_axis()]
                for k, p in enumerate(self.axes[axis]):
                    crossing = self.crossing_at[indices[:axis] + (k,) + indices[axis + 1:]]
                    points[numbers[key]].append((slope * p + start, crossing))
        for piece, met in zip(self.slices, points):
            piece.set_nodes(met)

    def standing_for(self, offset, slope):
        """What stands for a line or a point: its place, and the number of the slice or, if it does not move, crossing."""
        standing, key = self.symmetry.representative(Place(offset, slope))
        return standing, (self.crossing_numbers if standing.moving_axis() == 4 else self.slice_numbers)[key]


# ---- 3. Chunks and their order ---------------------------------------------------------------------------------------


def blocks_of(members, block_sizes):
    """Lists of the numbers of `members` (number, lattice indices) of each block, in order."""
    blocks = {}
    for number, indices in members:
        place = tuple(k // size if size else 0 for k, size in zip(indices, block_sizes))
        blocks.setdefault(place[::-1], []).append(number)
    return [blocks[place] for place in sorted(blocks)]


def payloads(container, index, count):
    """Payload of every chunk, None for one left out."""
    sizes = index.chunk_sizes
    count = (1 if index.whole else count) + (index.mask is not None)
    need(len(sizes) == count, "SB-3-1", f"{len(sizes)} chunks, {count} expected")
    end = container.chunks_begin + sum(sizes)
    exact = end == len(container.file) if container.minor == 0 else end <= len(container.file)
    need(exact, "SB-3-2", f"chunks end at {end}, the file at {len(container.file)}")
    found, at = [], container.chunks_begin
    for size in sizes:
        found.append(payload_of(container.file[at:at + size]) if size else None)
        at += size
    return found


# ---- 4. Steps of values ---------------------------------------------------------------------------------------------


class StepScale:
    """Values of steps."""

    def __init__(self, millionths, lowest):
        self.lossless = millionths == 0
        self.bound = millionths / 1e6
        self.per_octave = 2**23
        if self.lossless:
            return
        self.lowest = lowest
        left = self.bound - 2.0**-24
        widest = (1 + left) / (1 - left)
        self.per_octave, reached = 0, 1.0
        while reached < 2:
            self.per_octave, reached = self.per_octave + 1, reached * widest
        self.step_ratio = self.root_of_two()
        self.series = [1.0]
        while len(self.series) < self.per_octave:
            self.series.append(self.series[-1] * self.step_ratio)
        self.guide_step = 2.0**-(1 + self.per_octave.bit_length())

    def root_of_two(self):
        low, high = 1.0, 2.0
        while True:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                return high
            product = 1.0
            for _ in range(self.per_octave):
                product = product * middle
            low, high = (middle, high) if product < 2 else (low, middle)

    def magnitude(self, step):
        if step == 0:
            return 0.0
        if self.lossless:
            return struct.unpack("<f", struct.pack("<I", step))[0] if step < 2**31 else math.inf
        octave, place = divmod(step - 1 + self.lowest, self.per_octave)
        try:
            return as_f32(math.ldexp(self.series[place], octave))
        except OverflowError:
            return math.inf

    def value(self, step, clause="SB-8-4"):
        magnitude = self.magnitude(abs(step))
        need(abs(step) <= MAX_STEP and math.isfinite(magnitude), clause, "a value is not finite")
        return -magnitude if step < 0 else magnitude

    def guide_value(self, step):
        return self.value(step) if self.lossless else as_f32(step * self.guide_step)


# ---- 5. Entropy coding -----------------------------------------------------------------------------------------------


def token_span(token):
    """First of the numbers that a token stands for, and how many plain bits choose among them."""
    if token < 16:
        return token, 0
    e = 4 + (token - 16) // 2
    return 2**e + ((token - 16) % 2) * 2**(e - 1), e - 1


def distribution(d, token_count):
    """Frequencies of the tokens, which sum to 4096."""
    width = 0.25
    for _ in range(d // 2):
        width = width * math.sqrt(2.0)
    weights = []
    for token in range(token_count):
        first, bits = token_span(token)
        size = 2**bits
        m = (first + size // 2 + 1) // 2
        if d % 2 == 0:
            q, power = width / (width + 1), 1.0
            while m:
                if m & 1:
                    power = power * q
                q = q * q
                m >>= 1
            weights.append(size * power)
        else:
            v = 1 + (m / width) * (m / width)
            weights.append(size * (1 / (v * v)))
    total = 0.0
    for weight in weights:
        total = total + weight
    frequencies = [1 + math.floor(weight / total * (4096 - token_count)) for weight in weights]
    frequencies[frequencies.index(max(frequencies))] += 4096 - sum(frequencies)
    return frequencies


class TokenTable:
    """Token, start and frequency of each of the 4096 places."""

    def __init__(self, frequencies):
        self.places = []
        start = 0
        for token, frequency in enumerate(frequencies):
            self.places += [(token, start, frequency)] * frequency
            start += frequency


class Stream:
    """One rANS stream. Every error is a breach of `clause`."""

    def __init__(self, payload, clause):
        self.clause = clause
        need(len(payload) >= 4 and len(payload) % 2 == 0, clause, f"stream of {len(payload)} bytes")
        self.state = struct.unpack_from("<I", payload)[0]
        self.words = struct.unpack_from(f"<{len(payload) // 2 - 2}H", payload, 4)
        self.next_word = 0
        need(self.state >= 2**16, clause, "first state of a stream")

    def advance(self, start, frequency):
        self.state = frequency * (self.state >> 12) + (self.state & 4095) - start
        if self.state < 2**16:
            need(self.next_word < len(self.words), self.clause, "a stream ends too early")
            self.state = self.state << 16 | self.words[self.next_word]
            self.next_word += 1

    def flag(self, probability):
        yes = (self.state & 4095) < 16 * probability
        self.advance(*((0, 16 * probability) if yes else (16 * probability, 4096 - 16 * probability)))
        return yes

    def plain_bits(self, count):
        value, shift = 0, 0
        while shift < count:
            bits = min(12, count - shift)
            piece = (self.state & 4095) >> (12 - bits)
            self.advance(piece << (12 - bits), 1 << (12 - bits))
            value |= piece << shift
            shift += bits
        return value

    def residual(self, table):
        token, start, frequency = table.places[self.state & 4095]
        self.advance(start, frequency)
        first, bits = token_span(token)
        z = first + self.plain_bits(bits)
        return z // 2 if z % 2 == 0 else -(z + 1) // 2

    def end(self):
        need(self.next_word == len(self.words), self.clause, "a stream goes on behind its last symbol")
        need(self.state == 2**16, self.clause, "last state of a stream")


# ---- 6. Prediction ---------------------------------------------------------------------------------------------------


class Sample:
    """Steps and sizes of residuals of the channels, and where the sample lies on its slice."""

    def __init__(self, steps, residuals, depth=0, interval=0, fraction=0, position=0.0):
        self.steps = steps
        self.residuals = residuals
        self.depth = depth
        self.interval = interval
        self.fraction = fraction
        self.position = position

    def on_slice(self, interval, position):
        """This crossing as a node of a slice."""
        return Sample(self.steps, self.residuals, 0, interval, 0, position)


class Stencil:
    """Known members, their weights and their spread."""

    def __init__(self, members, weights, spread):
        self.members = members
        self.weights = weights
        self.spread = spread

    @staticmethod
    def at(x, members, positions, base_channel):
        weights = []
        for k, x_k in enumerate(positions):
            weight = 1.0
            for j, x_j in enumerate(positions):
                if j != k:
                    weight = weight * ((x - x_j) / (x_k - x_j))
            weights.append(weight)
        return Stencil(members, weights, spread_of([member.steps[base_channel] for member in members]))


def spread_of(steps):
    n = len(steps)
    if n < 2:
        return 2**28
    total = sum(steps)
    return 4 * sum(abs(n * step - total) for step in steps) // n**2


def round_within(x):
    return math.floor(min(max(x, float(-MAX_STEP)), float(MAX_STEP)) + 0.5)


class SampleCoder:
    """Reads the channels of one sample after another."""

    def __init__(self, index):
        self.base = index.base_channel
        self.channel_count = len(index.channels)
        self.shift = index.activity_shift + 3
        self.start_term = (index.scale.per_octave / 12) * (index.scale.per_octave / 12)
        tables = {d: TokenTable(distribution(d, index.token_count)) for d in set(index.distributions)}
        self.tables = [tables[d] for d in index.distributions]
        self.flags = index.flags

    def activity_class(self, activity):
        v = activity >> self.shift
        if v == 0:
            return 0
        o = v.bit_length() - 1
        h = v >> (o - 1) & 1 if o else 0
        return min(15, 1 + 2 * o + h)

    def flag(self, stream, depth, left, right, before):
        activity = 8 * (left.residuals[self.base] + right.residuals[self.base])
        context = (8 * (min(depth, 6) - 1) + 2 * min(3, (self.activity_class(activity) + 2) // 4) + int(before))
        return stream.flag(self.flags[context])

    def channels(self, stream, stencil, base_context, other_context, classes=True):
        """Steps and sizes of residuals at the place of a stencil."""
        members, n, base = stencil.members, len(stencil.members), self.base
        steps, sizes = [0] * self.channel_count, [0] * self.channel_count

        def read(channel, prediction, context, activity):
            context += self.activity_class(activity) if classes else 0
            residual = stream.residual(self.tables[context])
            steps[channel] = round_within(prediction) + residual
            need(-MAX_STEP - 1 <= steps[channel] <= MAX_STEP, stream.clause, "a step outside the range of an i32")
            sizes[channel] = min(abs(residual), MAX_STEP)

        def weighted(channel):
            total = 0.0
            for weight, member in zip(stencil.weights, members):
                total = total + weight * member.steps[channel]
            return total

        def mean(channel):
            return float(sum(member.steps[channel] for member in members)) / n if n else 0.0

        def mean_residual(channel):
            return sum(member.residuals[channel] for member in members) // n if n else 0

        base_prediction = weighted(base)
        read(base, base_prediction, base_context, 16 * mean_residual(base) + stencil.spread)
        before, base_mean = 0, mean(base)
        for channel in range(self.channel_count):
            if channel == base:
                continue
            channel_mean = mean(channel)
            x = y = self.start_term
            for member in members:
                base_part = member.steps[base] - base_mean
                x = x + base_part * (member.steps[channel] - channel_mean)
                y = y + base_part * base_part
            prediction = weighted(channel) + (x / y) * (steps[base] - base_prediction)
            read(channel, prediction, other_context, 16 * mean_residual(channel) + sizes[base] // 2 + 16 * before)
            before = sizes[channel]
        return steps, sizes


class CrossingReader:
    """Crossings, block by block."""

    def __init__(self, lattice, coder):
        self.lattice = lattice
        self.coder = coder
        self.samples = [None] * len(lattice.crossing_indices)
        greatest = max(lattice.sizes)
        self.coarsest = 1 if greatest < 3 else 2**((greatest - 1).bit_length() - 1)

    def plan(self, number):
        """Stride of a crossing and the axes on which it is between."""
        indices = self.lattice.crossing_indices[number]
        stride = self.coarsest
        while any(k % stride for k in indices):
            stride //= 2
        return stride, [axis for axis in range(4) if indices[axis] // stride % 2]

    def along(self, number, axis, stride, coded):
        """The stencil of a crossing along an axis, None where there is none."""
        indices, nodes = self.lattice.crossing_indices[number], self.lattice.axes[axis]
        members, positions = [], []
        for steps in (-3, -1, 1, 3):
            k, turns = indices[axis] + steps * stride, 0
            if axis < 2 and len(nodes) > 1:
                turns, k = divmod(k, len(nodes) - 1)
            if not 0 <= k < len(nodes):
                continue
            crossing = self.lattice.crossing_at[indices[:axis] + (k,) + indices[axis + 1:]]
            if crossing in coded:
                members.append(self.samples[crossing])
                positions.append(nodes[k] + turns * nodes[-1])
        stencil = Stencil.at(nodes[indices[axis]], members, positions, self.coder.base)
        if not members or any(abs(weight) > 2.5 for weight in stencil.weights):
            return None
        return stencil

    def read_block(self, stream, numbers):
        plans = {number: self.plan(number) for number in numbers}
        order = sorted(numbers, key=lambda number: (-plans[number][0], len(plans[number][1]), number))
        coded, last = set(), None
        for number in order:
            stride, between = plans[number]
            found = [self.along(number, axis, stride, coded) for axis in between]
            found = [stencil for stencil in found if stencil is not None]
            if found:
                stencil = min(found, key=lambda stencil: stencil.spread)
            elif last is not None:
                stencil = Stencil([last], [1.0], spread_of([0]))
            else:
                stencil = Stencil([], [], spread_of([]))
            stencil.spread *= 2
            self.samples[number] = last = Sample(*self.coder.channels(stream, stencil, 0, 16))
            coded.add(number)


# ---- 7. Samples on slices --------------------------------------------------------------------------------------------


class SampledSlice:
    """The known samples of a slice in order of position, crossings included."""

    def __init__(self, mode, length, nodes, interval_ends):
        self.mode = mode
        self.length = length
        self.known = nodes
        self.interval_ends = interval_ends

    def neighbour(self, k):
        """The known sample number k, which may lie beyond the ends, and its position there; or None."""
        n = len(self.known)
        if 0 <= k < n:
            return self.known[k], self.known[k].position
        if self.mode == "periodic":
            turns, k = divmod(k, n)
            return self.known[k], self.known[k].position + turns * self.length
        if self.mode == "mirrored":
            mirrored, end = (-k, self.known[0]) if k < 0 else (2 * (n - 1) - k, self.known[-1])
            if 0 <= mirrored < n:
                return self.known[mirrored], 2 * end.position - self.known[mirrored].position
        return None

    def read_depth(self, stream, coder, depth, contexts):
        """Reads the samples of one depth; returns how many there were."""
        base_context, other_context, classes = contexts
        found, before = [], False
        for k in range(len(self.known) if self.mode == "periodic" else len(self.known) - 1):
            left, right = self.known[k], self.known[(k + 1) % len(self.known)]
            if max(left.depth, right.depth) != depth - 1:
                continue
            before = coder.flag(stream, depth, left, right, before)
            if not before:
                continue
            fraction = left.fraction + 2**(16 - depth)
            begin, end = self.interval_ends(left.interval)
            position = begin + (end - begin) * (fraction / FRACTIONS)
            around = [self.neighbour(k + step) for step in (-1, 0, 1, 2)]
            around = [entry for entry in around if entry is not None]
            stencil = Stencil.at(position, [entry[0] for entry in around], [entry[1] for entry in around], coder.base)
            steps, residuals = coder.channels(stream, stencil, base_context, other_context, classes)
            found.append((k + 1, Sample(steps, residuals, depth, left.interval, fraction, position)))
        for k, sample in reversed(found):
            self.known.insert(k, sample)
        return len(found)

    def samples(self):
        return [sample for sample in self.known if sample.depth > 0]


def read_guide(stream, index, coder):
    """The guide's samples in order of position, its nodes included."""
    positions, nodes = index.nodes[3], []
    for k, position in enumerate(positions):
        need(k < index.guide_count, "SB-8-2", "more nodes than samples of the guide")
        stencil = Stencil([nodes[-1]], [1.0], 0) if nodes else Stencil([], [], 0)
        nodes.append(Sample(*coder.channels(stream, stencil, 64, 64, False), 0, k, 0, position))
    guide = SampledSlice("bounded", positions[-1], nodes, lambda k: (positions[k], positions[k + 1]))
    for depth in range(1, 17):
        guide.read_depth(stream, coder, depth, (65, 65, False))
        need(len(guide.known) <= index.guide_count, "SB-8-2", "more samples of the guide than stated")
    need(len(guide.known) == index.guide_count, "SB-8-2", "fewer samples of the guide than stated")
    return guide.known


# ---- 10. Splines of guides -------------------------------------------------------------------------------------------


class Spline:
    """Through values `y` at rising positions `x`; the second derivative is constant over the first and last gap."""

    def __init__(self, x, y):
        self.x = x
        self.y = y
        self.m = self.second_derivatives()

    def second_derivatives(self):
        x, y, n = self.x, self.y, len(self.x)
        if n <= 2:
            return [0.0] * n
        h = [x[k + 1] - x[k] for k in range(n - 1)]
        d = [(y[k + 1] - y[k]) / h[k] for k in range(n - 1)]
        rows = [(0.0, 1.0, -1.0, 0.0)]
        rows += [(h[k - 1], 2 * (h[k - 1] + h[k]), h[k], 6 * (d[k] - d[k - 1])) for k in range(1, n - 1)]
        rows += [(-1.0, 1.0, 0.0, 0.0)]
        pivot = rows[0][1]
        factor, r = [0.0], [rows[0][3] / pivot]
        for k in range(1, n):
            lower, diagonal, _, right = rows[k]
            factor.append(rows[k - 1][2] / pivot)
            pivot = diagonal - lower * factor[k]
            r.append((right - lower * r[k - 1]) / pivot)
        for k in range(n - 2, -1, -1):
            r[k] = r[k] - factor[k + 1] * r[k + 1]
        return r

    def at(self, x):
        if len(self.x) == 1:
            return self.y[0]
        x = min(max(x, self.x[0]), self.x[-1])
        k = max(k for k in range(len(self.x) - 1) if self.x[k] <= x)
        w = self.x[k + 1] - self.x[k]
        t = (x - self.x[k]) / w
        s = 1 - t
        rise = self.y[k + 1] - self.y[k]
        a = self.y[k] + t * rise if t < 0.5 else self.y[k + 1] - (1 - t) * rise
        return a - s * t * (w * w / 6) * ((1 + s) * self.m[k] + (1 + t) * self.m[k + 1])


class GuideSteps:
    """What the guide takes off the steps of every channel at a theta_h."""

    def __init__(self, guide, values, per_octave):
        positions = [sample.position for sample in guide]
        self.splines = [Spline(positions, [value[c] for value in values]) for c in range(len(values[0]))]
        self.factor = per_octave * 1.4426950408889634
        self.known = {}

    def at(self, theta_h):
        if theta_h not in self.known:
            scaled = [min(max(spline.at(theta_h) * self.factor, -2.0**24), 2.0**24) for spline in self.splines]
            self.known[theta_h] = [math.floor(x + 0.5) for x in scaled]
        return self.known[theta_h]

    def whole_steps(self, steps, theta_h):
        whole = [step + taken for step, taken in zip(steps, self.at(theta_h))]
        return [(step + 2**31) % 2**32 - 2**31 for step in whole]


# ---- 8. Metadata -----------------------------------------------------------------------------------------------------


def read_metadata(packed, size):
    """The JSON object; text that is none as it is, None where there is no metadata."""
    if size == 0:
        return None
    try:
        decompressor = zlib.decompressobj(wbits=-15, zdict=DICTIONARY)
        text = decompressor.decompress(packed)
    except zlib.error as error:
        raise Refused("SB-8-5", f"metadata: {error}") from None
    whole = decompressor.eof and not decompressor.unused_data and len(text) == size
    need(whole, "SB-8-5", f"metadata of {len(text)} bytes, the index says {size}")
    try:
        return json.loads(text.decode("utf-8"))
    except ValueError:
        return text.decode("utf-8", errors="replace")


def read_mask(payload, mask):
    """Lengths of runs: measured cells, unmeasured ones, in turn."""
    need(payload is not None, "SB-1-7", "the mask's chunk is left out")
    _, counts, size = mask
    try:
        stated = zstandard.get_frame_parameters(payload).content_size
        need(stated == size, "SB-8-7", f"mask of {stated} bytes, the index says {size}")
        decompressor = zstandard.ZstdDecompressor().decompressobj()
        content = decompressor.decompress(payload)
    except zstandard.ZstdError as error:
        raise Refused("SB-8-7", f"mask: {error}") from None
    whole = decompressor.eof and not decompressor.unused_data and len(content) == size
    need(whole, "SB-8-7", "the mask is not one frame")
    reader, runs = IndexReader(content), []
    try:
        while reader.left():
            runs.append(reader.count())
    except Refused as refused:
        raise Refused("SB-8-7", f"mask: {refused}") from None
    need(all(runs[1:]), "SB-8-7", "an empty run of the mask")
    need(sum(runs) == math.prod(counts), "SB-8-7", f"a mask of {sum(runs)} cells")
    return runs


# ---- The whole file --------------------------------------------------------------------------------------------------


class Decoded:
    """Everything that a file holds. `crossings`, `samples` (per slice) and `guide` are lists of rows of values."""

    def __init__(self, file):
        self.container = Container(file)
        self.index = Index(self.container)
        self.lattice = Lattice(self.index)
        self.coder = SampleCoder(self.index)
        self.scale = self.index.scale
        self.read_chunks()
        self.make_values()

    def read_chunks(self):
        index, lattice = self.index, self.lattice
        crossing_blocks = blocks_of(enumerate(lattice.crossing_indices), index.blocks[4])
        slice_blocks = []
        for kind in range(4):
            members = [(number, piece.indices) for number, piece in enumerate(lattice.slices) if piece.kind == kind]
            slice_blocks += blocks_of(members, index.blocks[kind])
        count = 1 + len(crossing_blocks) + len(index.pieces) * len(slice_blocks)
        chunks = payloads(self.container, index, count)
        mask_payload = chunks.pop() if index.mask else None
        self.one_stream = None
        if index.whole:
            need(chunks[0] is not None, "SB-1-7", "the chunk is left out")
            self.one_stream = Stream(chunks[0], "SB-8-2" if self.index.guide_ratio is not None else "SB-8-1")
            chunks = [None] * count
        chunks = iter(chunks)
        guide_payload = next(chunks)
        self.guide = []
        if index.guide_ratio is not None:
            with self.reading(guide_payload, "SB-8-2") as stream:
                self.guide = read_guide(stream, index, self.coder)
        else:
            need(guide_payload is None, "SB-8-2", "a chunk for a guide that is not there")
        self.read_crossings(crossing_blocks, chunks)
        self.read_samples(slice_blocks, chunks)
        if index.whole:
            self.one_stream.clause = "SB-8-3"
            self.one_stream.end()
        self.metadata = read_metadata(index.metadata, index.metadata_size)
        self.mask_runs = read_mask(mask_payload, index.mask) if index.mask else []

    @contextlib.contextmanager
    def reading(self, payload, clause):
        """The stream of a chunk, which must end after use; of a whole file the one that goes on."""
        if self.one_stream:
            self.one_stream.clause = clause
            yield self.one_stream
            return
        need(payload is not None, "SB-1-7", "a chunk that must be there is left out")
        stream = Stream(payload, clause)
        yield stream
        stream.end()

    def read_crossings(self, blocks, chunks):
        reader = CrossingReader(self.lattice, self.coder)
        for numbers in blocks:
            with self.reading(next(chunks), "SB-8-1") as stream:
                reader.read_block(stream, numbers)
        self.crossings = reader.samples

    def read_samples(self, blocks, chunks):
        self.sampled = []
        for piece in self.lattice.slices:
            places = enumerate(piece.nodes)
            nodes = [self.crossings[crossing].on_slice(k, position) for k, (position, crossing) in places]
            self.sampled.append(SampledSlice(piece.mode, piece.length, nodes, piece.interval_ends))
        found = 0
        for first, end in zip(self.index.pieces, self.index.pieces[1:] + [17]):
            for numbers in blocks:
                payload = next(chunks)
                if payload is None and not (self.index.whole and self.index.sample_count):
                    continue
                with self.reading(payload, "SB-8-3") as stream:
                    for number in numbers:
                        for depth in range(first, end):
                            found += self.sampled[number].read_depth(stream, self.coder, depth, (32, 48, True))
                            need(found <= self.index.sample_count, "SB-8-3", "more samples than stated")
        need(found == self.index.sample_count, "SB-8-3", f"{found} samples, {self.index.sample_count} stated")

    def make_values(self):
        index = self.index
        self.guide_values = [[self.scale.guide_value(step) for step in sample.steps] for sample in self.guide]
        for value in [value for row in self.guide_values for value in row]:
            need(math.isfinite(value), "SB-8-4", "a value of the guide is not finite")
        guide_steps = None
        if index.guide_ratio == 1:
            guide_steps = GuideSteps(self.guide, self.guide_values, index.scale.per_octave)

        def values(sample, theta_h):
            steps = guide_steps.whole_steps(sample.steps, theta_h) if guide_steps else sample.steps
            return [self.scale.value(step) for step in steps]

        self.crossing_values = [
            values(sample, coordinates[3])
            for sample, coordinates in zip(self.crossings, self.lattice.crossing_coordinates)
        ]
        self.sample_values = []
        for piece, sampled in zip(self.lattice.slices, self.sampled):
            for sample in sampled.samples():
                theta_h = sample.position if piece.kind == 3 else piece.line.offset[3]
                self.sample_values.append(values(sample, theta_h))
        rows = self.crossing_values + self.sample_values
        for channel, (least, greatest) in enumerate(index.ranges):
            column = [row[channel] for row in rows]
            need(min(column) == least and max(column) == greatest, "SB-8-6",
                 f"channel {channel} spans {min(column)} to {max(column)}, the index says {least} to {greatest}")

    def values_bytes(self):
        rows = self.crossing_values + self.sample_values + self.guide_values
        return numpy.array(rows, dtype="<f4").tobytes()

    def positions_bytes(self):
        lists = [sampled.samples() for sampled in self.sampled]
        numbers = [len(samples) for samples in lists]
        for samples in lists + [self.guide]:
            for sample in samples:
                numbers += [sample.interval, sample.fraction]
        if self.index.mask:
            frame, counts, _ = self.index.mask
            numbers += [frame, *counts, *self.mask_runs]
        return numpy.array(numbers, dtype="<u4").tobytes()

    def summary(self):
        index = self.index
        slices = {kind: sum(piece.kind == k for piece in self.lattice.slices) for k, kind in enumerate(KINDS)}
        return {
            "version": f"{self.container.major}.{self.container.minor}",
            "frame": {ELEVATION: "elevation", HALF_DIFFERENCE: "half-difference"}[index.frame],
            "nodes": index.nodes,
            "symmetries": [
                name for bit, name in enumerate(("isotropic", "mirror-x", "mirror-y")) if index.symmetries >> bit & 1
            ],
            "theta_max": index.theta_max,
            "mask": None if index.mask is None else {"frame": index.mask[0], "cells": index.mask[1],
                                                     "unmeasured": sum(self.mask_runs[1::2])},
            "domain": {1: "linear", 2: "log"}[index.domain],
            "references": index.references,
            "floor_halvings": index.halvings,
            "channels": index.channels,
            "ranges": index.ranges,
            "precision": index.scale.bound,
            "guide": None if index.guide_ratio is None else {"ratio": index.guide_ratio, "samples": len(self.guide)},
            "samples": len(self.crossings) + len(self.sample_values) + len(self.guide),
            "crossings": len(self.crossings),
            "slices": slices,
            "pieces": index.pieces,
            "blocks": index.blocks,
            "chunks": len(index.chunk_sizes),
            "metadata": self.metadata,
        }


def evaluate(decoded, lines, out):
    """Rows of `sbrdf eval`: the lines of a CSV file, with the values of all channels appended."""
    from sbrdf_evaluation import Evaluation  # pylint: disable=import-outside-toplevel
    evaluation = Evaluation(decoded)
    rows = [line.rstrip("\r\n") for line in lines]
    print(rows[0], *decoded.index.channels, sep=",", file=out)
    for row in rows[1:]:
        f_r = evaluation.f_r(*map(float, row.split(",")[:4]))
        print(row, *(f"{value:.9g}" for value in f_r), sep=",", file=out)


def main():
    parser = argparse.ArgumentParser(description="Reference decoder of sliced BRDF files")
    parser.add_argument("file")
    parser.add_argument("--values", metavar="OUT", help="write all values, little-endian float32")
    parser.add_argument("--positions", metavar="OUT", help="write the places of all samples, little-endian u32")
    parser.add_argument("--eval", metavar="PAIRS", help="evaluate pairs of directions, CSV in degrees")
    arguments = parser.parse_args()
    try:
        with open(arguments.file, "rb") as stream:
            decoded = Decoded(stream.read())
        pairs = []
        if arguments.eval:
            with open(arguments.eval, encoding="utf-8") as stream:
                pairs = stream.readlines()
    except OSError as error:
        print(error, file=sys.stderr)
        return 2
    except Refused as refused:
        print(refused, file=sys.stderr)
        return 4 if refused.unsupported else 3
    for path, content in ((arguments.values, decoded.values_bytes), (arguments.positions, decoded.positions_bytes)):
        if path:
            with open(path, "wb") as out:
                out.write(content())
    if arguments.eval:
        evaluate(decoded, pairs, sys.stdout)
    else:
        print(json.dumps(decoded.summary(), indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
