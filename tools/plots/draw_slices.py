#!/usr/bin/env python3
"""Draws specs/slices.svg: what slices, crossings, samples and a cell are.

usage: draw_slices.py [--check] FILE    with --check, fails unless the file is what would be written

Kinds of slices differ in dashes as well as in colour, and the colours are those that colour-blind people can tell apart
(Okabe and Ito). Beside the colours for a light page there are some for a dark one.
"""
import math
import pathlib
import sys

NODES = [0, 90, 180, 270, 360]  # of s and of u [degrees]
THETA_I = 45
THETA_V = [15, 45, 75]  # of the subspaces drawn on the right
CELL = {"s": (180, 270), "u": (90, 180), "theta_v": (15, 45)}

STYLE = """
  text { font: 14px sans-serif }
  .title { font-size: 16px; font-weight: bold }
  .small { font-size: 13px }
  .cell { fill-opacity: .45 }
  .face { fill-opacity: .2 }
  .axial { stroke-width: 2.2; fill: none }
  .diagonal { stroke-width: 2.2; stroke-dasharray: 9 4; fill: none }
  .horizontal { stroke-width: 3.4; stroke-dasharray: 2.5 3; fill: none }
  .thin { stroke-width: 1.2 }
  .corner { fill: none; stroke-width: 2 }
  .sample { stroke-width: 1.3 }
"""
PAINTS = [("text", "fill", "ink"), (".paper", "fill", "paper"), (".highlight", "fill", "highlight"),
          (".cell", "fill", "cell"), (".axial", "stroke", "axial"), (".diagonal", "stroke", "diagonal"),
          (".horizontal", "stroke", "horizontal"), (".crossing", "fill", "ink"), (".corner", "stroke", "ink"),
          (".sample", "fill", "paper"), (".sample", "stroke", "ink")]
LIGHT = {"paper": "#ffffff", "ink": "#1b1f24", "axial": "#0072b2", "diagonal": "#d55e00", "horizontal": "#007a5a",
         "highlight": "#f3e7a1", "cell": "#8f9aa5"}
DARK = {"paper": "#14181d", "ink": "#e8ebee", "axial": "#56b4e9", "diagonal": "#f0a35c", "horizontal": "#35c9a0",
        "highlight": "#4a431c", "cell": "#77828d"}


def painted(colours, indent):
    """Plain rules: programs that print or convert pictures know no variables of style sheets."""
    return "".join(f"{indent}{selector} {{ {what}: {colours[name]} }}\n" for selector, what, name in PAINTS)


def number(value):
    return f"{value:.1f}".removesuffix(".0")


def brightness(s, u, theta_v):
    """A highlight where the viewer sees the mirror image of the light, brighter along one direction of the material."""
    along = 0.55 + 0.45 * math.cos(math.radians(s - 180))
    return along * math.exp(-((u - 180) / 22) ** 2) * math.exp(-((theta_v - THETA_I) / 14) ** 2)


def halve(begin, end, value, least):
    """Middles of intervals in which a straight line is too far from the value, as adaptive sampling finds them."""
    middle = (begin + end) / 2
    if end - begin <= least:
        return []
    quarters = [begin + (end - begin) * t for t in (0.25, 0.5, 0.75)]
    line = [value(begin) + (value(end) - value(begin)) * t for t in (0.25, 0.5, 0.75)]
    if max(abs(value(x) - y) for x, y in zip(quarters, line)) < 0.05:
        return []
    return halve(begin, middle, value, least) + [middle] + halve(middle, end, value, least)


def adaptive(nodes, value, least):
    return [x for begin, end in zip(nodes, nodes[1:]) for x in halve(begin, end, value, least)]


class Drawing:
    def __init__(self, width, height):
        self.width, self.height, self.lines = width, height, []

    def add(self, text):
        self.lines.append("  " + text)

    def path(self, kind, points, closed=False):
        steps = " L".join(f"{number(x)} {number(y)}" for x, y in points)
        self.add(f'<path class="{kind}" d="M{steps}{"Z" if closed else ""}"/>')

    def circle(self, kind, point, radius):
        self.add(f'<circle class="{kind}" cx="{number(point[0])}" cy="{number(point[1])}" r="{radius}"/>')

    def diamond(self, point, radius=4):
        x, y = point
        self.path("sample", [(x - radius, y), (x, y - radius), (x + radius, y), (x, y + radius)], closed=True)

    def text(self, x, y, words, kind="", anchor="start"):
        attributes = (f' class="{kind}"' if kind else "") + (f' text-anchor="{anchor}"' if anchor != "start" else "")
        self.add(f'<text x="{number(x)}" y="{number(y)}"{attributes}>{words}</text>')

    def svg(self, title, description):
        style = (STYLE + painted(LIGHT, "  ") + "  @media (prefers-color-scheme: dark) {\n" + painted(DARK, "    ") + "  }\n")
        head = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" '
                f'height="{self.height}" role="img" aria-labelledby="t d">',
                f'  <title id="t">{title}</title>', f'  <desc id="d">{description}</desc>',
                f"  <style>{style}  </style>",
                f'  <rect class="paper" width="{self.width}" height="{self.height}" rx="6"/>']
        return "\n".join([*head, *self.lines, "</svg>"]) + "\n"


