#!/usr/bin/env python3
"""Reference decoder of dense files, written from specs/sbrdf.md (section 14) and specs/conventions.md alone.

usage: sbrdf_series.py FILE [--eval PAIRS.csv] [--level N]

Prints what the file holds as JSON, or with --eval what `sbrdf eval` prints. Exit codes and messages as
sbrdf_reference.py. Slow and plain on purpose.
"""
import argparse
import functools
import itertools
import json
import math
import sys
import zlib

from sbrdf_evaluation import half_difference_coordinates, within
from sbrdf_reference import DICTIONARY, Container, IndexReader, Refused, known, need

DENSE = 10
LEVELS = 8
MOST = {"theta_h": 64, "theta_d": 64, "phi_h": 32, "phi_d": 32}


# ---- Range coder -----------------------------------------------------------------------------------------------------


class Counts:
    def __init__(self, no=16, yes=16):
        self.no, self.yes = no, yes

    def probability(self):
        return min(max((self.yes << 16) // (self.no + self.yes), 64), 65536 - 64)

    def add(self, yes):
        if yes:
            self.yes += 32
        else:
            self.no += 32
        if self.no + self.yes > 8160:
            self.no, self.yes = (self.no + 1) // 2, (self.yes + 1) // 2


class Decoder:
    def __init__(self, stream):
        self.stream, self.at = stream, 4
        self.code = int.from_bytes(stream[:4].ljust(4, b"\0"), "big")
        self.range = 2**32 - 1

    def split(self, part):
        yes = self.code < part
        if yes:
            self.range = part
        else:
            self.code, self.range = self.code - part, self.range - part
        while self.range < 2**24:
            byte = self.stream[self.at] if self.at < len(self.stream) else 0
            self.code, self.range, self.at = self.code << 8 & 0xFFFFFFFF | byte, self.range << 8, self.at + 1
        return yes

    def decision(self, counts):
        yes = self.split((self.range >> 16) * counts.probability())
        counts.add(yes)
        return yes

    def plain(self):
        return self.split(self.range >> 1)


# ---- Terms -----------------------------------------------------------------------------------------------------------


def keeps(mirror_x, mirror_y, j, sine):
    return not (mirror_x and sine) and (not mirror_y or sine == (j % 2 == 1))


def harmonics_of(phi_h, phi_d, mirror_x, mirror_y):
    """(j, k, sine) in order."""
    found = []
    for j in range(phi_h):
        for size in range(phi_d):
            for k in [size] if size == 0 or j == 0 else [size, -size]:
                found += [(j, k, sine) for sine in (False, True)
                          if not (sine and j == 0 and k == 0) and keeps(mirror_x, mirror_y, j, sine)]
    return found


def lower_of(harmonics, number):
    j, k, sine = harmonics[number]
    if k:
        wanted = [(j, k - 1 if k > 0 else k + 1, sine)]
    else:
        wanted = [(j - 1, 0, sine), (j - 2, 0, sine)]
    return next((harmonics.index(each) for each in wanted if each in harmonics), None)


def terms_of(shape, harmonics):
    """(level, harmonic, b, a) in order."""
    product = math.prod(shape.values())
    found = []
    for h, (j, k, _) in enumerate(harmonics):
        orders = j * product // shape["phi_h"] + abs(k) * product // shape["phi_d"]
        for b, a in itertools.product(range(shape["theta_d"]), range(shape["theta_h"])):
            weight = orders + a * product // shape["theta_h"] + b * product // shape["theta_d"]
            if weight < product:
                found.append((LEVELS * weight // product, h, b, a))
    return sorted(found)


# ---- File ------------------------------------------------------------------------------------------------------------


class Dense:
    def __init__(self, file, level=LEVELS):
        container = Container(file)
        reader = IndexReader(container.index)
        self.read_frame(reader)
        self.read_shape(reader)
        self.read_colours(reader)
        self.counts = [reader.count() for _ in range(1 + self.components)]
        self.metadata = b""
        if self.parts & 4:
            self.read_metadata(reader)
        self.make_terms()
        need(all(count <= len(self.terms) for count in self.counts), "SD-5", "more coefficients than terms")
        stream = reader.take(reader.left())
        need(not stream or stream[-1] != 0, "SD-5", "a stream that ends with 0")
        self.read_coefficients(stream)
        for field in self.coefficients:
            for n, term in enumerate(self.terms):
                if term[0] > level:
                    field[n] = 0
        need(container.minor > 0 or len(file) == container.chunks_begin, "SD-7", "the file goes on behind its head")
        self.make_table()

    def read_frame(self, reader):
        frame, self.parts = reader.numbers("B", 2)
        known(frame & 15 == DENSE, "SB-2-2", f"frame {frame & 15}")
        known(frame < 128, "SB-2-3", f"symmetries {frame >> 4}")
        known(not self.parts & ~13, "SD-1", f"parts {self.parts}")
        self.isotropic, self.mirror_x, self.mirror_y = (bool(frame & bit) for bit in (16, 32, 64))
        theta_max = reader.count() if self.parts & 8 else 8000
        need(1 <= theta_max <= 9000, "SD-2", f"theta_max {theta_max}")
        self.theta_max = theta_max / 100
        channels = reader.count()
        need(channels <= 4096, "SB-2-6", f"{channels} channels")
        self.channels = [] if channels else ["R", "G", "B"]
        for _ in range(channels):
            self.channels.append(reader.take(reader.count()).decode("utf-8", errors="replace"))

    def read_shape(self, reader):
        both = reader.number("B")
        self.components, self.fineness = both & 15, both >> 4
        self.shape = {"theta_h": reader.count(), "theta_d": reader.count(), "phi_d": reader.count()}
        self.shape["phi_h"] = 1 if self.isotropic else reader.count()
        width, power = reader.numbers("B", 2)
        self.width, self.power = 2.0**(width / 8 - 6), (power + 1) / 8
        reference, most, step = reader.signed(), reader.signed(), reader.number("B")
        count = len(self.channels)
        need(self.components <= (2 if count == 3 else min(8, count - 1)), "SD-3", f"{self.components} components")
        need(min(v for k, v in self.shape.items() if k != "phi_h" or not self.isotropic) >= 2, "SD-3",
             f"shape {self.shape}")
        need(self.fineness > 0, "SD-3", "a table without nodes")
        need(abs(reference) <= 800 and abs(most) <= 1280 and reference * math.log(2) + most <= 680, "SD-4", f"reference {reference}, bound {most}")
        self.reference, self.most, self.step = 2.0**(reference / 8), most / 8, 2.0**(-step / 8)
        self.floor = max(self.reference / 8, 2.0**-126)
        self.zero = math.log(self.floor / self.reference) - 1

    def read_colours(self, reader):
        count = len(self.channels)
        parts = [reader.signed() for _ in range(count - 1)]
        need(all(abs(part) <= 2**20 for part in parts), "SD-6", "mean colour")
        self.mean_colour = [part / 32 for part in [*parts, 32 * count - sum(parts)]]
        self.axes = []
        if self.components and count == 3:
            turn = reader.number("B") * math.pi / 256
            first = (math.sqrt(1 / 2), -math.sqrt(1 / 2), 0)
            second = (math.sqrt(1 / 6), math.sqrt(1 / 6), -2 * math.sqrt(1 / 6))
            for j in range(self.components):
                at = turn + j * math.pi / 2
                self.axes.append([math.cos(at) * x + math.sin(at) * y for x, y in zip(first, second)])
        elif self.components:
            self.axes = [[part / 127 for part in reader.numbers("b", count)] for _ in range(self.components)]

    def read_metadata(self, reader):
        size, packed = reader.count(), reader.count()
        need(size <= 2**24, "SB-2-15", f"metadata of {size} bytes")
        packed = reader.take(packed)
        try:
            unpacker = zlib.decompressobj(-15, zdict=DICTIONARY)
            self.metadata = unpacker.decompress(packed, size + 1)
        except zlib.error as error:
            raise Refused("SB-8-5", str(error)) from error
        need(len(self.metadata) == size and unpacker.eof and not unpacker.unused_data, "SB-8-5", "metadata")

    def make_terms(self):
        known(all(1 <= self.shape[axis] <= most for axis, most in MOST.items()), "SD-3", f"shape {self.shape}")
        known(math.prod(self.shape.values()) <= 2**21, "SD-3", f"shape {self.shape}")
        self.harmonics = harmonics_of(self.shape["phi_h"], self.shape["phi_d"], self.mirror_x, self.mirror_y)
        self.lower = [lower_of(self.harmonics, h) for h in range(len(self.harmonics))]
        self.terms = terms_of(self.shape, self.harmonics)
        known(len(self.terms) <= 2**16, "SD-3", f"{len(self.terms)} terms")

    def read_coefficients(self, stream):
        decoder = Decoder(stream)
        starts = ((38, 3), (26, 10), (19, 13), (16, 16), (10, 22), (6, 26))
        zero = [[Counts(*start) for start in starts] for _ in range(2)]
        larger = [[Counts() for _ in range(7)] for _ in range(3)]
        numbers = {term[1:]: n for n, term in enumerate(self.terms)}
        self.coefficients = [[0] * len(self.terms) for _ in self.counts]
        for f, count in enumerate(self.counts):
            field = self.coefficients[f]

            def size(h, b, a):
                n = numbers.get((h, b, a))
                return 0 if n is None else min(abs(field[n]), 4096)

            for n in range(count):
                _, h, b, a = self.terms[n]
                near = 2 * (size(h, b, a - 1) + size(h, b - 1, a)) + size(h, b, a - 2) + size(h, b - 2, a)
                near += size(h, b - 1, a - 1)
                if self.lower[h] is not None:
                    near += 2 * size(self.lower[h], b, a)
                if f > 0:
                    near += 2 * min(abs(self.coefficients[0][n]), 2)
                kind = 0 if near == 0 else min(5, max(1, (near - 1).bit_length()))
                if decoder.decision(zero[min(f, 1)][kind]):
                    negative = decoder.plain()
                    value = 1 + self.read_more(decoder, larger[kind // 2])
                    need(value < 2**24, "SD-5", "a coefficient of 2^24 or more")
                    field[n] = -value if negative else value

    @staticmethod
    def read_more(decoder, steps):
        for k in range(15):
            if not decoder.decision(steps[min(k, 6)]):
                return k
        bits = 0
        while decoder.plain():
            bits += 1
            need(bits <= 23, "SD-5", "a coefficient of 2^24 or more")
        rest = 1
        for _ in range(bits):
            rest = 2 * rest + decoder.plain()
        return rest + 14

    # ---- Table -------------------------------------------------------------------------------------------------------

    def make_table(self):
        def polar(count, place):
            gaps = count * self.fineness
            nodes = [0.0]
            for k in range(1, gaps):
                node = place(0.5 - 0.5 * math.cos(math.pi * k / gaps))
                if node - nodes[-1] >= 0.002 and self.theta_max - node >= 0.002:
                    nodes.append(node)
            return [*nodes, self.theta_max]

        def azimuth(count, turn):
            gaps = 2 * count * self.fineness
            return [0.0] if count == 1 else [turn * k / gaps for k in range(gaps + 1)]

        self.end = math.log1p((self.theta_max / self.width)**2)
        self.nodes = [azimuth(self.shape["phi_h"], 360), azimuth(self.shape["phi_d"], 180),
                      polar(self.shape["theta_d"], lambda v: self.theta_max * v**(1 / self.power)),
                      polar(self.shape["theta_h"], lambda u: self.width * math.sqrt(math.expm1(u * self.end)))]

    def forward(self, f):
        if f >= self.floor:
            return math.log(f / self.reference)
        return self.zero + f / self.floor if f > -self.floor else self.zero - 1 - math.log(-f / self.floor)

    def back(self, v):
        if v >= self.zero + 1:
            return self.reference * math.exp(v)
        return self.floor * (v - self.zero) if v > self.zero - 1 else -self.floor * math.exp(self.zero - 1 - v)

    @functools.lru_cache(None)
    def at_node(self, corner):
        """What the series is at a node of the table, by channel, in the value domain."""
        phi_h, phi_d, theta_d, theta_h = (nodes[k] for nodes, k in zip(self.nodes, corner))
        u = math.log1p((theta_h / self.width)**2) / self.end
        v = (theta_d / self.theta_max)**self.power
        at_h, at_d = (math.sqrt(math.sin(math.radians(theta))) for theta in (theta_h, theta_d))
        waves = []
        for j, k, sine in self.harmonics:
            angle = math.radians(j * phi_h + 2 * k * phi_d)
            wave = math.sin(angle) if sine else math.cos(angle)
            waves.append(wave * (1 if j == 2 * k else at_h) * (1 if k == 0 else at_d))

        def polynomial(n, x):
            return math.cos(n * math.acos(min(max(2 * x - 1, -1), 1)))

        fields = [sum(self.step * q * polynomial(a, u) * polynomial(b, v) * waves[h]
                      for q, (_, h, b, a) in zip(field, self.terms) if q) for field in self.coefficients]
        negative = bool(self.parts & 1)
        least = min(self.most, 2 * self.zero - self.most if negative else self.zero)
        mean = self.back(min(max(fields[0], least), self.most))
        values = []
        for c, colour in enumerate(self.mean_colour):
            f = mean * (colour + sum(z * axis[c] for z, axis in zip(fields[1:], self.axes)))
            values.append(self.forward(min(max(f, -2.0**120 if negative else 0.0), 2.0**120)))
        return values

    def f_r(self, theta_i, phi_i, theta_v, phi_v):
        if max(theta_i, theta_v) > 90:
            return [0.0] * len(self.channels)
        place = half_difference_coordinates(theta_i, within(phi_i, 360), theta_v, within(phi_v, 360))
        corners = [(1.0, ())]
        for x, nodes in zip(place, self.nodes):
            if len(nodes) == 1:
                corners = [(weight, corner + (0,)) for weight, corner in corners]
                continue
            k = max(n for n in range(len(nodes) - 1) if nodes[n] <= x or n == 0)
            t = min(max((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 0), 1)
            corners = [(weight * part, corner + (k + far,)) for weight, corner in corners
                       for far, part in ((0, 1 - t), (1, t))]
        sums = [0.0] * len(self.channels)
        for weight, corner in corners:
            if weight:
                sums = [total + weight * v for total, v in zip(sums, self.at_node(corner))]
        values = [self.back(v) for v in sums]
        return values if self.parts & 1 else [max(f, 0.0) for f in values]

    def summary(self):
        return {"channels": self.channels, "isotropic": self.isotropic, "theta_max_deg": self.theta_max,
                "functions": self.shape, "fields": len(self.counts), "nodes": [len(axis) for axis in self.nodes],
                "coefficients": sum(q != 0 for field in self.coefficients for q in field),
                "metadata": self.metadata.decode("utf-8", errors="replace")}


def main():
    parser = argparse.ArgumentParser(description="Reference decoder of dense files")
    parser.add_argument("file")
    parser.add_argument("--eval", metavar="PAIRS", help="evaluate pairs of directions, CSV in degrees")
    parser.add_argument("--level", type=int, default=LEVELS, help="leave out terms of higher levels")
    arguments = parser.parse_args()
    try:
        with open(arguments.file, "rb") as stream:
            dense = Dense(stream.read(), arguments.level)
    except OSError as error:
        print(error, file=sys.stderr)
        return 2
    except Refused as refused:
        print(refused, file=sys.stderr)
        return 4 if refused.unsupported else 3
    if not arguments.eval:
        print(json.dumps(dense.summary(), indent=1))
        return 0
    with open(arguments.eval, encoding="utf-8") as stream:
        rows = stream.read().split("\n")
    print(",".join([rows[0], *dense.channels]))
    for row in filter(None, rows[1:]):
        values = dense.f_r(*map(float, row.split(",")))
        print(",".join([row, *(f"{value:.9g}" for value in values)]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
