#!/usr/bin/env python3
"""Writes room.glb, a furnished room as glTF programs export them, and room-full.glb, the same with plants, beads and a rug of tufts,
117748 triangles by instances: python3 make_room.py

Metres, y up. The floor is lacquered wood, walls and ceiling are matte (no specular part), the kettle, the pots and the lamp
are rough metal, the faucet is nearly a mirror; daylight from a shining sheet behind the window, lamplight from a bulb."""
import json
import math
import pathlib
import random
import struct
import zlib

HERE = pathlib.Path(__file__).parent


class Room:
    """A binary glTF file that grows."""

    def __init__(self):
        self.data = b""
        self.json = {"asset": {"version": "2.0", "generator": "make_room.py"}, "scene": 0, "scenes": [{"nodes": []}],
                     "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "cameras": [],
                     "images": [], "textures": [], "extensionsUsed": []}

    def view(self, data):
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)})
        self.data += data.ljust(-(-len(data) // 4) * 4, b"\0")
        return len(self.json["bufferViews"]) - 1

    def accessor(self, rows, format, bounds=False):
        width = len(rows[0]) if isinstance(rows[0], tuple) else 1
        flat = [x for row in rows for x in row] if width > 1 else rows
        kind = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}[width]
        accessor = {"bufferView": self.view(struct.pack(f"<{len(flat)}{format}", *flat)), "count": len(rows),
                    "componentType": {"f": 5126, "H": 5123}[format], "type": kind}
        if bounds:
            single = [struct.unpack("<f", struct.pack("<f", x))[0] for x in flat]
            accessor["min"] = [min(single[i::width]) for i in range(width)]
            accessor["max"] = [max(single[i::width]) for i in range(width)]
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def texture(self, width, height, pixel):
        rows = b"".join(b"\0" + bytes(min(255, max(0, round(c))) for x in range(width) for c in pixel(x, y))
                        for y in range(height))
        chunk = lambda kind, data: (struct.pack(">I", len(data)) + kind + data
                                    + struct.pack(">I", zlib.crc32(kind + data)))
        header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
        png = b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")
        self.json["images"].append({"bufferView": self.view(png), "mimeType": "image/png"})
        self.json["textures"].append({"source": len(self.json["images"]) - 1})
        return len(self.json["textures"]) - 1

    def material(self, name, color, roughness, metallic=0, texture=None, emission=None, **extensions):
        pbr = {"baseColorFactor": [*color, 1], "metallicFactor": metallic, "roughnessFactor": roughness}
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if emission:
            material["emissiveFactor"] = [c / max(emission) for c in emission]
            extensions["emissive_strength"] = {"emissiveStrength": max(emission)}
        if extensions:
            material["extensions"] = {f"KHR_materials_{name}": value for name, value in extensions.items()}
            used = self.json["extensionsUsed"]
            used += [e for e in material["extensions"] if e not in used]
        self.json["materials"].append(material)
        return len(self.json["materials"]) - 1

    def mesh(self, name, *parts):
        """Parts are (shape, material); a shape is a list of (position, normal, uv), and indices."""
        primitives = []
        for (vertices, indices), material in parts:
            positions, normals, uvs = zip(*vertices)
            attributes = {"POSITION": self.accessor(list(positions), "f", True), "NORMAL": self.accessor(list(normals), "f")}
            if "baseColorTexture" in self.json["materials"][material]["pbrMetallicRoughness"]:
                attributes["TEXCOORD_0"] = self.accessor(list(uvs), "f")
            primitives.append({"attributes": attributes, "indices": self.accessor(indices, "H"), "material": material})
        self.json["meshes"].append({"name": name, "primitives": primitives})
        return len(self.json["meshes"]) - 1

    def place(self, mesh, at=(0, 0, 0), turn=0.0, **fields):
        """Puts a mesh somewhere, turned about the vertical axis by degrees."""
        half = math.radians(turn) / 2
        node = {"mesh": mesh, "translation": list(at), "rotation": [0, math.sin(half), 0, math.cos(half)], **fields}
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def scatter(self, mesh, places):
        """Puts a mesh at many places (EXT_mesh_gpu_instancing): position, quaternion, scale of each."""
        ways = {"TRANSLATION": 0, "ROTATION": 1, "SCALE": 2}
        kinds = {3: "VEC3", 4: "VEC4"}
        attributes = {}
        for name, k in ways.items():
            rows = [place[k] for place in places]
            flat = [x for row in rows for x in row]
            view = self.view(struct.pack(f"<{len(flat)}f", *flat))
            self.json["accessors"].append({"bufferView": view, "count": len(rows), "componentType": 5126,
                                           "type": kinds[len(rows[0])]})
            attributes[name] = len(self.json["accessors"]) - 1
        extension = "EXT_mesh_gpu_instancing"
        if extension not in self.json["extensionsUsed"]:
            self.json["extensionsUsed"].append(extension)
        self.json["nodes"].append({"mesh": mesh, "extensions": {extension: {"attributes": attributes}}})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def camera(self, eye, target, yfov):
        back = unit([e - t for e, t in zip(eye, target)])
        right = unit(cross((0, 1, 0), back))
        up = cross(back, right)
        matrix = [*right, 0, *up, 0, *back, 0, *eye, 1]
        perspective = {"yfov": math.radians(yfov), "aspectRatio": 16 / 9, "znear": 0.05}
        self.json["cameras"].append({"name": "Camera", "type": "perspective", "perspective": perspective})
        self.json["nodes"].append({"name": "Camera", "camera": 0, "matrix": matrix})
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text = text.ljust(-(-len(text) // 4) * 4)
        total = 12 + 8 + len(text) + 8 + len(self.data)
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text
                         + struct.pack("<I4s", len(self.data), b"BIN\0") + self.data)


def unit(v):
    length = math.hypot(*v)
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def joined(*shapes):
    vertices, indices = [], []
    for more, triangles in shapes:
        indices += [i + len(vertices) for i in triangles]
        vertices += more
    return vertices, indices


def moved(shape, by):
    return [(tuple(a + b for a, b in zip(p, by)), n, uv) for p, n, uv in shape[0]], shape[1]


def quad(corner, u, v, scale=1.0):
    """A rectangle from a corner along two edges; its front is where their cross product points. Texture per metre."""
    n = unit(cross(u, v))
    at = lambda s, t: tuple(c + s * a + t * b for c, a, b in zip(corner, u, v))
    lu, lv = math.hypot(*u) / scale, math.hypot(*v) / scale
    return [(at(0, 0), n, (0.0, lv)), (at(1, 0), n, (lu, lv)), (at(1, 1), n, (lu, 0.0)), (at(0, 1), n, (0.0, 0.0))], \
        [0, 1, 2, 0, 2, 3]


def box(low, high, scale=1.0):
    (x, y, z), (a, b, c) = low, (h - l for l, h in zip(low, high))
    return joined(quad((x, y, z + c), (a, 0, 0), (0, b, 0), scale), quad((x + a, y, z), (-a, 0, 0), (0, b, 0), scale),
                  quad((x + a, y, z + c), (0, 0, -c), (0, b, 0), scale), quad((x, y, z), (0, 0, c), (0, b, 0), scale),
                  quad((x, y + b, z + c), (a, 0, 0), (0, 0, -c), scale), quad((x, y, z), (a, 0, 0), (0, 0, c), scale))


def sweep(rings):
    """Triangles between rings of equally many (position, normal); a ring is closed, and may be a point."""
    count = len(rings[0])
    vertices = [(p, n, (0.0, 0.0)) for ring in rings for p, n in ring]
    indices = []
    for i in range(len(rings) - 1):
        for k in range(count):
            a, b = i * count + k, i * count + (k + 1) % count
            for triangle in ((a, b + count, b), (a, a + count, b + count)):
                corners = [vertices[v][0] for v in triangle]
                if min(math.dist(corners[v], corners[v - 1]) for v in range(3)) > 1e-6:
                    indices += triangle
    return vertices, indices


def turned(profile, segments=28):
    """A surface of revolution about y through points (radius, height); where the direction turns sharply, an edge."""
    profile = [p for i, p in enumerate(profile) if i == 0 or math.dist(p, profile[i - 1]) > 1e-9]
    shapes, run = [], [profile[0]]
    slope = lambda a, b: unit((b[0] - a[0], b[1] - a[1]))
    for i in range(1, len(profile)):
        run.append(profile[i])
        last = i == len(profile) - 1
        if last or sum(x * y for x, y in zip(slope(*profile[i - 1:i + 1]), slope(*profile[i:i + 2]))) < 0.7:
            rings = []
            for j, (r, y) in enumerate(run):
                dr, dy = slope(run[max(j - 1, 0)], run[min(j + 1, len(run) - 1)])
                ring = []
                for k in range(segments):
                    s, c = math.sin(2 * math.pi * k / segments), math.cos(2 * math.pi * k / segments)
                    ring.append(((r * c, y, r * s), (dy * c, -dr, dy * s)))
                rings.append(ring)
            shapes.append(sweep(rings))
            run = [profile[i]]
    return joined(*shapes)


def arc(center, radius, start, stop, steps):
    """Points of a circle in a profile, degrees."""
    angles = [math.radians(start + (stop - start) * i / steps) for i in range(steps + 1)]
    return [(max(center[0] + radius * math.cos(a), 0.0), center[1] + radius * math.sin(a)) for a in angles]


def tube(points, radii, segments=10):
    """A tube along points of the plane z = 0."""
    rings = []
    for i, (p, r) in enumerate(zip(points, radii)):
        a, b = points[max(i - 1, 0)], points[min(i + 1, len(points) - 1)]
        dx, dy = unit((b[0] - a[0], b[1] - a[1]))
        ring = []
        for k in range(segments):
            s, c = math.sin(2 * math.pi * k / segments), math.cos(2 * math.pi * k / segments)
            n = (-dy * c, dx * c, s)
            ring.append(((p[0] + r * n[0], p[1] + r * n[1], r * n[2]), n))
        rings.append(ring)
    return sweep(rings)


def planks(size=192, rows=6):
    """Boards with grain, each of its own shade; the picture is 1.2 m wide and repeats."""
    rng = random.Random(4)
    shades = [[rng.uniform(0.72, 1.1) for _ in range(2)] for _ in range(rows)]
    ends = [rng.randrange(size) for _ in range(rows)]
    grain = [[rng.gauss(0, 0.045) for _ in range(size // rows)] for _ in range(rows * 2)]

    def pixel(x, y):
        row, inside = divmod(y * rows, size)
        row, inside = min(row, rows - 1), inside // rows
        board = 0 if (x - ends[row]) % size < size // 2 else 1
        seam = inside == 0 or (x - ends[row]) % (size // 2) == 0
        wave = 0.04 * math.sin(2 * math.pi * (2 * x / size + 0.35 * inside + 1.7 * row))
        shade = shades[row][board] * (1 + grain[2 * row + board][inside % (size // rows)] + wave) * (0.45 if seam else 1)
        shade = round(shade * 20) / 20
        return 168 * shade, 118 * shade, 76 * shade
    return size, size, pixel


def painting(size=48):
    """Hills under an evening sky."""
    def pixel(x, y):
        u, v = x / size, y / size
        for i, (height, color) in enumerate([(0.86, (38, 58, 62)), (0.72, (70, 98, 92)), (0.6, (126, 142, 122))]):
            if v > height - 0.07 * math.sin(6 * u * (1 + 0.3 * i) + 2.1 * i) - 0.03 * math.sin(17 * u + i):
                return color
        sun = math.hypot(u - 0.68, v - 0.36) < 0.1
        return (250, 226, 170) if sun else (236 - 40 * (0.6 - v), 168 + 60 * (0.6 - v), 120 + 160 * (0.6 - v))
    return size, size, pixel


def rotation(turn, lean):
    """Leans away from the vertical, then turns about it; radians, as a quaternion."""
    a, b = turn / 2, lean / 2
    return (math.cos(a) * math.sin(b), math.sin(a) * math.cos(b), -math.sin(a) * math.sin(b), math.cos(a) * math.cos(b))


def blade(length, width, bend, steps):
    """A leaf along y that bends towards z."""
    rows = []
    for i in range(steps + 1):
        t = i / steps
        half = width * math.sin(math.pi * (0.06 + 0.88 * (1 - t) ** 0.8)) * (1 - 0.15 * t)
        y, z = length * math.sin(bend * t) / bend, length * (1 - math.cos(bend * t)) / bend
        n = (0.0, math.sin(bend * t) * -1, math.cos(bend * t))
        rows.append([((side * half, y, z + 0.12 * half * abs(side)), n, (0.0, 0.0)) for side in (-1, 0, 1)])
    return [v for row in rows for v in row], [k + 3 * i for i in range(steps) for k in (0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4)]


def furnish(r, leaf, glaze, cream, rug, brass):
    """What is too fine for most caches: a fern, a palm, a bead curtain, a rug of tufts."""
    rng = random.Random(11)
    pot = turned([(0.0, 0.0), (0.13, 0.0), (0.17, 0.3), (0.185, 0.31), (0.18, 0.33), (0.165, 0.32), (0.15, 0.27), (0.0, 0.27)], 32)
    r.place(r.mesh("large pot", (pot, cream)), (1.75, 0, -0.95))
    frond = r.mesh("frond", (blade(0.5, 0.024, 1.1, 10), leaf))
    places = []
    for i in range(420):
        turn, up = 2.39996 * i, i / 420
        at = (1.75 + 0.1 * (1 - up) * math.sin(turn), 0.26 + 0.55 * up, -0.95 + 0.1 * (1 - up) * math.cos(turn))
        size = rng.uniform(0.55, 1.0)
        places.append((at, rotation(turn, rng.uniform(0.25, 1.5) * (1.1 - up)), (size, size, size)))
    r.scatter(frond, places)
    small = r.mesh("small leaf", (blade(0.075, 0.014, 0.8, 4), leaf))
    places = []
    for i in range(700):
        stem, t = i % 28, 0.25 + 0.75 * (i // 28) / 25
        turn, lean = 2.39996 * stem, 0.25 + 0.035 * stem
        out = 0.34 * t * math.sin(lean * (0.4 + t))
        at = (-1.95 + out * math.sin(turn) * 0.9 + 0.06, 1.02 + 0.34 * t * math.cos(lean * (0.4 + t)), -0.35 + out * math.cos(turn))
        places.append((at, rotation(turn + (1.4 if i % 2 else -1.4), rng.uniform(0.9, 1.6)), (1, 1, 1)))
    r.scatter(small, places)
    r.place(r.mesh("sill pot", (turned([(0.0, 0.0), (0.06, 0.0), (0.085, 0.16), (0.078, 0.16), (0.0, 0.14)], 28), glaze)), (-1.89, 0.852, -0.35))
    bead = r.mesh("bead", (turned(arc((0.0, 0.0), 0.011, -90, 90, 8), 12), brass))
    places = [((0.75 + 0.06 * c, 1.53 - 0.026 * k - 0.004 * (c % 3), -1.8), (0.0, 0.0, 0.0, 1.0), (1, 1, 1))
              for c in range(20) for k in range(6 + (c * 5) % 7)]
    r.scatter(bead, places)
    tuft = r.mesh("tuft", (blade(0.03, 0.004, 0.9, 2), rug))
    places = []
    for i in range(6000):
        at = (rng.uniform(-1.44, 0.84), 0.01, rng.uniform(-1.29, 0.44))
        size = rng.uniform(0.8, 1.3)
        places.append((at, rotation(rng.uniform(0, 2 * math.pi), rng.uniform(0, 0.6)), (2 * size, size, size)))
    r.scatter(tuft, places)


def main(full):
    r = Room()
    matte = {"specular": {"specularFactor": 0}}
    lacquer = r.material("floor", (1, 1, 1), 0.3, texture=r.texture(*planks()), ior={"ior": 1.7})
    wall = r.material("wall", (0.78, 0.74, 0.66), 1, **matte)
    accent = r.material("back wall", (0.3, 0.42, 0.42), 1, **matte)
    white = r.material("ceiling", (0.82, 0.82, 0.8), 1, **matte)
    rug = r.material("rug", (0.5, 0.2, 0.16), 1, **matte)
    paint = r.material("white paint", (0.78, 0.78, 0.75), 0.45)
    oak = r.material("oak", (0.46, 0.29, 0.16), 0.45)
    chair = r.material("chair", (0.12, 0.2, 0.24), 0.45)
    copper = r.material("copper", (0.93, 0.58, 0.42), 0.3, metallic=1)
    steel = r.material("steel", (0.66, 0.66, 0.68), 0.3, metallic=1)
    brass = r.material("brass", (0.86, 0.68, 0.36), 0.45, metallic=1)
    chrome = r.material("chrome", (0.75, 0.76, 0.78), 0.08, metallic=1)
    glaze = r.material("glaze", (0.16, 0.34, 0.5), 0.25)
    cream = r.material("cream glaze", (0.75, 0.68, 0.54), 0.25)
    fruit = r.material("fruit", (0.85, 0.34, 0.06), 0.45)
    leaf = r.material("leaf", (0.1, 0.25, 0.07), 0.45)
    picture = r.material("picture", (1, 1, 1), 1, texture=r.texture(*painting()), **matte)
    bulb = r.material("bulb", (0, 0, 0), 1, emission=(51, 36, 21), **matte)
    day = r.material("daylight", (0, 0, 0), 1, emission=(8.3, 9.6, 11), **matte)

    # The shell: x from -2.2 to 2.2, z from -2 to 2.4, 2.6 high; a window in the left wall.
    x0, x1, y1, z0, z1 = -2.2, 2.2, 2.6, -2.0, 2.4
    w0, w1, wy0, wy1, deep = -1.25, 0.55, 0.85, 2.15, 0.18
    r.place(r.mesh("floor", (quad((x0, 0, z1), (x1 - x0, 0, 0), (0, 0, z0 - z1), 1.2), lacquer)))
    r.place(r.mesh("ceiling", (quad((x0, y1, z0), (x1 - x0, 0, 0), (0, 0, z1 - z0)), white)))
    left = joined(quad((x0, 0, z1), (0, 0, w1 - z1), (0, y1, 0)), quad((x0, 0, w0), (0, 0, z0 - w0), (0, y1, 0)),
                  quad((x0, 0, w1), (0, 0, w0 - w1), (0, wy0, 0)), quad((x0, wy1, w1), (0, 0, w0 - w1), (0, y1 - wy1, 0)))
    reveal = joined(quad((x0 - deep, wy0, w1), (deep, 0, 0), (0, 0, w0 - w1)), quad((x0, wy1, w1), (-deep, 0, 0), (0, 0, w0 - w1)),
                    quad((x0 - deep, wy0, w0), (deep, 0, 0), (0, wy1 - wy0, 0)), quad((x0, wy0, w1), (-deep, 0, 0), (0, wy1 - wy0, 0)))
    right = quad((x1, 0, z0), (0, 0, z1 - z0), (0, y1, 0))
    front = quad((x1, 0, z1), (x0 - x1, 0, 0), (0, y1, 0))
    back = quad((x0, 0, z0), (x1 - x0, 0, 0), (0, y1, 0))
    r.place(r.mesh("walls", (joined(left, reveal, right, front), wall), (back, accent)))
    skirting = joined(box((x0, 0, z0), (x1, 0.09, z0 + 0.015)), box((x0, 0, z0), (x0 + 0.015, 0.09, z1)),
                      box((x1 - 0.015, 0, z0), (x1, 0.09, z1)))
    xw, zm, ym = x0 - deep + 0.05, (w0 + w1) / 2, wy0 + 0.42 * (wy1 - wy0)
    bars = [box((xw - 0.03, wy0, z - 0.03), (xw + 0.03, wy1, z + 0.03)) for z in (w0 + 0.03, zm, w1 - 0.03)]
    bars += [box((xw - 0.03, y - 0.03, w0), (xw + 0.03, y + 0.03, w1)) for y in (wy0 + 0.03, ym, wy1 - 0.03)]
    sill = box((x0 - deep, wy0 - 0.04, w0 - 0.08), (x0 + 0.1, wy0 + 0.002, w1 + 0.08))
    r.place(r.mesh("woodwork", (joined(skirting, *bars, sill), paint)))
    r.place(r.mesh("window", (quad((x0 - deep - 0.02, wy0 - 0.1, w1 + 0.1), (0, 0, w0 - w1 - 0.2), (0, wy1 - wy0 + 0.2, 0)), day)))
    r.place(r.mesh("rug", (box((-1.45, 0, -1.3), (0.85, 0.012, 0.45)), rug)))

    # Table and chairs.
    legs = [turned([(0.0, 0.0), (0.022, 0.0), (0.034, 0.35), (0.038, 0.7)], 14)] * 4
    legs = [moved(leg, (x, 0, z)) for leg, (x, z) in zip(legs, [(-0.68, -0.36), (0.68, -0.36), (-0.68, 0.36), (0.68, 0.36)])]
    top = joined(box((-0.78, 0.71, -0.45), (0.78, 0.75, 0.45)), box((-0.7, 0.63, -0.37), (0.7, 0.71, 0.37)))
    table = (-0.35, 0, -0.45)
    r.place(r.mesh("table", (joined(top, *legs), oak)), table)
    parts = [box((-0.2, 0.43, -0.2), (0.2, 0.465, 0.2))]
    parts += [box((x - 0.017, 0, z - 0.017), (x + 0.017, 0.43, z + 0.017)) for x in (-0.18, 0.18) for z in (-0.18, 0.18)]
    parts += [box((x - 0.017, 0.465, 0.163), (x + 0.017, 0.86, 0.197)) for x in (-0.18, 0.18)]
    parts += [box((-0.165, y, 0.17), (0.165, y + 0.09, 0.19)) for y in (0.58, 0.75)]
    seat = r.mesh("chair", (joined(*parts), chair))
    for at, turn in [((-0.72, 0, 0.16), 4), ((0.05, 0, 0.22), -14), ((0.68, 0, -0.5), 88), ((-0.6, 0, -1.1), 184)]:
        r.place(seat, at, turn)

    # On the table: a kettle, a bowl of fruit, two cups.
    body = [(0.0, 0.0)] + [(0.088, 0.0)] + arc((0.0, 0.075), 0.105, -38, 62, 10) + [(0.046, 0.172), (0.05, 0.176)]
    lid = [(0.05, 0.176), (0.036, 0.19), (0.0, 0.197)]
    knob = moved(turned([(0.0, 0.0), (0.008, 0.0), (0.008, 0.012)] + arc((0.0, 0.024), 0.016, -45, 90, 6), 14), (0, 0.195, 0))
    spout = tube([(0.085, 0.06), (0.13, 0.085), (0.155, 0.125), (0.185, 0.165)], [0.022, 0.018, 0.013, 0.011])
    handle = tube([(0.078 * math.cos(a), 0.17 + 0.1 * math.sin(a)) for a in [math.pi * i / 14 for i in range(15)]], [0.008] * 15)
    r.place(r.mesh("kettle", (joined(turned(body + lid), spout), copper), (joined(handle, knob), brass)), (-0.62, 0.75, -0.5), 35)
    bowl = [(0.0, 0.0), (0.055, 0.0), (0.055, 0.012)] + arc((0.0, 0.135), 0.135, -68, -18, 8) + arc((0.0, 0.135), 0.127, -18, -90, 9)
    r.place(r.mesh("bowl", (turned(bowl, 32), glaze)), (-0.2, 0.75, -0.42))
    ball = r.mesh("orange", (turned(arc((0.0, 0.0), 0.038, -90, 90, 12), 20), fruit))
    for at in [(-0.24, 0.81, -0.42), (-0.165, 0.812, -0.45), (-0.19, 0.81, -0.375), (-0.2, 0.862, -0.42)]:
        r.place(ball, at)
    cup = turned([(0.0, 0.0), (0.026, 0.0), (0.038, 0.03), (0.04, 0.075), (0.037, 0.075), (0.034, 0.03), (0.0, 0.012)], 22)
    ear = tube([(0.036 + 0.022 * math.sin(a), 0.042 + 0.02 * math.cos(a)) for a in [math.pi * i / 8 for i in range(9)]], [0.0045] * 9, 8)
    cups = r.mesh("cup", (joined(cup, ear), cream))
    r.place(cups, (0.12, 0.75, -0.27), -50)
    r.place(cups, (0.22, 0.75, -0.62), 110)

    # The lamp over the table.
    shade = [(0.035, 0.2), (0.05, 0.19), (0.11, 0.12), (0.19, 0.0), (0.186, 0.002), (0.105, 0.118), (0.045, 0.186)]
    cord = moved(turned([(0.004, 0.0), (0.004, y1 - 1.7)], 8), (0, 0.2, 0))
    light = moved(turned(arc((0.0, 0.0), 0.045, -90, 90, 12), 20), (0, 0.075, 0))
    r.place(r.mesh("lamp", (joined(turned(shade, 36), cord), brass), (light, bulb)), (-0.35, 1.5, -0.45))

    # The sideboard with pots, a plant and a faucet; a shelf and a picture above.
    board = joined(box((0.35, 0.1, -2.0), (2.0, 0.84, -1.55)), box((0.31, 0.84, -2.0), (2.04, 0.87, -1.52)))
    doors = [box((x + 0.012, 0.14, -1.55), (x + 0.53, 0.81, -1.535)) for x in (0.37, 0.91, 1.45)]
    pulls = [moved(turned([(0.012, 0.0), (0.012, 0.16)], 10), (x, 0.42, -1.52)) for x in (0.84, 1.0, 1.54)]
    r.place(r.mesh("sideboard", (joined(board, *doors), paint), (joined(*pulls), brass)))
    pot = [(0.0, 0.0), (0.108, 0.0), (0.115, 0.01), (0.115, 0.14), (0.119, 0.143), (0.112, 0.143), (0.0, 0.165)]
    grip = [(-0.03, 0.0), (-0.03, 0.03), (0.0, 0.036), (0.03, 0.03), (0.03, 0.0)]
    ears = [moved(tube([(a, 0.1 + b) for b, a in [(g[0], s * (0.112 + g[1])) for g in grip]], [0.007] * 5, 8), (0, 0, 0)) for s in (-1, 1)]
    top = moved(tube([(g[0], g[1] * 0.8) for g in grip], [0.006] * 5, 8), (0, 0.158, 0))
    r.place(r.mesh("pot", (joined(turned(pot, 36), *ears, top), steel)), (1.02, 0.87, -1.76), 25)
    r.place(len(r.json["meshes"]) - 1, (1.36, 0.87, -1.8), -20, scale=[0.74, 0.8, 0.74])
    tap = [(0.0, 0.0), (0.0, 0.2)] + [(0.07 - 0.07 * math.cos(a), 0.2 + 0.07 * math.sin(a)) for a in [math.pi * i / 10 for i in range(1, 11)]] + [(0.14, 0.17)]
    foot = turned([(0.0, 0.0), (0.03, 0.0), (0.03, 0.012), (0.014, 0.02)], 18)
    r.place(r.mesh("faucet", (joined(tube(tap, [0.011] * len(tap)), foot), chrome)), (1.76, 0.87, -1.8), -60)
    vase = [(0.0, 0.0), (0.05, 0.0)] + [(0.05 + 0.035 * math.sin(math.pi * t), 0.2 * t) for t in [i / 12 for i in range(1, 13)]]
    rng = random.Random(2)
    leaves = []
    for i in range(26):
        turn, lean, long = 2.4 * i, rng.uniform(0.15, 0.9), rng.uniform(0.16, 0.3)
        c, s = math.cos(turn), math.sin(turn)
        at = lambda d, side, c=c, s=s, lean=lean, long=long: (
            long * d * math.sin(lean * (0.6 + d)) * c - side * s * 0.028 * math.sin(math.pi * (0.08 + 0.9 * d)),
            0.19 + long * d * math.cos(lean * (0.6 + d)),
            long * d * math.sin(lean * (0.6 + d)) * s + side * c * 0.028 * math.sin(math.pi * (0.08 + 0.9 * d)))
        rows = [[at(d / 4, side) for side in (-1, 1)] for d in range(5)]
        n = unit((-c * math.cos(lean), math.sin(lean), -s * math.cos(lean)))
        leaves.append(([(p, n, (0.0, 0.0)) for row in rows for p in row],
                       [i for d in range(4) for i in (2 * d, 2 * d + 1, 2 * d + 3, 2 * d, 2 * d + 3, 2 * d + 2)]))
    r.place(r.mesh("plant", (turned(vase, 24), glaze), (joined(*leaves), leaf)), (0.58, 0.87, -1.78))
    r.place(r.mesh("shelf", (box((0.75, 1.55, -2.0), (2.0, 1.58, -1.78)), oak)))
    jar = [(0.0, 0.0), (0.05, 0.0), (0.055, 0.02), (0.055, 0.12), (0.04, 0.14), (0.042, 0.145), (0.042, 0.17), (0.0, 0.175)]
    jars = [r.mesh(f"jar {i}", (turned(jar, 24), material)) for i, material in enumerate((cream, glaze, copper))]
    for i, x in enumerate((0.92, 1.08, 1.24, 1.42, 1.74)):
        r.place(jars[(i * 2) % 3], (x, 1.58, -1.89), scale=[1, 1.25 - 0.18 * (i % 3), 1])
    frame = [box((-1.35, y, -2.0), (-0.15, y + 0.035, -1.97)) for y in (1.1, 1.865)]
    frame += [box((x, 1.1, -2.0), (x + 0.035, 1.9, -1.97)) for x in (-1.35, -0.185)]
    canvas = quad((-1.32, 1.13, -1.985), (1.14, 0, 0), (0, 0.74, 0))
    corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]
    canvas = [(p, n, uv) for (p, n, _), uv in zip(canvas[0], corners)], canvas[1]
    r.place(r.mesh("painting", (joined(*frame), oak), (canvas, picture)))

    if full:
        furnish(r, leaf, glaze, cream, rug, brass)
    r.camera((1.62, 1.42, 2.2), (-0.3, 0.72, -0.62), 44)
    r.write(HERE / ("room-full.glb" if full else "room.glb"))


if __name__ == "__main__":
    main(False)
    main(True)
