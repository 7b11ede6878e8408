#!/usr/bin/env python3
"""Table 2 of "Radiance Cache Splatting" (2005) again: the first bounce of diffuse light in the Sponza atrium, ours against Radiance.

Usage: radiance_sponza.py RENDER SPONZA.xml [--size N] [--spp N] [--accuracies A,B] [--taus T,T] [--samples N,N,...] [--keep FOLDER]

RENDER is the render program, SPONZA.xml a Mitsuba scene of diffuse shapes from one .serialized file, with one spherical lamp.
Both renderers get its triangles with flat faces, the mean colour of every texture, the lamp and the camera, at N × N
pixels [1000]. Radiance (rpict) runs with 64² rays for each record and the accuracies asked for [0.2,0.1]; the truth are two pictures
of our path tracer with so many samples per pixel each [64], of the same converted scene: an error is the mean over pixels of
(a − r₁)(a − r₂)/(r² + 0.01), r the mean of both, which their noise does not add to. For the error of each run of Radiance the least
time in which `render image --method irradiance --tau T --spp N` comes to it is sought. Seconds are user time of the whole
processes, one thread each, loading and writing included. What Radiance took minutes for stays in the folder to keep, and is not made again.
"""

import argparse
import itertools
import json
import os
import resource
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

try:
    import mitsuba
    import numpy
    import pyradiance
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing} (pip install pyradiance mitsuba==3.9.1 numpy pillow)")
    sys.exit(0)

TOOLS = os.path.join(os.path.dirname(pyradiance.__file__), "bin")
LIBRARY = os.path.join(os.path.dirname(pyradiance.__file__), "lib")
RAYS = 64 * 64
DEPTH = 3  # path segments: direct light and one bounce
FINER = 2  # samples along the edge of a pixel
TARGET = 40.0


def numbers(text):
    return [float(x) for x in text.replace(",", " ").split()]


def mean_color(path):
    """Mean linear colour of a picture in sRGB."""
    x = numpy.asarray(Image.open(path).convert("RGB"), dtype=float) / 255
    linear = numpy.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    return linear.reshape(-1, 3).mean(axis=0).tolist()


def read(path):
    """Triangles of each shape (n × 3 × 3) with its colour, the lamp (centre, radius, radiance), and the camera."""
    mitsuba.set_variant("scalar_rgb")
    folder, root = os.path.dirname(os.path.abspath(path)), ElementTree.parse(path).getroot()
    textures = {t.get("id"): mean_color(os.path.join(folder, t.find("string[@name='filename']").get("value")))
                for t in root.findall("texture")}
    colors = {}
    for bsdf in root.findall("bsdf"):
        rgb, texture = bsdf.find("rgb"), bsdf.find("ref")
        colors[bsdf.get("id")] = numbers(rgb.get("value")) if rgb is not None else textures[texture.get("id")]
    shapes, lamp = [], None
    for shape in root.findall("shape"):
        if shape.get("type") == "sphere":
            center = shape.find("point")
            radiance = numbers(shape.find("emitter/rgb").get("value"))
            lamp = [float(center.get(k)) for k in "xyz"], float(shape.find("float").get("value")), (radiance * 3)[:3]
            continue
        matrix = shape.find("transform/matrix")
        matrix = numpy.array(numbers(matrix.get("value"))).reshape(4, 4) if matrix is not None else numpy.eye(4)
        mesh = mitsuba.load_dict({
            "type": "serialized", "filename": os.path.join(folder, shape.find("string").get("value")),
            "shape_index": int(shape.find("integer").get("value")), "face_normals": True})
        parameters = mitsuba.traverse(mesh)
        vertices = numpy.array(parameters["vertex_positions"]).reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        triangles = vertices[numpy.array(parameters["faces"]).reshape(-1, 3)]
        area = numpy.linalg.norm(numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
        shapes.append((triangles[area > 1e-10], colors[shape.find("ref").get("id")]))
    sensor = root.find("sensor")
    look = sensor.find("transform/lookat")
    camera = {key: numbers(look.get(key)) for key in ("origin", "target", "up")}
    camera["fov"] = float(sensor.find("float[@name='fov']").get("value"))
    return shapes, lamp, camera


def our_scene(folder, shapes, lamp, camera, size):
    rgb = lambda color: ", ".join(map(str, color))  # noqa: E731
    parts = []
    for i, (triangles, color) in enumerate(shapes):
        path = os.path.join(folder, f"shape{i}.ply")
        with open(path, "wb") as file:
            file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
                       b"property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"
                       % (3 * len(triangles), len(triangles)))
            file.write(triangles.astype("<f4").tobytes())
            faces = numpy.zeros(len(triangles), dtype=[("n", "u1"), ("i", "<i4", 3)])
            faces["n"], faces["i"] = 3, numpy.arange(3 * len(triangles)).reshape(-1, 3)
            file.write(faces.tobytes())
        parts.append(f'<shape type="ply"><string name="filename" value="{path}"/><boolean name="face_normals" value="true"/>'
                     f'<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="{rgb(color)}"/></bsdf></bsdf>'
                     "</shape>")
    (x, y, z), radius, radiance = lamp
    return f"""<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="{DEPTH}"/></integrator>
    <sensor type="perspective"><float name="fov" value="{camera['fov']}"/>
        <transform name="to_world"><lookat origin="{rgb(camera['origin'])}" target="{rgb(camera['target'])}"
            up="{rgb(camera['up'])}"/></transform>
        <film type="hdrfilm"><integer name="width" value="{size}"/><integer name="height" value="{size}"/>
        <rfilter type="box"/></film></sensor>
    <shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="{radius}"/>
        <emitter type="area"><rgb name="radiance" value="{rgb(radiance)}"/></emitter></shape>
    {"".join(parts)}</scene>"""


