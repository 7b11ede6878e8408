#!/usr/bin/env python3
"""Compares our irradiance cache with Radiance's (rpict with an ambient cache) on the diffuse Cornell box, 256 × 256.

Usage: radiance_ambient.py RENDER [SPP], RENDER the path of the render program, SPP samples per pixel of the converged
picture [2048], which our path tracer draws.

Both get the geometry of tests/scenes/cornell, the same colours and light, and as many bounces. Radiance runs at several
accuracies; for each of its errors the least time in which `render image --method irradiance --time T` comes to it is
sought. Seconds are user time of the whole processes, on one thread each, loading and writing included.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile

try:
    import pyradiance
except ImportError as missing:
    print(f"skipped: {missing} (pip install pyradiance)")
    sys.exit(0)

TOOLS = os.path.join(os.path.dirname(pyradiance.__file__), "bin")
LIBRARY = os.path.join(os.path.dirname(pyradiance.__file__), "lib")
CORNELL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes", "cornell")
SIZE = 256
DEPTH = 8  # path segments: direct light and six bounces
WHITE, RED, GREEN = (0.73, 0.71, 0.68), (0.58, 0.06, 0.05), (0.12, 0.42, 0.11)
LAMP = (18.0, 12.0, 6.0)
PARTS = {"floor": WHITE, "ceiling": WHITE, "back": WHITE, "left": RED, "right": GREEN, "short": WHITE, "tall": WHITE}
EYE, LOOK, FOV = (2.78, 2.73, -8.0), (2.78, 2.73, 0.0), 39.3077
# Samples along a pixel's edge; divisions, supersamples, accuracy, resolution of the ambient cache: from fast to exact.
RADIANCE = [(2, 256, 64, 0.25, 32), (2, 512, 128, 0.2, 64), (4, 512, 128, 0.2, 64)]
# Budgets of ours, wall-clock seconds on one thread.
TIMES = [0.5, 1, 2, 4, 8, 16, 32]
TARGET = 10.0


def polygons(name):
    """Faces of an OBJ file in our units."""
    vertices = []
    with open(os.path.join(CORNELL, f"{name}.obj")) as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([0.01 * float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                yield [vertices[int(w.split("/")[0]) - 1] for w in words[1:]]


def our_scene():
    rgb = lambda color: ", ".join(map(str, color))  # noqa: E731
    shape = ('<shape type="obj"><string name="filename" value="{}"/><boolean name="face_normals" value="true"/>'
             '<transform name="to_world"><scale value="0.01"/></transform>{}</shape>')
    bsdf = '<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="{}"/></bsdf></bsdf>'
    path = lambda name: os.path.abspath(os.path.join(CORNELL, f"{name}.obj"))  # noqa: E731
    shapes = [shape.format(path(name), bsdf.format(rgb(color))) for name, color in PARTS.items()]
    lamp = f'<emitter type="area"><rgb name="radiance" value="{rgb(LAMP)}"/></emitter>' + bsdf.format(0)
    shapes.append(shape.format(path("light"), lamp))
    eye, look = rgb(EYE), rgb(LOOK)
    return f"""<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="{DEPTH}"/></integrator>
    <sensor type="perspective"><float name="fov" value="{FOV}"/>
        <transform name="to_world"><lookat origin="{eye}" target="{look}" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
        <rfilter type="box"/></film></sensor>
    {"".join(shapes)}</scene>"""


def radiance_scene():
    lines = ["void light lamp 0 0 3 {} {} {}".format(*LAMP)]
    for name, color in [*PARTS.items(), ("light", None)]:
        if color:
            lines.append("void plastic m_{} 0 0 5 {} {} {} 0 0".format(name, *color))
        for i, face in enumerate(polygons(name)):
            numbers = " ".join(f"{x:.9g}" for vertex in face for x in vertex)
            lines.append(f"{f'm_{name}' if color else 'lamp'} polygon {name}{i} 0 0 {3 * len(face)} {numbers}")
    return "\n".join(lines) + "\n"


def run(command, **keywords):
    done = subprocess.run(command, check=False, capture_output=True, **keywords)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stderr.decode(errors='replace').strip()}")
    return done.stdout


def radiance(folder, settings, environment):
    """Renders larger, averaged down as a box filter does; returns the picture and the user seconds of rpict."""
    finer, divisions, supersamples, accuracy, resolution = settings
    tool = lambda name: os.path.join(TOOLS, name)  # noqa: E731
    view = ["-vtv", "-vp", *map(str, EYE), "-vd", *(str(b - a) for a, b in zip(EYE, LOOK)), "-vu", "0", "1", "0",
            "-vh", str(FOV), "-vv", str(FOV)]
    size = ["-x", str(finer * SIZE), "-y", str(finer * SIZE)]
    direct = ["-ps", "1", "-pt", "0", "-pj", "0.9", "-dj", "0.9", "-ds", "0.05", "-dt", "0", "-dc", "1", "-lr", "8", "-lw", "0"]
    ambient = ["-ab", str(DEPTH - 2), "-ad", str(divisions), "-as", str(supersamples), "-aa", str(accuracy),
               "-ar", str(resolution), "-aw", "0"]
    octree, cache = os.path.join(folder, "box.oct"), os.path.join(folder, f"{finer}-{divisions}.amb")
    before = user_seconds()
    # A coarse picture fills the cache, so that the one that counts does not see it growing.
    run([tool("rpict"), *view, "-x", "64", "-y", "64", "-af", cache, *direct, *ambient, octree], env=environment)
    large = run([tool("rpict"), *view, *size, "-af", cache, *direct, *ambient, octree], env=environment)
    seconds = user_seconds() - before
    path = os.path.join(folder, f"{finer}-{divisions}.hdr")
    with open(path, "wb") as file:
        file.write(run([tool("pfilt"), "-1", "-e", "1", "-x", f"/{finer}", "-y", f"/{finer}"], input=large, env=environment))
    return path, seconds


def rel_mse(program, image, truth):
    return json.loads(run([program, "compare", image, truth, "--json"]))["rel_mse"]


def user_seconds():
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def ours(program, folder, scene, truth, time):
    image, before = os.path.join(folder, "ours.exr"), user_seconds()
    run([program, "image", scene, "--method", "irradiance", "--time", str(time), "--threads", "1", "-o", image])
    return user_seconds() - before, rel_mse(program, image, truth)


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    program = os.path.abspath(sys.argv[1])
    spp = sys.argv[2] if len(sys.argv) > 2 else "2048"
    environment = dict(os.environ, RAYPATH=f"{LIBRARY}:.", PATH=f"{TOOLS}:{os.environ.get('PATH', '')}")
    with tempfile.TemporaryDirectory() as folder:
        scene, truth = os.path.join(folder, "box.xml"), os.path.join(folder, "truth.exr")
        with open(scene, "w") as file:
            file.write(our_scene())
        with open(os.path.join(folder, "box.rad"), "w") as file:
            file.write(radiance_scene())
        with open(os.path.join(folder, "box.oct"), "wb") as file:
            file.write(run([os.path.join(TOOLS, "oconv"), os.path.join(folder, "box.rad")], env=environment))
        run([program, "image", scene, "--spp", spp, "--seed", "9", "-o", truth])
        curve = [ours(program, folder, scene, truth, t) for t in TIMES]
        for seconds, error in curve:
            print(f"ours: {seconds:.2f} s, rel_mse {error:.5f}")
        print("\n| Radiance: samples along an edge, -ad -as -aa -ar | user seconds | rel_mse | ours to that error, seconds | faster |\n|---|---|---|---|---|")
        ratios = []
        for settings in RADIANCE:
            image, seconds = radiance(folder, settings, environment)
            error = rel_mse(program, image, truth)
            reached = [s for s, e in curve if e <= error]
            ratio = seconds / min(reached) if reached else 0.0
            ratios.append((error, ratio))
            print(f"| {' '.join(map(str, settings))} | {seconds:.1f} | {error:.5f} | "
                  f"{f'{min(reached):.2f}' if reached else 'not reached'} | {ratio:.0f}× |")
        best = min(ratios)[1]
        print(f"\nat the least error of Radiance ours is {best:.0f} times faster (target {TARGET:.0f})")
        sys.exit(0 if best >= TARGET else 1)


main()
