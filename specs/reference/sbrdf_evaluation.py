"""Reference evaluation of sliced BRDF files, written from specs/conventions.md and specs/sbrdf.md alone.

    evaluation = Evaluation(Decoded(file))
    evaluation.f_r(30, 0, 45, 180)    # theta_i, phi_i, theta_v, phi_v in degrees: one value [1/sr] for each channel

Plain on purpose, one function for one paragraph of the pages. `sbrdf_reference.py --eval` is the way in from a shell.
"""
import bisect
import math

import numpy

ELEVATION, LOG = 1, 2  # frame and domain of the index
LARGEST_F32 = float.fromhex("0x1.fffffep127")
PER_DEGREE = math.pi / 180  # degrees to radians and back, as the page rounds them
PER_RADIAN = 180 / math.pi


# ---- Directions and frames -------------------------------------------------------------------------------------------


def through_radians(degrees):
    return degrees * PER_DEGREE * PER_RADIAN


def within(x, period):
    """In [0, period)."""
    x -= period * math.floor(x / period)
    return x if x < period else 0.0


def elevation_coordinates(theta_i, phi_i, theta_v, phi_v):
    """s, u, theta_v, theta_i in degrees."""
    theta_i, phi_i, theta_v, phi_v = map(through_radians, (theta_i, phi_i, theta_v, phi_v))
    s, u = phi_i + phi_v, phi_i - phi_v
    if theta_i > theta_v:
        theta_i, theta_v, u = theta_v, theta_i, -u
    elif theta_i == theta_v:
        u = abs(u)
    if theta_i == 0:
        s, u = s - u, 0.0
    turns = math.floor(u / 360)
    s, u = s - 360 * turns, u - 360 * turns
    return within(s, 720), u, theta_v, theta_i


def half_sum_and_difference(theta_i, theta_v, turn):
    """(i + v) / 2 and (i - v) / 2, where the mean azimuth is 0 and that of the light `turn`."""
    lean = (theta_i - theta_v) / 2
    mean = theta_v + lean
    cos_turn = math.cos(turn) if abs(math.cos(turn)) > 2.0**-50 else 0.0
    return ((math.sin(mean) * math.cos(lean) * cos_turn, math.cos(mean) * math.sin(lean) * math.sin(turn),
             math.cos(mean) * math.cos(lean)),
            (math.cos(mean) * math.sin(lean) * cos_turn, math.sin(mean) * math.cos(lean) * math.sin(turn),
             -math.sin(mean) * math.sin(lean)))


def half_difference_coordinates(theta_i, phi_i, theta_v, phi_v):
    """phi_h, phi_d, theta_d, theta_h in degrees."""
    if (theta_v, phi_v) < (theta_i, phi_i):
        theta_i, phi_i, theta_v, phi_v = theta_v, phi_v, theta_i, phi_i
    theta_i, phi_i, theta_v, phi_v = (x * PER_DEGREE for x in (theta_i, phi_i, theta_v, phi_v))
    turn = (phi_i - phi_v) / 2
    (x, y, z), difference = half_sum_and_difference(theta_i, theta_v, turn)
    theta_d = math.atan2(math.hypot(*difference), math.hypot(x, y, z))
    theta_h, phi_h, phi_d = math.atan2(math.hypot(x, y), z), 0.0, 0.0
    if theta_h == 0:
        phi_d = phi_i
    else:
        phi_h = math.atan2(y, x)
        # Half the difference, turned by -phi_h about z, then by -theta_h about y, lies in the plane.
        x = difference[0] * math.cos(phi_h) + difference[1] * math.sin(phi_h)
        y = difference[1] * math.cos(phi_h) - difference[0] * math.sin(phi_h)
        phi_d = math.atan2(y, x * math.cos(theta_h) - difference[2] * math.sin(theta_h))
        phi_h += phi_v + turn
    if (theta_i, phi_i) == (theta_v, phi_v):
        phi_d = 0.0
    phi_h, phi_d, theta_d, theta_h = (x * PER_RADIAN for x in (phi_h, phi_d, theta_d, theta_h))
    return within(phi_h, 360), within(phi_d, 180), theta_d, theta_h


# ---- Value domain ----------------------------------------------------------------------------------------------------


