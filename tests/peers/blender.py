"""Exports of Blender, drawn by `render` and by Cycles: every scene of tests/peers/blender_scenes is built by script,
exported to glTF, drawn by Cycles as it is in Blender, and by `render` as it is in the file.

Right is: the mean of every channel within 3.5 %, and the root mean square over blocks of 8 × 8 pixels within 6.5 % of
the mean. What differs by nature is listed with its scene, with the reason; so is what the file must be refused with.
Fails where a scene differs that is not listed, and where a listed one does not.

  pip install bpy==4.5.* numpy OpenEXR        (in the Python that bpy was built for)
  python tests/peers/blender.py target/release/render [--keep FOLDER] [--samples SHARE] [NAME …]
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

try:
    import bpy
    import numpy as np
    import OpenEXR  # noqa: F401
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from blender_scenes import animation, cameras, files, geometry, glass, lights, materials, textures  # noqa: E402, F401
from blender_scenes.kit import SCENES  # noqa: E402
from blender_scenes.measure import Quiet, blocks, cycles, read  # noqa: E402

MEAN, BLOCKS = 0.035, 0.065
# Channels darker than this are judged as if they had it.
DARK = 0.02


def export(scene, folder):
    """Builds the scene, and writes it as a file of glTF."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = scene.width, scene.height
    scene.build(*([folder] if scene.in_folder else []))
    bpy.context.scene.frame_set(scene.frame)
    path = folder / f"{scene.name}{scene.ending}"
    usual = {"export_format": "GLB" if scene.ending == ".glb" else "GLTF_SEPARATE", "export_cameras": True}
    usual |= {"export_lights": True, "export_animations": False, "export_apply": True}
    bpy.ops.export_scene.gltf(filepath=str(path), **(usual | scene.export))
    return path


def ours(render, scene, path, out):
    size = ["--width", str(scene.width), "--height", str(scene.height), "--spp", str(scene.spp), "--method", "path"]
    command = [render, "image", str(path), "-o", str(out), *size, *(a.format(folder=out.parent) for a in scene.args)]
    return subprocess.run(command, capture_output=True, text=True)


def judge(scene, render, folder):
    """What is wrong with our picture ("" for nothing), and a line about it."""
    path = export(scene, folder)
    out, truth = folder / f"{scene.name}.exr", folder / f"{scene.name}.cycles.exr"
    ran = ours(render, scene, path, out)
    said = ran.stderr.strip()
    if scene.refused:
        good = ran.returncode == 2 and scene.refused in said and len(said.splitlines()) == 1
        return "" if good else "is not refused as it must be", said[-160:]
    if ran.returncode:
        return "is refused", said[-160:]
    missing = [w for w in scene.warns if w not in said]
    if missing:
        return f"no warning tells {missing}", said[-300:]
    if not truth.exists():
        bpy.context.scene.frame_set(scene.frame)
        cycles(truth, scene.samples)
    mine, right = blocks(read(out)), blocks(read(truth))
    mean, wanted = mine.mean((0, 1)), right.mean((0, 1))
    off = (mean - wanted) / np.maximum(wanted, DARK)
    rms = np.sqrt(((mine - right) ** 2).mean()) / max(wanted.mean(), DARK)
    good = bool((np.abs(off) <= MEAN).all() and rms <= BLOCKS)
    numbers = lambda v: " ".join(f"{x:.4f}" for x in v)
    worst = 100 * off[np.abs(off).argmax()]
    line = f"ours {numbers(mean)}, Cycles {numbers(wanted)}, mean {worst:+.1f} %, blocks {100 * rms:.1f} %"
    return "" if good else "differs", line


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("render")
    arguments.add_argument("names", nargs="*")
    arguments.add_argument(
        "--keep", help="folder for files and pictures; Cycles' pictures that are there are not drawn again"
    )
    arguments.add_argument("--samples", type=float, default=1.0, help="share of the samples of both, for a quick look")
    given = arguments.parse_intermixed_args()
    render = os.path.abspath(given.render)
    unknown = set(given.names) - {s.name for s in SCENES}
    if unknown:
        sys.exit(f"no such scene: {', '.join(sorted(unknown))}")
    count = {"agree": 0, "differ by nature": 0, "WRONG": 0}
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(given.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for scene in SCENES:
            if given.names and scene.name not in given.names:
                continue
            scene.samples, scene.spp = (max(1, round(given.samples * n)) for n in (scene.samples, scene.spp))
            start = time.monotonic()
            with Quiet():
                wrong, line = judge(scene, render, folder)
            listed = wrong == "differs" and scene.differs
            if scene.differs and not wrong:
                wrong = f"agrees, though listed ({scene.differs})"
            verdict = "differ by nature" if listed else "WRONG" if wrong else "agree"
            count[verdict] += 1
            reason = f" [{scene.differs}]" if listed else f" [{wrong}]" if wrong else ""
            head = "     " if verdict == "agree" else "  by " if listed else "WRONG"
            print(f"{head} {scene.name}: {line}{reason} ({time.monotonic() - start:.1f} s)", flush=True)
    print(f"{sum(count.values())} exports: " + ", ".join(f"{n} {what}" for what, n in count.items()))
    return 1 if count["WRONG"] else 0


sys.exit(main())
