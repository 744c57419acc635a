#!/usr/bin/python3
"""Draws the stamp images of this folder: 256 x 256 texels, 16-bit grey, white = full weight, black = none.

Usage: make_stamps.py [FOLDER]        (default: the folder of this script; needs numpy, Debian's python3-numpy)

A shape is a function of (x, y), both in [-1, 1]: x along the columns, which a stamp maps to +x, the walking or driving
direction; y down the rows, which it maps to +z. Shapes are signed distances (negative inside), turned into weights by a
smoothstep EDGE texels wide, so that bilinear sampling has something to sample. The two outermost rings of texels are
black, so a stamp never ends in a step. Two runs give the same bytes; the images that count are the committed ones (a
numpy with another last bit in its cosine may round a texel the other way).
"""

import os
import struct
import sys
import zlib

import numpy as np

SIZE = 256
EDGE = 5.0  # width of a soft edge, texels
TEXEL = 2.0 / SIZE

ROWS, COLUMNS = np.mgrid[0:SIZE, 0:SIZE]
X = (COLUMNS + 0.5) * TEXEL - 1
Y = (ROWS + 0.5) * TEXEL - 1


# ---- signed distances and weights ----

def box(x, y, centre, half, round_by=0.0, turn=0.0):
    """Rectangle of half sides `half`, corners rounded by `round_by`, turned by `turn` radians."""
    dx, dy = x - centre[0], y - centre[1]
    c, s = np.cos(turn), np.sin(turn)
    qx = np.abs(c * dx + s * dy) - half[0] + round_by
    qy = np.abs(c * dy - s * dx) - half[1] + round_by
    return np.hypot(np.maximum(qx, 0), np.maximum(qy, 0)) + np.minimum(np.maximum(qx, qy), 0) - round_by


def ellipse(x, y, centre, radii, turn=0.0):
    """Ellipse; the distance is exact to first order, which is all that a soft edge needs."""
    dx, dy = x - centre[0], y - centre[1]
    c, s = np.cos(turn), np.sin(turn)
    u, v = (c * dx + s * dy) / radii[0], (c * dy - s * dx) / radii[1]
    level = np.hypot(u, v)
    slope = np.hypot(u / radii[0], v / radii[1]) / np.maximum(level, 1e-6)
    return (level - 1) / np.maximum(slope, 1e-6)


def polygon(x, y, corners):
    """Exact distance to a closed polygon, by its edges and the winding of its corners."""
    corners = np.asarray(corners, float)
    nearest = np.full_like(x, np.inf)
    inside = np.zeros(x.shape, bool)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        along = np.clip(((x - a[0]) * (b[0] - a[0]) + (y - a[1]) * (b[1] - a[1])) / np.sum((b - a) ** 2), 0, 1)
        nearest = np.minimum(nearest, np.hypot(x - a[0] - along * (b[0] - a[0]), y - a[1] - along * (b[1] - a[1])))
        crosses = (a[1] > y) != (b[1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0])
    return np.where(inside, -nearest, nearest)


def union(*shapes):
    return np.minimum.reduce(shapes)


def without(shape, hole):
    return np.maximum(shape, -hole)


def outline(points, samples=24):
    """A smooth closed curve through `points` (Catmull-Rom), as the corners of a polygon."""
    p = np.asarray(points, float)
    t = np.arange(samples)[:, None] / samples
    curve = []
    for i in range(len(p)):
        a, b, c, d = p[i - 1], p[i], p[(i + 1) % len(p)], p[(i + 2) % len(p)]
        curve.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t ** 2 + (3 * b - a - 3 * c + d) * t ** 3))
    return np.concatenate(curve)