class Domain:
    """From stored values to what is interpolated, and back, of one channel."""

    def __init__(self, index, channel):
        self.log = index.domain == LOG
        if self.log:
            self.reference = index.references[channel]
            self.floor = max(self.reference * 2.0**-index.halvings, 2.0**-126)
            self.z = math.log(self.floor / self.reference) - 1

    def forward(self, f):
        if not self.log:
            return f
        if f >= self.floor:
            return math.log(f / self.reference)
        if f <= -self.floor:
            return self.z - 1 - math.log(-f / self.floor)
        return self.z + f / self.floor

    def back(self, v):
        if not self.log:
            return v
        try:
            if v >= self.z + 1:
                return self.reference * math.exp(v)
            if v <= self.z - 1:
                return -self.floor * math.exp(self.z - 1 - v)
        except OverflowError:
            return math.copysign(math.inf, v - self.z)
        return self.floor * (v - self.z)


# ---- Curves along slices ---------------------------------------------------------------------------------------------


def spline_slopes(mode, widths, lines):
    """Slopes at the samples of the cubic spline with a continuous second derivative. `widths` and `lines` are those of
    the gaps: how wide they are, and the slopes of the straight lines in them.

    In a gap of width w with the line d and the slopes m_0, m_1 the second derivative is (6 d - 4 m_0 - 2 m_1) / w at its
    first end and (2 m_0 + 4 m_1 - 6 d) / w at its last.
    """
    gaps = len(widths)
    n = gaps if mode == "periodic" else gaps + 1
    if mode == "bounded" and n == 2:
        return [lines[0], lines[0]]
    matrix, right = numpy.zeros((n, n)), numpy.zeros(n)
    for k in range(n):
        before, behind = (k - 1, k) if mode == "periodic" else (k - 1, k if k < gaps else None)
        at_end = mode != "periodic" and k in (0, n - 1)
        if at_end and mode == "mirrored":
            matrix[k, k] = 1
        elif at_end:  # constant second derivative over the gap
            gap = 0 if k == 0 else gaps - 1
            matrix[k, gap], matrix[k, gap + 1], right[k] = 1, 1, 2 * lines[gap]
        else:
            matrix[k, before] += 2 / widths[before]
            matrix[k, k] += 4 / widths[before] + 4 / widths[behind]
            matrix[k, (k + 1) % n] += 2 / widths[behind]
            right[k] = 6 * lines[before] / widths[before] + 6 * lines[behind] / widths[behind]
    return list(numpy.linalg.solve(matrix, right))


def cubic(t, w, y_0, y_1, m_0, m_1):
    s, rise = 1 - t, y_1 - y_0
    return y_0 + t * rise + s * t * (s * (w * m_0 - rise) + t * (rise - w * m_1))


class Gap:
    """A gap between two samples, its line `d`, and the gaps before and behind it."""

    def __init__(self, mode, widths, lines, k):
        self.w, self.d = widths[k], lines[k]
        beyond = -self.d if mode == "mirrored" else self.d
        self.w_before, self.d_before = self.w, beyond
        self.w_behind, self.d_behind = self.w, beyond
        if mode == "periodic" or k > 0:
            self.w_before, self.d_before = widths[k - 1], lines[k - 1]
        if mode == "periodic" or k + 1 < len(widths):
            behind = (k + 1) % len(widths)
            self.w_behind, self.d_behind = widths[behind], lines[behind]

    def range_of_four(self):
        """Y. Values are less y_0, here and below."""
        rise = self.d * self.w
        around = (-self.d_before * self.w_before, 0.0, rise, rise + self.d_behind * self.w_behind)
        return max(around) - min(around)

    def is_left(self, m_0, m_1):
        """Whether the cubic with these slopes is beyond the bound at a turning point."""
        w, rise, slack = self.w, self.d * self.w, 0.1 * self.range_of_four()
        for t in turning_points(w, rise, m_0, m_1):
            if not 0 < t < 1:
                continue
            y = cubic(t, w, 0.0, rise, m_0, m_1)
            left, right = self.d_before * t * w, rise - self.d_behind * (1 - t) * w
            if y > max(0.0, rise, min(left, right)) + slack or y < min(0.0, rise, max(left, right)) - slack:
                return True
        return False

    def ranges(self):
        """To which ranges the slopes at both ends are brought, the lower number first."""
        d, before, behind = self.d, self.d_before, self.d_behind
        ends = ((0.0, 3 * d), (0.0, 3 * d))
        if before > d > behind:
            ends = ((d, max(0.0, min(before, 3 * d - 2 * behind))), (d, min(0.0, max(behind, 3 * d - 2 * before))))
        if before < d < behind:
            ends = ((d, min(0.0, max(before, 3 * d - 2 * behind))), (d, max(0.0, min(behind, 3 * d - 2 * before))))
        beyond = 0.4 * self.range_of_four() / self.w
        return [(min(a, b) - beyond, max(a, b) + beyond) for a, b in ends]


