#!/usr/bin/env python3
"""Draws the force on a tip on a mesh, as SVG: the paths of tip and god object, and the force over time.

    build/release/bin/thimble simulate scenes/asteroid/asteroid.scene.json \\
        --path scenes/asteroid/stroke.csv --ideal --log asteroid.csv
    docs/plot_force.py scenes/asteroid/asteroid.scene.json asteroid.csv > docs/images/asteroid_force.svg

Reads the scene's first object, a .plg mesh without rotation. Python's standard library only.
"""
import csv
import json
import math
import pathlib
import sys

WIDTH, HEIGHT = 860, 330
VIEW = (168, 160)  # where the mesh's middle is drawn
CHART = (385, 30, 420, 250)  # left, top, width, height
AZIMUTH, ELEVATION = math.radians(-30), math.radians(50)
LIGHT = (-0.35, -0.5, 0.79)


def read_plg(path):
    lines = [line.split("#")[0].split() for line in path.read_text().splitlines()]
    lines = [words for words in lines if words]
    vertices, facets = int(lines[0][1]), int(lines[0][2])
    # Left-handed: z changes its sign, and with it the way round.
    points = [(float(x), float(y), -float(z)) for x, y, z in (words[:3] for words in lines[1:1 + vertices])]
    loops = [[int(i) for i in words[2:2 + int(words[1])]] for words in lines[1 + vertices:1 + vertices + facets]]
    return points, loops


def read_scene(path):
    item = json.loads(path.read_text())["objects"][0]
    mesh, at = item["shape"]["mesh"], item["pose"]["position_m"]
    points, loops = read_plg(path.parent / mesh["file"])
    return [tuple(mesh["scale"] * v + o for v, o in zip(p, at)) for p in points], loops, at


def project(point, middle):
    """Seen from the front, the right and above; pixels, and how near."""
    x, y, z = (a - b for a, b in zip(point, middle))
    across = x * math.cos(AZIMUTH) - y * math.sin(AZIMUTH)
    away = x * math.sin(AZIMUTH) + y * math.cos(AZIMUTH)
    up = z * math.cos(ELEVATION) + away * math.sin(ELEVATION)
    near = z * math.sin(ELEVATION) - away * math.cos(ELEVATION)
    return VIEW[0] + 4050 * across, VIEW[1] - 4050 * up, near


def draw_mesh(points, loops, middle):
    seen = []
    for loop in loops:
        a, b, c = (points[i] for i in loop[:3])
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        size = math.hypot(*n)
        if sum(k * (p - m) for k, p, m in zip(n, a, middle)) < 0:
            size = -size  # the file winds it the other way; the body is round enough to tell
        corners = [project(points[i], middle) for i in loop]
        toward = project([m + k / size for m, k in zip(middle, n)], middle)[2]
        if toward > 0:
            light = max(sum(k / size * l for k, l in zip(n, LIGHT)), 0)
            seen.append((sum(c[2] for c in corners), corners, 0.62 - 0.5 * light))
    for _, corners, dark in sorted(seen):
        shape = " ".join(f"{x:.1f},{y:.1f}" for x, y, _ in corners)
        yield f'<polygon class="rock" fill-opacity="{dark:.2f}" points="{shape}"/>'


def line(css, pixels):
    return f'<polyline class="{css}" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in pixels)}"/>'


def draw_ways(rows, middle):
    touching = [row for row in rows if row["contacts"] > 0]
    for css, name in (("tip", "tip"), ("god", "proxy")):
        yield line(css, [project([row[f"{name}_{k}_m"] for k in "xyz"], middle)[:2] for row in touching[::40]])


def draw_forces(rows):
    left, top, width, height = CHART
    last = rows[-1]["time_s"]
    axes = [f"force_{k}_N" for k in "xyz"]
    low = math.floor(min(min(row[k] for k in axes) for row in rows))
    high = math.ceil(max(max(row[k] for k in axes) for row in rows))
    to_x = lambda time_s: left + width * time_s / last
    to_y = lambda force_N: top + height * (high - force_N) / (high - low)
    for force in range(low, high + 1, 2 if high - low > 6 else 1):
        y = to_y(force)
        yield f'<line class="{"axis" if force == 0 else "grid"}" x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}"/>'
        yield f'<text class="end" x="{left - 8}" y="{y + 4:.1f}">{force}</text>'
    for second in range(0, int(last) + 1):
        yield f'<text class="mid" x="{to_x(second):.1f}" y="{top + height + 18}">{second}</text>'
    yield f'<text class="mid" x="{left + width / 2}" y="{top + height + 38}">time, s</text>'
    yield f'<text x="{left}" y="{top - 12}">force on the hand, N</text>'
    # Least and most of each half pixel, so that every slip is seen.
    per = max(len(rows) // (2 * width), 1)
    for axis, key in zip("xyz", axes):
        pixels = []
        for start in range(0, len(rows), per):
            part = rows[start:start + per]
            ends = sorted((min(part, key=lambda r: r[key]), max(part, key=lambda r: r[key])), key=lambda r: r["time_s"])
            pixels += [(to_x(row["time_s"]), to_y(row[key])) for row in ends]
        yield line(f"force {axis}", pixels)
    for row, axis in enumerate("xyz"):
        y = top + 8 + 20 * row
        yield f'<line class="force {axis}" x1="{left + width + 12}" x2="{left + width + 28}" y1="{y}" y2="{y}"/>'
        yield f'<text x="{left + width + 33}" y="{y + 4}">{axis}</text>'


STYLE = """
  svg { --back: #ffffff; --ink: #24292f; --soft: #d8dee4; --x: #0072b2; --y: #c05a00; --z: #00805c; --tip: #b0307a; }
  @media (prefers-color-scheme: dark) {
    svg { --back: #0d1117; --ink: #d5dbe1; --soft: #30363d; --x: #58a6ff; --y: #f0943a; --z: #3fc79a; --tip: #ff7bbd; }
  }
  text { font: 13px sans-serif; fill: var(--ink) } .mid { text-anchor: middle } .end { text-anchor: end }
  .back { fill: var(--back) } .grid { stroke: var(--soft) } .axis { stroke: var(--ink) }
  .rock { fill: var(--ink); stroke: var(--back); stroke-width: .8; stroke-linejoin: round }
  polyline, .force { fill: none; stroke-width: 1.4 }
  .x { stroke: var(--x) } .y { stroke: var(--y) } .z { stroke: var(--z) }
  .god { stroke: var(--x); stroke-width: 2.4 } .tip { stroke: var(--tip); stroke-width: 1.6; stroke-dasharray: 4 3 }
"""


def main():
    scene, log = (pathlib.Path(name) for name in sys.argv[1:3])
    points, loops, middle = read_scene(scene)
    with log.open(newline="") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">',
           f"<title>Stroking {scene.name.split('.')[0]}: the ways of tip and god object, and the force over time</title>",
           f"<style>{STYLE}</style>",
           f'<rect class="back" width="{WIDTH}" height="{HEIGHT}"/>']
    out += draw_mesh(points, loops, middle)
    out += draw_ways(rows, middle)
    for row, (css, text) in enumerate((("god", "god object"), ("tip", "fingertip, inside the stone"))):
        x, y = 20 + 120 * row, HEIGHT - 12
        out += [f'<line class="{css}" x1="{x}" x2="{x + 22}" y1="{y - 4}" y2="{y - 4}"/>', f'<text x="{x + 28}" y="{y}">{text}</text>']
    out += draw_forces(rows)
    print("\n".join(out + ["</svg>"]))


main()