def smoothstep(low, high, value):
    t = np.clip((value - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def weight(distance, edge=EDGE):
    """1 inside, 0 outside, soft over `edge` texels."""
    return 1 - smoothstep(-edge / 2 * TEXEL, edge / 2 * TEXEL, distance)


# ---- the stamps ----

def boot():
    """A right boot's sole, toe towards +x: the tread's lugs press deepest, the sole between them half as deep."""
    sole = polygon(X, Y, outline([(0.93, 0.02), (0.84, -0.22), (0.58, -0.36), (0.28, -0.34), (-0.05, -0.23), (-0.32, -0.20),
                                  (-0.62, -0.27), (-0.85, -0.22), (-0.94, 0.0), (-0.85, 0.22), (-0.62, 0.27), (-0.30, 0.20),
                                  (0.0, 0.19), (0.30, 0.28), (0.58, 0.33), (0.82, 0.24)]))
    heel_gap = box(X, Y, (-0.33, 0), (0.055, 0.5))
    lugs = [box(X, Y, (at, side * 0.165), (0.052, 0.17), 0.02, side * 0.45)
            for at in np.arange(-0.02, 0.80, 0.165) for side in (-1, 1)]
    lugs += [box(X, Y, (at, 0), (0.042, 0.2), 0.02) for at in (-0.80, -0.65, -0.50)]
    rim = without(sole, sole + 0.055)
    inner = np.maximum(union(*lugs), sole + 0.085)
    tread = np.maximum(union(rim, inner), -heel_gap)
    return np.maximum(weight(sole, 7) * (0.45 - 0.25 * weight(heel_gap, 8)), weight(tread))


def paw():
    """A dog's paw, toes towards +x: one pad, four toes, claws."""
    pad = polygon(X, Y, outline([(0.12, 0.0), (0.02, -0.25), (-0.22, -0.46), (-0.50, -0.50), (-0.62, -0.34), (-0.55, -0.12),
                                 (-0.52, 0.0), (-0.55, 0.12), (-0.62, 0.34), (-0.50, 0.50), (-0.22, 0.46), (0.02, 0.25)]))
    toes, claws = [], []
    for side in (-1, 1):
        toes += [ellipse(X, Y, (0.47, side * 0.23), (0.25, 0.165), side * 0.10),
                 ellipse(X, Y, (0.10, side * 0.58), (0.23, 0.155), side * 0.32)]
        claws += [ellipse(X, Y, (0.83, side * 0.27), (0.10, 0.035), side * 0.12),
                  ellipse(X, Y, (0.42, side * 0.73), (0.10, 0.035), side * 0.40)]
    pressed = union(pad, *toes)
    depth = 0.72 + 0.28 * smoothstep(0.0, 0.16, -pressed)  # pads are round: deepest in their middles
    return np.maximum(weight(pressed) * depth, 0.8 * weight(union(*claws), 4))


def tyre():
    """A length of tyre track along x, whole tread periods long, so that prints joined end to end go on."""
    period = 0.38
    along = (X + np.abs(Y) * 0.55) / period  # chevrons pointing along +x
    slot = np.abs(along - np.floor(along) - 0.5) * period - 0.125
    shoulder = np.abs(Y) - 0.62
    lugs = np.maximum(slot, np.maximum(shoulder, 0.15 - np.abs(Y)))
    rib = np.abs(Y) - 0.09
    blocks = (X - 0.06) / (period / 2)
    sides = np.maximum(np.abs(np.abs(Y) - 0.71) - 0.055, np.abs(blocks - np.floor(blocks) - 0.5) * period / 2 - 0.060)
    tread = union(lugs, rib, sides)
    ends = np.abs(X) - 0.95
    return np.maximum(0.4 * weight(np.maximum(np.abs(Y) - 0.78, ends), 12), weight(np.maximum(tread, ends)))


def track():
    """One link of a tracked vehicle: a plate across the track with a grouser bar, two pads and the pin's lugs."""
    plate = box(X, Y, (0, 0), (0.40, 0.90), 0.05)
    bar = box(X, Y, (0.0, 0), (0.085, 0.90), 0.04)
    pads = [box(X, Y, (0.0, side * 0.52), (0.27, 0.27), 0.06) for side in (-1, 1)]
    pins = [box(X, Y, (end * 0.52, at), (0.14, 0.075), 0.03) for end, row in ((1, (-0.68, -0.23, 0.23, 0.68)),
                                                                             (-1, (-0.45, 0.0, 0.45))) for at in row]
    guide = [box(X, Y, (0, 0), (0.27, 0.06), 0.03)]
    return np.maximum.reduce([0.5 * weight(union(plate, *pins)), 0.78 * weight(union(*pads, *guide)), weight(bar)])


def rubble():
    """Broken stones of many sizes, each with its own height and tilt. For `add` with a positive amplitude."""
    state = 12345

    def random():
        nonlocal state
        state = (state * 6364136223846793005 + 1442695040888963407) % 2 ** 64
        return (state >> 33) / 2 ** 31

    placed, heap = [], np.zeros_like(X)
    for radius in [0.27, 0.22, 0.2] + [0.15] * 7 + [0.10] * 16 + [0.065] * 40 + [0.04] * 70:
        for _ in range(200):
            r, a = 0.88 * np.sqrt(random()), 2 * np.pi * random()
            cx, cy = r * np.cos(a), r * np.sin(a)
            fits = np.hypot(cx, cy) + radius < 0.95
            if fits and all(np.hypot(cx - px, cy - py) > 0.86 * (radius + pr) for px, py, pr in placed):
                break
        else:
            continue
        placed.append((cx, cy, radius))
        corners, start = 5 + int(3 * random()), 2 * np.pi * random()
        angles = [start + 2 * np.pi * (i + 0.5 * (random() - 0.5)) / corners for i in range(corners)]
        reach = [radius * (0.8 + 0.25 * random()) for _ in angles]
        stone = polygon(X, Y, [(cx + q * np.cos(b), cy + q * np.sin(b)) for q, b in zip(reach, angles)])
        tilt, lean = 2 * np.pi * random(), 0.25 + 0.3 * random()
        top = 0.45 + 0.55 * min(1.0, radius / 0.25) + lean * ((X - cx) * np.cos(tilt) + (Y - cy) * np.sin(tilt)) / radius * 0.5
        heap = np.maximum(heap, weight(stone) * np.clip(top * (0.75 + 0.25 * smoothstep(0, radius * 0.4, -stone)), 0.1, 1))
    return heap / heap.max()


def spade():
    """A spade's cut, pushed in at +x: deepest along the curved blade, rising gently to the back."""
    cut = polygon(X, Y, outline([(0.62, 0.0), (0.55, -0.28), (0.34, -0.50), (0.0, -0.54), (-0.4, -0.53), (-0.70, -0.50),
                                 (-0.78, -0.3), (-0.80, 0.0), (-0.78, 0.3), (-0.70, 0.50), (-0.4, 0.53), (0.0, 0.54),
                                 (0.34, 0.50), (0.55, 0.28)]))
    floor = 0.18 + 0.82 * smoothstep(-0.85, 0.45, X + 0.35 * Y * Y)
    return weight(cut, 7) * floor


def hoof():
    """A shod horse's hoof, toe towards +x: the shoe's arch with its nail groove, the frog pressed less."""
    outer = polygon(X, Y, outline([(0.80, 0.0), (0.74, -0.30), (0.50, -0.58), (0.14, -0.70), (-0.24, -0.68), (-0.60, -0.56),
                                   (-0.80, -0.38), (-0.76, -0.24), (-0.60, 0.0), (-0.76, 0.24), (-0.80, 0.38),
                                   (-0.60, 0.56), (-0.24, 0.68), (0.14, 0.70), (0.50, 0.58), (0.74, 0.30)]))
    inner = polygon(X, Y, outline([(0.50, 0.0), (0.44, -0.22), (0.26, -0.38), (0.0, -0.44), (-0.35, -0.40), (-0.72, -0.27),
                                   (-1.1, -0.16), (-1.1, 0.16), (-0.72, 0.27), (-0.35, 0.40), (0.0, 0.44), (0.26, 0.38),
                                   (0.44, 0.22)]))
    shoe = np.maximum(outer, -inner)
    ridge = np.maximum(np.abs(outer + 0.125) - 0.022, 0.05 - np.abs(Y))
    nails = np.maximum(ridge, np.maximum(-0.30 - X, X - 0.62))
    frog = polygon(X, Y, [(0.22, 0.0), (-0.50, -0.23), (-0.60, -0.12), (-0.44, 0.0), (-0.60, 0.12), (-0.50, 0.23)]) - 0.02
    sole = np.maximum(outer, inner + 0.02)
    return np.maximum.reduce([weight(shoe) * (1 - 0.45 * weight(nails, 4)), 0.25 * weight(sole), 0.65 * weight(frog)])


def letter():
    """The letter R, upright when columns run to the right and rows down: it shows every turn and every mirroring."""
    stem = box(X, Y, (-0.42, 0), (0.15, 0.80), 0.03)
    bowl = without(box(X, Y, (-0.23, -0.36), (0.77, 0.44), 0.40), box(X, Y, (-0.02, -0.36), (0.27, 0.18), 0.17))
    bowl = np.maximum(bowl, -0.45 - X)
    leg = polygon(X, Y, [(-0.12, 0.02), (0.20, -0.02), (0.62, 0.80), (0.26, 0.80)]) - 0.02
    return weight(union(stem, bowl, leg))


STAMPS = [boot, paw, tyre, track, rubble, spade, hoof, letter]


# ---- files ----

def finished(shape):
    """Weights as 16-bit integers, with black rings at the border."""
    ring = np.minimum(np.minimum(COLUMNS, SIZE - 1 - COLUMNS), np.minimum(ROWS, SIZE - 1 - ROWS))
    texels = np.floor(np.clip(shape, 0, 1) * smoothstep(1, 6, ring) * 65535 + 0.5).astype(np.uint16)
    assert texels.max() == 65535 and not texels[ring < 2].any()
    return texels


def write_png16(path, texels):
    """16-bit grey PNG, not interlaced; each row by the Up filter, which suits smooth images."""
    rows = texels.astype(">u2").view(np.uint8).reshape(SIZE, 2 * SIZE)
    above = np.vstack([np.zeros((1, 2 * SIZE), np.uint8), rows[:-1]])
    filtered = np.hstack([np.full((SIZE, 1), 2, np.uint8), rows - above])

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", SIZE, SIZE, 16, 0, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(filtered.tobytes(), 9)) +
                   chunk(b"IEND", b""))


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    for shape in STAMPS:
        path = os.path.join(folder, shape.__name__ + ".png")
        write_png16(path, finished(shape()))
        print(path, os.path.getsize(path), "bytes")


if __name__ == "__main__":
    main()
