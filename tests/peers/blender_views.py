"""The views of `render image` against Blender's own, in 8-bit levels.

A lamp with a texture of colours, two thirds of them greys and mild colours as pictures have them and one third saturated,
from 9 stops below middle grey to 9 above, fills the film of an orthographic camera: one texel is one pixel. `render image`
writes it as OpenEXR and, through each view and at some exposures, as PNG; Blender saves the same OpenEXR as PNG through
the view of that name, look None, without dither. Fails where a level differs by more than 1 anywhere.

  pip install bpy==4.5.* numpy (3.11 is the Python that it is for)
  python tests/peers/blender_views.py target/release/render
"""

import os
import pathlib
import subprocess
import sys
import tempfile

try:
    import bpy
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

SIZE = 512
STOPS = (-9, 9)
EXPOSURES = (0, -2.5, 1)
VIEWS = {"standard": "Standard", "agx": "AgX", "filmic": "Filmic"}
ALLOWED = 1

SCENE = f"""<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0 0 1" target="0 0 0" up="0 1 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
            <rfilter type="box"><float name="radius" value="0.01"/></rfilter>
        </film>
    </sensor>
    <shape type="rectangle">
        <emitter type="area">
            <texture name="radiance" type="bitmap">
                <string name="filename" value="colours.exr"/>
                <string name="filter_type" value="nearest"/>
                <boolean name="raw" value="true"/>
            </texture>
        </emitter>
    </shape>
</scene>"""


def colours():
    """Radiance of SIZE × SIZE pixels."""
    rng = np.random.default_rng(1)
    count = SIZE * SIZE
    level = 0.18 * 2 ** rng.uniform(*STOPS, (count, 1))
    hue = rng.uniform(0, 1, (count, 3))
    hue /= hue.max(1, keepdims=True)
    saturation = np.where(np.arange(count) % 3 < 2, rng.uniform(0, 0.5, count), rng.uniform(0.5, 1, count))[:, None]
    saturation[::50] = 0
    return (level * (1 - saturation + saturation * hue)).astype(np.float32).reshape(SIZE, SIZE, 3)


def image_of(pixels):
    """Blender's image of linear light, bottom row first as it wants it."""
    image = bpy.data.images.new("colours", SIZE, SIZE, alpha=False, float_buffer=True, is_data=False)
    image.colorspace_settings.name = "Linear Rec.709"
    rgba = np.concatenate([pixels[::-1], np.ones((SIZE, SIZE, 1), np.float32)], 2)
    image.pixels.foreach_set(rgba.ravel())
    return image


def levels(path):
    """8-bit levels of a PNG, top row first."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(SIZE * SIZE * 4, np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return np.round(255 * values.reshape(SIZE, SIZE, 4)[::-1, :, :3]).astype(int)


def save(image, path, kind, view="Standard", exposure=0.0):
    """Saves through a view."""
    scene = bpy.context.scene
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = view
    scene.view_settings.look = "None"
    scene.view_settings.exposure = exposure
    scene.view_settings.gamma = 1.0
    scene.render.dither_intensity = 0.0
    settings = scene.render.image_settings
    settings.file_format = kind
    settings.color_mode = "RGB"
    settings.color_depth = "32" if kind == "OPEN_EXR" else "8"
    image.save_render(path, scene=scene)


def main():
    render = os.path.abspath(sys.argv[1])
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        image = image_of(colours())
        save(image, str(folder / "colours.exr"), "OPEN_EXR")
        (folder / "scene.xml").write_text(SCENE)
        for view, theirs in VIEWS.items():
            for exposure in EXPOSURES:
                out = ["-o", "ours.png", "--view", view, "--exposure", str(exposure)]
                command = [render, "image", "scene.xml", "--spp", "1", *out]
                subprocess.run(command, cwd=folder, check=True, capture_output=True)
                save(image, str(folder / "theirs.png"), "PNG", theirs, exposure)
                # The first row of a texture is at v = 0, the bottom of a rectangle, as in Mitsuba.
                ours = levels(str(folder / "ours.png"))[::-1]
                away = np.abs(ours - levels(str(folder / "theirs.png")))
                good = away.max() <= ALLOWED
                wrong += not good
                share = [100 * (away == n).mean() for n in (0, 1)]
                print(
                    f"{'     ' if good else 'WRONG'} {view} {exposure:+} EV: {share[0]:.2f} % of the values are the same, "
                    f"{share[1]:.2f} % one level off, largest difference {away.max()}"
                )
    return 1 if wrong else 0


sys.exit(main())
