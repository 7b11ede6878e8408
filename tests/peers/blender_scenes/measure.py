"""Pictures by Cycles, and how they are compared."""

import os
import sys

import bpy
import numpy as np
import OpenEXR

# Pixels along a block.
BLOCK = 8


def read(path):
    """RGB of an EXR file, in double precision."""
    channels = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    names = {name.rsplit(".", 1)[-1]: name for name in channels if "." not in name or "Combined" in name}
    return np.stack([np.asarray(channels[names[c]].pixels, dtype=np.float64) for c in "RGB"], -1)


def blocks(picture):
    h, w = (n // BLOCK for n in picture.shape[:2])
    return picture[: h * BLOCK, : w * BLOCK].reshape(h, BLOCK, w, BLOCK, 3).mean((1, 3))


def cycles(path, samples):
    """Draws the scene that is open: no clamping, no denoising, paths as long as ours, linear light."""
    settings, how = bpy.context.scene.render, bpy.context.scene.cycles
    settings.engine, settings.filepath = "CYCLES", str(path)
    settings.image_settings.file_format, settings.image_settings.color_depth = "OPEN_EXR", "32"
    how.device, how.samples, how.use_adaptive_sampling, how.use_denoising = "CPU", samples, False, False
    how.sample_clamp_direct = how.sample_clamp_indirect = how.blur_glossy = 0
    how.pixel_filter_type = "BOX"
    for bounces in ("max", "diffuse", "glossy", "transmission"):
        setattr(how, f"{bounces}_bounces", 64)
    how.transparent_max_bounces = 256
    bpy.ops.render.render(write_still=True)


class Quiet:
    """Takes what Blender prints away from standard output."""

    def __enter__(self):
        sys.stdout.flush()
        self.kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)

    def __exit__(self, *_):
        sys.stdout.flush()
        os.dup2(self.kept, 1)
        os.close(self.kept)