def draw_subspace(out):
    """Both elevations fixed: a square of the two azimuths, crossed by axial and diagonal slices."""
    def at(s, u):
        return 74 + s, 430 - u

    out.text(74, 28, "Light and viewer at fixed elevations", "title")
    out.text(74, 50, f"theta_i = theta_v = {THETA_I}&#176;, all azimuths: one subspace", "small")
    out.path("highlight", [at(0, 158), at(360, 158), at(360, 202), at(0, 202)], closed=True)
    (s0, s1), (u0, u1) = CELL["s"], CELL["u"]
    out.path("cell", [at(s0, u0), at(s1, u0), at(s1, u1), at(s0, u1)], closed=True)
    for node in NODES:
        out.path("axial", [at(0, node), at(360, node)])
        out.path("diagonal", [at(node, 0), at(node, 360)])
        out.text(at(node, 0)[0], 452, f"{node}&#176;", "small", "middle")
        out.text(64, at(0, node)[1] + 5, f"{node}&#176;", "small", "end")
    for node in NODES:
        for u in adaptive(NODES, lambda u, s=node: brightness(s, u, THETA_I), 12):
            out.diamond(at(node, u))
        for s in adaptive(NODES, lambda s, u=node: brightness(s, u, THETA_I), 12):
            out.diamond(at(s, node))
        for other in NODES:
            out.circle("crossing", at(node, other), 4.5)
    for s in CELL["s"]:
        for u in CELL["u"]:
            out.circle("corner", at(s, u), 9)
    out.text(254, 474, "s = phi_i + phi_v", "", "middle")
    out.add('<text transform="translate(22 250) rotate(-90)" text-anchor="middle">u = phi_i &#8722; phi_v</text>')
    out.text(at(225, 0)[0], at(0, 131)[1], "a cell", "", "middle")
    out.text(at(7, 0)[0], at(0, 209)[1], "highlight", "small")


def draw_stack(out):
    """The elevation of the viewer varies, too: subspaces above one another, joined by horizontal slices."""
    def at(s, u, theta_v):
        return 570 + 0.74 * s + 0.27 * u, 434 - 0.26 * u - 4.1 * (theta_v - THETA_V[0])

    out.text(520, 28, "The viewer's elevation varies as well", "title")
    out.text(520, 50, "theta_i = 45&#176;; horizontal slices join the crossings of all subspaces", "small")
    (s0, s1), (u0, u1), (low, high) = CELL["s"], CELL["u"], CELL["theta_v"]
    for theta_v in THETA_V:
        out.path("highlight", [at(s, u, theta_v) for s, u in ((0, 158), (360, 158), (360, 202), (0, 202))], closed=True)
    rim = [(s0, u0), (s1, u0), (s1, u1), (s0, u1)]
    faces = [[(s, u, theta_v) for s, u in rim] for theta_v in (low, high)]
    faces += [[(*a, low), (*b, low), (*b, high), (*a, high)] for a, b in zip(rim, rim[1:] + rim[:1])]
    for face in faces:
        out.path("cell face", [at(*corner) for corner in face], closed=True)
    for theta_v in THETA_V:
        for node in NODES:
            out.path("axial thin", [at(0, node, theta_v), at(360, node, theta_v)])
            out.path("diagonal thin", [at(node, 0, theta_v), at(node, 360, theta_v)])
        for s in NODES:
            for u in NODES:
                out.circle("crossing", at(s, u, theta_v), 2.6)
        x, y = at(0, 0, theta_v)
        out.text(x - 10, y + 5, f"theta_v = {theta_v}&#176;", "small", "end")
    for s in CELL["s"]:
        for u in CELL["u"]:
            top = THETA_V[-1] if (s, u) == (s0, u1) else high
            out.path("horizontal", [at(s, u, low), at(s, u, top)])
            for theta_v in (low, high):
                out.circle("corner", at(s, u, theta_v), 6)
    for theta_v in adaptive(THETA_V, lambda theta_v: brightness(s0, u1, theta_v), 3):
        out.diamond(at(s0, u1, theta_v))


def draw_legend(out):
    y = 510
    for x, kind, words in ((40, "axial", "axial slice: u fixed"), (262, "diagonal", "diagonal slice: s fixed"),
                           (516, "horizontal", "horizontal slice: all but theta_v fixed")):
        out.path(kind, [(x, y - 5), (x + 40, y - 5)])
        out.text(x + 48, y, words, "small")
    y = 538
    out.circle("crossing", (60, y - 5), 4.5)
    out.text(88, y, "crossing: measured", "small")
    out.diamond((282, y - 5))
    out.text(310, y, "adaptive sample", "small")
    out.circle("corner", (536, y - 5), 7)
    out.text(564, y, "corner of the cell: 4 on the left, 8 on the right, 16 in all", "small")


def drawing():
    out = Drawing(1000, 556)
    draw_subspace(out)
    draw_stack(out)
    draw_legend(out)
    return out.svg(
        "Slices, crossings, samples and a cell",
        "On the left a square of azimuths with axial slices across and diagonal slices upwards; dots mark their crossings, "
        "diamonds samples that lie closer together at a highlight; four crossings are the corners of a shaded cell. On the "
        "right three such squares above one another for three elevations of the viewer; horizontal slices join crossings of "
        "one square to those of the next, and the cell has become a box with eight corners.")


def main():
    arguments = sys.argv[1:]
    check = arguments[:1] == ["--check"]
    if len(arguments) != 1 + check:
        print(__doc__, file=sys.stderr)
        return 1
    path = pathlib.Path(arguments[-1])
    if not check:
        path.write_text(drawing(), encoding="utf-8")
    elif path.read_text(encoding="utf-8") != drawing():
        print(f"{path} is not what {pathlib.Path(__file__).name} writes: run it again without --check")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
