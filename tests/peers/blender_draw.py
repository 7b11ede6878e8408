"""The script `render/blender/draw.py` beside Cycles: scenes with worlds, area lamps, point lamps with a radius, depth of field, a
second camera, exposure and view, built here, saved as files of Blender and drawn by both.

Right is: the mean of every channel of the linear picture within 2 %, the root mean square over blocks of 8 × 8 pixels within 5 %
of the mean; the mean level of the PNG within 2 of 255 of Blender's own. Fails where one is not.

  pip install bpy==4.5.* numpy OpenEXR pillow        (in the Python that bpy was built for)
  python tests/peers/blender_draw.py target/release/render [--keep FOLDER] [NAME …]
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
from math import radians

try:
    import bpy
    import numpy as np
    import OpenEXR  # noqa: F401
    from PIL import Image
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from blender_scenes.kit import ball, cube, glow, lamp, link, look, material, nodes, place, plane, stage, sun, world  # noqa: E402
from blender_scenes.measure import Quiet, blocks, cycles, read  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "render" / "blender" / "draw.py"
MEAN, BLOCKS, LEVELS = 0.02, 0.05, 2.0
SAMPLES = 384


def shown():
    """A floor with a box and a ball, without light."""
    stage(lights=False, wall=False)
    cube(material(Base_Color=(0.8, 0.35, 0.1), Roughness=0.6), size=1.2, at=(-0.6, 0, 0.6), turn=(0, 0, 30))
    ball(material(Base_Color=(0.2, 0.5, 0.8), Roughness=0.4), at=(1.0, 0.3, 0.6), radius=0.6)


def areas():
    """Every shape of area lamps, one scaled by its object."""
    shown()
    lamp("AREA", 90, at=(1, -1, 3), turn=(20, 20, 0), shape="RECTANGLE", size=1.0, size_y=0.4)
    lamp("AREA", 60, at=(-2, -1, 2), turn=(0, -50, 0), rgb=(1, 0.6, 0.3), shape="DISK", size=0.8)
    lamp("AREA", 40, at=(0, -3, 3), turn=(40, 0, 0), rgb=(0.4, 0.6, 1), shape="ELLIPSE", size=0.6, size_y=1.2).scale = (2, 1, 1)
    lamp("AREA", 50, at=(2.5, 1, 2.5), turn=(0, 40, 0), shape="SQUARE", size=0.5, exposure=1.0)


def area_not_normalized():
    shown()
    lamp("AREA", 12, at=(1, -1, 3), turn=(20, 20, 0), shape="RECTANGLE", size=1.5, size_y=0.8, normalize=False)


def lamps_in_the_picture():
    """One that the camera sees, one that it looks through from behind, one that it is told not to see."""
    shown()
    lamp("AREA", 30, at=(-2, 2, 2), turn=(-100, 0, 160), shape="SQUARE", size=1.2).visible_camera = True
    lamp("AREA", 50, at=(1.0, -2, 1.2), turn=(70, 0, 0), shape="DISK", size=0.8, rgb=(0.5, 0.7, 1)).visible_camera = True
    lamp("POINT", 60, at=(2, 1, 1.6), size=0.15)


def point_with_radius():
    shown()
    lamp("POINT", 300, at=(1.2, -1.6, 2.2), size=0.25)


def warm_lamp():
    shown()
    lamp("AREA", 90, at=(1, -1, 3), turn=(20, 20, 0), shape="SQUARE", size=1.0, use_temperature=True, temperature=3200.0)


def even_world():
    shown()
    world((0.4, 0.5, 0.7), 0.8)


def slope():
    """A world of nodes: bright above and towards +x."""
    made = world((1, 1, 1))
    where, slope = nodes(made, "ShaderNodeTexCoord"), nodes(made, "ShaderNodeMapping")
    slope.inputs["Scale"].default_value = (0.6, 0.15, 0.8)
    slope.inputs["Location"].default_value = (0.6, 0.3, 0.8)
    link(made, where.outputs["Generated"], slope.inputs["Vector"])
    link(made, slope.outputs[0], made.node_tree.nodes["Background"].inputs[0])


def world_of_nodes():
    shown()
    slope()
    # What mirrors tells which way the world is turned.
    ball(material(Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.05), at=(0.2, -1.2, 0.5), radius=0.5)


def depth_of_field():
    shown()
    world((0.3, 0.3, 0.3))
    sun(2.0)
    data = bpy.context.scene.camera.data
    data.dof.use_dof, data.dof.aperture_fstop, data.dof.focus_distance = True, 0.1, 5.2


def second_camera():
    """The active camera is not the first; half of the resolution."""
    shown()
    world((0.2, 0.2, 0.25))
    lamp("AREA", 120, at=(1, -1, 3), turn=(20, 20, 0), shape="SQUARE", size=1.0)
    bpy.context.scene.camera = look(at=(4, -3, 2), lens=35.0, name="Second")
    settings = bpy.context.scene.render
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = 192, 144, 50


def exposed():
    """Exposure of the view and of the film; Standard."""
    shown()
    world((0.1, 0.1, 0.12))
    lamp("AREA", 30, at=(1, -1, 3), turn=(20, 20, 0), shape="SQUARE", size=1.0)
    bpy.context.scene.view_settings.view_transform = "Standard"
    bpy.context.scene.view_settings.exposure = 0.7


def whole():
    """All of it, in AgX: a room with a window that looks at a sky, a lamp, a ball of light."""
    shown()
    wall = material("wall", Base_Color=(0.6, 0.6, 0.55), Roughness=0.8)
    plane(wall, at=(0, 3, 3), size=8, turn=(90, 0, 0))
    plane(wall, at=(-4, 0, 3), size=8, turn=(0, 90, 0))
    plane(glow((1, 0.7, 0.4), 3.0), at=(-3, 2.9, 2), size=0.6, turn=(90, 0, 0))
    slope()
    lamp("AREA", 120, at=(1, -1, 3.5), turn=(10, 20, 0), shape="DISK", size=1.2)
    lamp("POINT", 60, at=(-1.8, 1.5, 1.5), size=0.25, rgb=(1, 0.8, 0.5))
    hung = place(None, at=(1, 1, 2), scale=(1.5, 1.5, 1.5), name="hung")
    lamp("AREA", 20, at=(0.5, 0, 0), turn=(0, 30, radians(10)), shape="SQUARE", size=0.4).parent = hung
    bpy.context.scene.view_settings.view_transform = "AgX"
    bpy.context.scene.view_settings.exposure = 0.4


SCENES = [
    areas, area_not_normalized, lamps_in_the_picture, point_with_radius, warm_lamp, even_world, world_of_nodes, depth_of_field,
    second_camera, exposed, whole,
]


def levels(path):
    return np.asarray(Image.open(path).convert("RGB"), dtype=np.float64).mean((0, 1))


def judge(build, render, folder):
    """What is wrong ("" for nothing), and a line about it."""
    name = build.__name__
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settings = bpy.context.scene.render
    settings.resolution_x, settings.resolution_y = 96, 72
    bpy.context.scene.view_settings.view_transform = "AgX"
    build()
    settings.engine = "CYCLES"
    file, truth, seen = folder / f"{name}.blend", folder / f"{name}.cycles.exr", folder / f"{name}.cycles.png"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    cycles(truth, SAMPLES)
    settings.image_settings.file_format = "PNG"
    settings.image_settings.color_depth = "8"
    bpy.data.images["Render Result"].save_render(str(seen))
    out, shown = folder / f"{name}.exr", folder / f"{name}.png"
    given = ["--render", render, "-o", out, "-o", shown, "--spp", "256", "--method", "path"]
    ran = subprocess.run(
        [sys.executable, SCRIPT, file, "--", *given], capture_output=True, text=True, cwd=folder, stdin=subprocess.DEVNULL
    )
    if ran.returncode:
        return "is refused", (ran.stderr or ran.stdout).strip()[-300:]
    mine, right = blocks(read(out)), blocks(read(truth))
    if mine.shape != right.shape:
        return "has another size", f"{mine.shape}, {right.shape}"
    mean, wanted = mine.mean((0, 1)), right.mean((0, 1))
    off, rms = mean / wanted - 1, np.sqrt(((mine - right) ** 2).mean()) / wanted.mean()
    apart = levels(shown) - levels(seen)
    good = np.abs(off).max() <= MEAN and rms <= BLOCKS and np.abs(apart).max() <= LEVELS
    worst = lambda x: x[np.abs(x).argmax()]
    line = f"mean {100 * worst(off):+.2f} %, blocks {100 * rms:.1f} %, PNG {worst(apart):+.2f} levels"
    notes = [line for line in ran.stderr.splitlines() if "draw.py:" in line]
    return "" if good else "differs", line + "".join(f"; {note}" for note in notes)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("render")
    arguments.add_argument("names", nargs="*")
    arguments.add_argument("--keep", help="folder for files and pictures")
    given = arguments.parse_intermixed_args()
    render = str(pathlib.Path(given.render).resolve())
    unknown = set(given.names) - {build.__name__ for build in SCENES}
    if unknown:
        sys.exit(f"no such scene: {', '.join(sorted(unknown))}")
    wrong = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(given.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for build in SCENES:
            if given.names and build.__name__ not in given.names:
                continue
            with Quiet():
                what, line = judge(build, render, folder.absolute())
            wrong += bool(what)
            print(f"{'WRONG' if what else '     '} {build.__name__}: {line}{f' [{what}]' if what else ''}", flush=True)
    return 1 if wrong else 0


sys.exit(main())