def turning_points(w, rise, m_0, m_1):
    """Where the slope of the cubic is 0: w m_0 + 2 b t + 3 a t^2 = 0."""
    a, b, c = 3 * (w * (m_0 + m_1) - 2 * rise), 3 * rise - w * (2 * m_0 + m_1), w * m_0
    under_root = b * b - a * c
    if under_root < 0:
        return []
    q = -(b + math.copysign(math.sqrt(under_root), b))
    return [numerator / denominator for numerator, denominator in ((q, a), (c, q)) if denominator != 0]


def limited(mode, widths, lines, slopes):
    """Limits of slopes: cut where the curve would swing too far out."""
    slopes = list(slopes)
    gaps = [Gap(mode, widths, lines, k) for k in range(len(widths))]
    failed = set()
    while True:
        tried = list(slopes)
        failing = [k for k, gap in enumerate(gaps)
                   if k not in failed and gap.is_left(tried[k], tried[(k + 1) % len(slopes)])]
        if not failing:
            return slopes
        failed.update(failing)
        for k in failing:
            for end, (least, most) in zip((k, (k + 1) % len(slopes)), gaps[k].ranges()):
                slopes[end] = min(max(slopes[end], least), most)


class Curve:
    """Through the samples of a slice, one channel. `length` is the period of a periodic slice."""

    def __init__(self, mode, length, positions, values, limits=True):
        self.positions, self.values = list(positions), list(values)
        self.periodic = length if mode == "periodic" else None
        if len(values) == 1:
            return
        if self.periodic:
            self.positions.append(positions[0] + length)
            self.values.append(values[0])
        self.widths = [b - a for a, b in zip(self.positions, self.positions[1:])]
        lines = [(b - a) / w for a, b, w in zip(self.values, self.values[1:], self.widths)]
        self.slopes = spline_slopes(mode, self.widths, lines)
        if limits:
            self.slopes = limited(mode, self.widths, lines, self.slopes)
        if self.periodic:
            self.slopes.append(self.slopes[0])

    def at(self, x):
        """The value at a position in the slice's extent; beyond an end that at the end."""
        if len(self.values) == 1:
            return self.values[0]
        if self.periodic and x < self.positions[0]:
            x += self.periodic
        x = min(max(x, self.positions[0]), self.positions[-1])
        k = min(bisect.bisect_right(self.positions, x), len(self.widths)) - 1
        t = (x - self.positions[k]) / self.widths[k]
        return cubic(t, self.widths[k], self.values[k], self.values[k + 1], self.slopes[k], self.slopes[k + 1])


# ---- Guide -----------------------------------------------------------------------------------------------------------


class Guide:
    """The profile that was taken off, one curve for each channel."""

    def __init__(self, decoded):
        positions = [sample.position for sample in decoded.guide]
        self.ratio = decoded.index.guide_ratio
        self.first, self.last = positions[0], positions[-1]
        self.curves = [Curve("bounded", None, positions, column, limits=False) for column in zip(*decoded.guide_values)]

    def at(self, phi_h, theta_h, channel):
        angle = theta_h
        if self.ratio != 1:
            x = math.cos(phi_h * PER_DEGREE) * min(1.0, self.ratio)
            y = math.sin(phi_h * PER_DEGREE) / max(1.0, self.ratio)
            angle = math.atan(math.tan(theta_h * PER_DEGREE) * math.hypot(x, y)) * PER_RADIAN
        return self.curves[channel].at(min(max(angle, self.first), self.last))


# ---- Cells and rings -------------------------------------------------------------------------------------------------