def radiance_scene(shapes, lamp):
    center, radius, radiance = lamp
    yield "void light lamp 0 0 3 {} {} {}\n".format(*radiance)
    yield "lamp sphere bulb 0 0 4 {} {} {} {}\n".format(*center, radius)
    for i, (triangles, color) in enumerate(shapes):
        yield "void plastic m{} 0 0 5 {} {} {} 0 0\n".format(i, *color)
        for k, triangle in enumerate(triangles.reshape(-1, 9)):
            yield f"m{i} polygon p{i}_{k} 0 0 9 {' '.join(f'{x:.9g}' for x in triangle)}\n"


def run(command, **keywords):
    done = subprocess.run(command, check=False, capture_output=True, **keywords)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stderr.decode(errors='replace').strip()}")
    return done.stdout


def user_seconds():
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def radiance(folder, camera, size, accuracy, environment):
    """A picture with an ambient cache, FINER² samples for each pixel; its path and the user seconds of rpict."""
    tool = lambda name: os.path.join(TOOLS, name)  # noqa: E731
    direction = [b - a for a, b in zip(camera["origin"], camera["target"])]
    fov = str(camera["fov"])
    view = ["-vtv", "-vp", *map(str, camera["origin"]), "-vd", *map(str, direction), "-vu", *map(str, camera["up"]),
            "-vh", fov, "-vv", fov]
    direct = ["-ps", "1", "-pt", "0", "-pj", "0.9", "-dj", "0.9", "-ds", "0", "-dt", "0", "-dc", "1", "-lr", "4", "-lw", "0"]
    ambient = ["-ab", str(DEPTH - 2), "-ad", str(RAYS), "-as", "0", "-aa", str(accuracy), "-ar", "256", "-aw", "0"]
    octree, cache = os.path.join(folder, "scene.oct"), os.path.join(folder, f"{accuracy}.amb")
    before = user_seconds()
    # A coarse picture fills the cache, so that the one that counts does not see it growing.
    run([tool("rpict"), *view, "-x", str(size // 4), "-y", str(size // 4), "-af", cache, *direct, *ambient, octree], env=environment)
    pixels = ["-x", str(FINER * size), "-y", str(FINER * size)]
    large = run([tool("rpict"), *view, *pixels, "-af", cache, *direct, *ambient, octree], env=environment)
    seconds = user_seconds() - before
    path = os.path.join(folder, f"{accuracy}.hdr")
    with open(path, "wb") as file:
        file.write(run([tool("pfilt"), "-1", "-e", "1", "-x", f"/{FINER}", "-y", f"/{FINER}"], input=large, env=environment))
    return path, seconds


def pixels_of(path):
    bitmap = dict(mitsuba.Bitmap(path).split())["<root>"]
    return numpy.array(bitmap.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, srgb_gamma=False), dtype=float)


def errors(image, truths):
    """Relative mean square error and bias against two independent truths."""
    a, (first, second) = pixels_of(image), truths
    mean = (first + second) / 2
    return ((a - first) * (a - second) / (mean**2 + 0.01)).mean(), a.mean() / mean.mean() - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("render")
    parser.add_argument("scene")
    parser.add_argument("--size", type=int, default=1000)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--accuracies", type=lambda s: [float(x) for x in s.split(",")], default=[0.2, 0.1])
    parser.add_argument("--taus", type=lambda s: s.split(","), default=["0.2", "0.1"])
    parser.add_argument("--samples", type=lambda s: s.split(","), default=["3", "4", "5", "6", "8", "10"])
    parser.add_argument("--keep")
    args = parser.parse_args()
    if not os.path.exists(args.scene):
        print(f"skipped: no {args.scene}")
        return 0
    program = os.path.abspath(args.render)
    environment = dict(os.environ, RAYPATH=f"{LIBRARY}:.", PATH=f"{TOOLS}:{os.environ.get('PATH', '')}")
    shapes, lamp, camera = read(args.scene)
    print(f"{sum(len(triangles) for triangles, _ in shapes)} triangles")
    with tempfile.TemporaryDirectory() as folder:
        folder = args.keep or folder
        scene, taken = os.path.join(folder, "scene.xml"), os.path.join(folder, "radiance.json")
        with open(scene, "w") as file:
            file.write(our_scene(folder, shapes, lamp, camera, args.size))
        with open(os.path.join(folder, "scene.rad"), "w") as file:
            file.writelines(radiance_scene(shapes, lamp))
        with open(os.path.join(folder, "scene.oct"), "wb") as file:
            file.write(run([os.path.join(TOOLS, "oconv"), os.path.join(folder, "scene.rad")], env=environment))
        truths = [os.path.join(folder, f"truth{seed}.exr") for seed in (9, 10)]
        for seed, truth in enumerate(truths, 9):
            if not os.path.exists(truth):
                run([program, "image", scene, "--spp", str(args.spp), "--seed", str(seed), "--denoise", "off", "-o", truth])
        truths = [pixels_of(truth) for truth in truths]
        curve = []
        for tau, samples in itertools.product(args.taus, args.samples):
            image, before = os.path.join(folder, "ours.exr"), user_seconds()
            run([program, "image", scene, "--method", "irradiance", "--tau", tau, "--spp", samples, "--denoise", "off", "--threads", "1",
                 "--layers", "none", "-o", image])
            curve.append((user_seconds() - before, *errors(image, truths)))
            print("ours, τ = {}, {} spp: {:.2f} s, rel_mse {:.5f}, bias {:+.4f}".format(tau, samples, *curve[-1]), flush=True)
        print("| Radiance, -aa | user seconds | rel_mse | bias | ours to that error, seconds | faster |\n|---|---|---|---|---|---|")
        ratios, known = [], {}
        if os.path.exists(taken):
            with open(taken) as file:
                known = json.load(file)
        for accuracy in args.accuracies:
            if str(accuracy) not in known:
                known[str(accuracy)] = radiance(folder, camera, args.size, accuracy, environment)
                with open(taken, "w") as file:
                    json.dump(known, file)
            image, seconds = known[str(accuracy)]
            error, bias = errors(image, truths)
            reached = [s for s, e, _ in curve if e <= error]
            ratios.append(seconds / min(reached) if reached else 0.0)
            shown = f"{min(reached):.2f}" if reached else "not reached"
            print(f"| {accuracy} | {seconds:.1f} | {error:.5f} | {bias:.4f} | {shown} | {ratios[-1]:.0f}× |", flush=True)
    return 0 if max(ratios) >= TARGET else 1


sys.exit(main())