def cell_of(nodes, x):
    """Where the cell that holds `x` begins, and the fraction of the way through it."""
    if len(nodes) == 1:
        return 0, 0.0
    k = min(bisect.bisect_right(nodes, x), len(nodes) - 1) - 1
    return k, min((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 1.0)


class Ring:
    """A pole where two azimuths become one: `ring` is the sum or difference of both that is left."""

    def __init__(self, lattice, polar_axis, other_axis, sign, along, period):
        self.lattice, self.polar_axis, self.other_axis = lattice, polar_axis, other_axis
        self.sign, self.along, self.period = sign, along, period
        self.nodes = []
        places = sorted(self.place(a, b) for a in lattice.axes[0] for b in lattice.axes[1])
        for place in places:
            if not self.nodes or place - self.nodes[-1] > 1e-6:
                self.nodes.append(place)
        self.nodes.append(float(period))

    def place(self, azimuth_0, azimuth_1):
        place = within(azimuth_0 + self.sign * azimuth_1, self.period)
        return 0.0 if self.period - place < 1e-6 else place

    def line(self, moving_axis, ring, other):
        """Along the ring or along the other axis, with the polar angle 0."""
        offset, slope = [0.0] * 4, [0] * 4
        offset[self.along], offset[self.other_axis] = ring, other
        if moving_axis is not None:
            offset[moving_axis], slope[moving_axis] = 0.0, 1
        return offset, slope


def rings_of(decoded):
    lattice = decoded.lattice
    if min(lattice.sizes) < 2:
        return []
    if decoded.index.frame == ELEVATION:
        return [Ring(lattice, 3, 2, -1, 0, 720), Ring(lattice, 2, 3, +1, 0, 720)]
    return [Ring(lattice, 3, 2, +1, 1, 180)]


class Sum:
    """A sum of slices less corners, and the least and the greatest value of its slices."""

    def __init__(self, total, slices):
        self.least, self.greatest = min(slices), max(slices)
        self.total = total

    def within(self, log):
        total = max(self.total, self.least)
        return min(total, self.greatest) if log else total


# ---- Reconstruction --------------------------------------------------------------------------------------------------


class Evaluation:
    """Evaluates what a file holds."""

    def __init__(self, decoded):
        self.index, self.lattice = decoded.index, decoded.lattice
        self.channels = range(len(self.index.channels))
        self.domains = [Domain(self.index, channel) for channel in self.channels]
        self.guide = Guide(decoded) if decoded.guide else None
        self.log = self.index.domain == LOG
        self.rings = rings_of(decoded)
        self.known_lines = {}
        self.make_crossings(decoded)
        self.make_curves(decoded)
        self.limits = [self.limits_of(*spanned) for spanned in self.index.ranges]

    def interpolated(self, values, coordinates):
        """What is interpolated of the stored values at these coordinates: in the value domain, less the guide."""
        found = [domain.forward(value) for domain, value in zip(self.domains, values)]
        if self.guide:
            found = [v - self.guide.at(coordinates[0], coordinates[3], c) for c, v in zip(self.channels, found)]
        return found

    def make_crossings(self, decoded):
        rows = zip(decoded.crossing_values, self.lattice.crossing_coordinates)
        self.crossings = [self.interpolated(values, coordinates) for values, coordinates in rows]

    def make_curves(self, decoded):
        self.curves = []
        stored = iter(decoded.sample_values)
        for piece, sampled in zip(self.lattice.slices, decoded.sampled):
            positions, rows = [], []
            for sample in sampled.known:
                positions.append(sample.position)
                if sample.depth == 0:
                    rows.append(self.crossings[piece.nodes[sample.interval][1]])
                    continue
                coordinates = list(piece.line.offset)
                coordinates[piece.kind] = sample.position
                rows.append(self.interpolated(next(stored), coordinates))
            self.curves.append([Curve(piece.mode, piece.length, positions, column) for column in zip(*rows)])

    @staticmethod
    def limits_of(least, greatest):
        """Between which values `w` is kept."""
        most = min(16 * max(abs(least), abs(greatest)), LARGEST_F32)
        return (0.0 if least >= 0 else -most), most

    def on_line(self, line, x):
        """Values of all channels on a line of the lattice or of a ring, at the coordinate `x` along it."""
        key = tuple(map(tuple, line))
        if key not in self.known_lines:
            standing, number = self.lattice.standing_for(*line)
            axis = standing.moving_axis()
            self.known_lines[key] = (number, None if axis == 4 else (standing.slope[axis], standing.offset[axis]))
        number, moves = self.known_lines[key]
        if moves is None:
            return self.crossings[number]
        slope, start = moves
        position = self.lattice.slices[number].bring_into_extent(slope * x + start)
        return [curve.at(position) for curve in self.curves[number]]

    def sums_in_cell(self, x):
        """R at the coordinates `x`, not yet limited, for each channel."""
        axes = self.lattice.axes
        cells = [cell_of(nodes, coordinate) for nodes, coordinate in zip(axes, x)]
        used = [axis for axis in range(4) if len(axes[axis]) > 1]
        x = [min(coordinate, nodes[-1]) for nodes, coordinate in zip(axes, x)]
        totals, slices = [0.0] * len(self.channels), [[] for _ in self.channels]
        for moving in used:
            for weight, corner in corners([axis for axis in used if axis != moving], cells):
                offset = [0.0 if axis == moving else axes[axis][corner[axis]] for axis in range(4)]
                line = (offset, [int(axis == moving) for axis in range(4)])
                for channel, value in enumerate(self.on_line(line, x[moving])):
                    totals[channel] += weight * value
                    slices[channel].append(value)
        for weight, corner in corners(used, cells):
            for channel, value in enumerate(self.crossings[self.lattice.crossing_at[tuple(corner)]]):
                totals[channel] -= (len(used) - 1) * weight * value
        return [Sum(total, found) for total, found in zip(totals, slices)]

    def sums_on_ring(self, ring, x):
        """R_ring, not yet limited, for each channel."""
        place = ring.place(x[0], x[1])
        other_nodes = self.lattice.axes[ring.other_axis]
        (k, t), (j, r) = cell_of(ring.nodes, place), cell_of(other_nodes, x[ring.other_axis])
        at_other = min(x[ring.other_axis], other_nodes[-1])
        totals, slices = [0.0] * len(self.channels), [[] for _ in self.channels]

        def add(weight, values, of_slice):
            for channel, value in enumerate(values):
                totals[channel] += weight * value
                if of_slice:
                    slices[channel].append(value)

        ring_ends = ((1 - t, ring.nodes[k]), (t, ring.nodes[k + 1]))
        other_ends = ((1 - r, other_nodes[j]), (r, other_nodes[j + 1]))
        for weight, other in other_ends:
            add(weight, self.on_line(ring.line(ring.along, 0.0, other), place), True)
        for weight, node in ring_ends:
            add(weight, self.on_line(ring.line(ring.other_axis, node, 0.0), at_other), True)
            for other_weight, other in other_ends:
                add(-weight * other_weight, self.on_line(ring.line(None, node, other), None), False)
        return [Sum(total, found) for total, found in zip(totals, slices)]

    def reconstructed(self, x):
        """Steps 2 to 5: r for each channel."""
        sums = self.sums_in_cell(x)
        found = [total.within(self.log) for total in sums]
        for ring in self.rings:
            k, t = cell_of(self.lattice.axes[ring.polar_axis], x[ring.polar_axis])
            if k != 0:
                continue
            face = list(x)
            face[ring.polar_axis] = 0.0
            on_ring, on_face = self.sums_on_ring(ring, x), self.sums_in_cell(face)
            for channel in self.channels:
                found[channel] += (1 - t) * (on_ring[channel].within(self.log) - on_face[channel].within(self.log))
                sums[channel].least = min(sums[channel].least, on_ring[channel].least)
                sums[channel].greatest = max(sums[channel].greatest, on_ring[channel].greatest)
        for channel in self.channels:
            sums[channel].total = found[channel]
        return [total.within(self.log) for total in sums]

    def coordinates(self, theta_i, phi_i, theta_v, phi_v):
        frame = elevation_coordinates if self.index.frame == ELEVATION else half_difference_coordinates
        return frame(theta_i, within(phi_i, 360), theta_v, within(phi_v, 360))

    def f_r(self, theta_i, phi_i, theta_v, phi_v):
        if max(theta_i, theta_v) > 90:
            return [0.0] * len(self.channels)
        return self.f_r_at(self.coordinates(theta_i, phi_i, theta_v, phi_v))

    def f_r_at(self, x):
        w = []
        for channel, v in enumerate(self.reconstructed(x)):
            if self.guide:
                v += self.guide.at(x[0], x[3], channel)
            least, most = self.limits[channel]
            w.append(min(max(self.domains[channel].back(v), least), most))
        if not self.index.grey:
            return w
        shares = [share / 64 for share in self.index.grey]
        grey = sum(w) / (len(w) + sum(shares))
        return [value - share * grey for value, share in zip(w, shares)]


def corners(axes, cells):
    """Corners of a cell: the products of the weights on these axes, and lattice indices."""
    found = [(1.0, [k for k, _ in cells])]
    for axis in axes:
        t = cells[axis][1]
        near = [(weight * (1 - t), corner) for weight, corner in found]
        far = [(weight * t, corner[:axis] + [corner[axis] + 1] + corner[axis + 1:]) for weight, corner in found]
        found = near + far
    return found
