"""Writes the OpenEXR and Radiance HDR inputs of this folder: `pip install numpy OpenEXR`, then `python make_exr.py`.

All show one picture of 8 × 4 pixels: red (x + 1)/8, green (y + 1)/4, blue 1/2 and 1/8 in turn. Every value is one that
half floats and shared exponents hold exactly, so that what is read can be compared without tolerance.
"""

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenEXR

HERE = Path(__file__).parent
WIDTH, HEIGHT = 8, 4
X, Y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
RED, GREEN, BLUE = (X + 1) / 8, (Y + 1) / 4, np.where((X + Y) % 2, 0.125, 0.5)
ONES = np.ones((HEIGHT, WIDTH))


def half(values):
    return np.ascontiguousarray(values, np.float16)


def single(values):
    return np.ascontiguousarray(values, np.float32)


def part(channels, name=None, compression=OpenEXR.NO_COMPRESSION, **attributes):
    """A part of an OpenEXR file; windows are (left, top, right, bottom), the last ones included."""
    header = {"compression": compression, "type": OpenEXR.scanlineimage, **attributes}
    for window in ("dataWindow", "displayWindow"):
        if window in header:
            left, top, right, bottom = header[window]
            header[window] = (np.array([left, top], np.int32), np.array([right, bottom], np.int32))
    arguments = (header, channels)
    return OpenEXR.Part(*arguments, name) if name else OpenEXR.Part(*arguments)


def exr(path, *parts):
    """A file of one part or several."""
    path = HERE / path
    path.parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File(list(parts)).write(str(path))


def deep(name=None):
    """A part whose pixels hold two samples each."""
    samples = np.empty((HEIGHT, WIDTH), dtype=object)
    for at in np.ndindex(HEIGHT, WIDTH):
        samples[at] = np.full(2, 0.5, np.float32)
    channels = dict.fromkeys("RGBZ", samples)
    return part(channels, name, OpenEXR.ZIPS_COMPRESSION, type=OpenEXR.deepscanline)


def rgb(prefix="", kind=half, rgb=(RED, GREEN, BLUE), names="RGB"):
    return {prefix + name: kind(channel) for name, channel in zip(names, rgb)}


def layers(folder):
    normal = {"X": half(0 * ONES), "Y": half(0 * ONES), "Z": half(ONES)}
    depth = {"Z": single(9 * ONES)}
    other = (GREEN, RED, BLUE)
    nan = np.where(X == 3, np.nan, 1.0)
    exr(f"{folder}/plain.exr", part(rgb()))
    exr(f"{folder}/lower.exr", part(rgb(names="rgb", kind=single)))
    exr(f"{folder}/words.exr", part({"red": half(RED), "green": half(GREEN), "blue": half(BLUE)}))
    exr(f"{folder}/normals_first.exr", part(normal, "N"), part(rgb(), "rgba"))
    exr(f"{folder}/depth_first.exr", part(depth, "depth"), part(rgb(), "rgba"))
    exr(f"{folder}/normals_as_colours.exr", part(rgb(rgb=(0 * ONES, 0 * ONES, ONES)), "N"), part(rgb(), "light"))
    exr(f"{folder}/nuke.exr", part(rgb("depth.", rgb=other), "depth"), part(rgb("beauty."), "beauty"))
    exr(
        f"{folder}/blender.exr",
        part(
            {
                **rgb("ViewLayer.Combined.", single),
                "ViewLayer.Combined.A": single(ONES),
                **rgb("ViewLayer.DiffCol.", single, other),
                "ViewLayer.Depth.Z": single(np.inf * ONES),
                **{f"ViewLayer.Normal.{n}": single(0 * ONES) for n in "XYZ"},
            }
        ),
    )
    exr(f"{folder}/nan_alpha.exr", part({**rgb(), "A": half(nan), "Z": single(nan)}))
    exr(f"{folder}/cryptomatte.exr", part({**rgb("Crypto00.", single, (nan, nan, nan)), **rgb("image.", single)}))
    exr(f"{folder}/stereo.exr", part({**rgb("left.", rgb=other), **rgb("right.")}, multiView=["right", "left"]))
    exr(f"{folder}/two.exr", part({**rgb("direct."), **rgb("indirect.", rgb=other)}))
    counts = {name: np.ascontiguousarray(8 * c, np.uint32) for name, c in zip("RGB", (RED, GREEN, BLUE))}
    exr(f"{folder}/uint.exr", part(counts))
    exr(f"{folder}/eight.exr", part(rgb(rgb=(8 * RED, 8 * GREEN, 8 * BLUE))))
    # Tiles of a part after one whose blocks come first, and flat pixels after deep ones.
    tiled = {"type": OpenEXR.tiledimage, "tiles": tiles(4, 2)}
    exr(f"{folder}/tiled.exr", part(depth, "depth"), part(rgb(), "rgba", OpenEXR.ZIP_COMPRESSION, **tiled))
    exr(f"{folder}/deep_first.exr", deep("samples"), part(rgb(), "rgba"))
    exr(f"{folder}/piz.exr", part(rgb(kind=single), None, OpenEXR.PIZ_COMPRESSION))
    exr(f"{folder}/dwab.exr", part(rgb(rgb=(ONES, ONES / 2, ONES / 4)), None, OpenEXR.DWAB_COMPRESSION))


def subsampled(path, y, ry, by, lines):
    """Luminance with chroma of every second column and row, which the module cannot write: blocks of one line as they
    are, or of 16 lines, compressed by ZIP."""
    channels = [("BY", by, 2), ("RY", ry, 2), ("Y", y, 1)]
    listed = b"".join(n.encode() + b"\0" + struct.pack("<4i", 2, 0, s, s) for n, _, s in channels)
    box = struct.pack("<4i", 0, 0, WIDTH - 1, HEIGHT - 1)
    attributes = [
        ("channels", "chlist", listed + b"\0"),
        ("compression", "compression", bytes([0 if lines == 1 else 3])),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    head = struct.pack("<2i", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    blocks = []
    for first in range(0, HEIGHT, lines):
        rows = range(first, min(first + lines, HEIGHT))
        raw = b"".join(single(c[row, ::s]).tobytes() for row in rows for _, c, s in channels if row % s == 0)
        if lines > 1:
            # Bytes at even places first, then differences: what ZIP does before it compresses.
            split = np.frombuffer(raw[::2] + raw[1::2], np.uint8).astype(int)
            raw = zlib.compress(bytes([split[0], *((np.diff(split) + 128) % 256)]), 9)
        blocks.append(struct.pack("<2i", first, len(raw)) + raw)
    offsets = np.cumsum([len(head) + 8 * len(blocks)] + [len(b) for b in blocks[:-1]])
    (HERE / path).write_bytes(head + struct.pack(f"<{len(blocks)}Q", *offsets) + b"".join(blocks))


def tiles(width, height):
    description = OpenEXR.TileDescription()
    description.xSize, description.ySize = width, height
    description.mode, description.roundingMode = OpenEXR.ONE_LEVEL, OpenEXR.ROUND_DOWN
    return description


def crop(left, top, right, bottom):
    return rgb(rgb=[c[top : bottom + 1, left : right + 1] for c in (RED, GREEN, BLUE)])


def windows(folder, refused):
    display = (0, 0, WIDTH - 1, HEIGHT - 1)
    inside = (X >= 2) & (X <= 5) & (Y >= 1) & (Y <= 2)
    exr(f"{folder}/full.exr", part(rgb()))
    exr(f"{folder}/black.exr", part(rgb(rgb=(RED * inside, GREEN * inside, BLUE * inside))))
    exr(f"{folder}/trimmed.exr", part(crop(2, 1, 5, 2), dataWindow=(2, 1, 5, 2), displayWindow=display))
    wide = [np.pad(c, ((1, 2), (3, 1)), constant_values=7) for c in (RED, GREEN, BLUE)]
    exr(f"{folder}/overscan.exr", part(rgb(rgb=wide), dataWindow=(-3, -1, 8, 5), displayWindow=display))
    exr(
        f"{folder}/negative.exr",
        part(crop(2, 1, 5, 2), dataWindow=(-98, 6, -95, 7), displayWindow=(-100, 5, -100 + WIDTH - 1, 5 + HEIGHT - 1)),
    )
    halves = {"left": (0, 0, 3, 3), "right": (4, 0, 7, 3)}
    for name, window in halves.items():
        exr(f"{refused}/{name}.exr", part(crop(*window), dataWindow=window, displayWindow=display))
    exr(f"{folder}/left.exr", part(crop(0, 0, 3, 3), dataWindow=(0, 0, 3, 3), displayWindow=display))


def chroma(rgb, weights):
    """Y, RY and BY of a colour (OpenEXR's technical introduction)."""
    y = sum(w * c for w, c in zip(weights, rgb))
    return y, (rgb[0] - y) / y, (rgb[2] - y) / y


REC_709 = (0.212639, 0.715169, 0.072192)
# SMPTE RP 431-2 with the white D65, and its luminances (SMPTE RP 177).
P3 = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329)
P3_LUMINANCE = (0.228975, 0.691739, 0.079287)
# P3 to Rec. 709: their whites are the same, so that no adaptation is needed.
P3_TO_709 = np.array([[1.224940, -0.224940, 0], [-0.042057, 1.042057, 0], [-0.019638, -0.078636, 1.098274]])


def colours(folder):
    y, ry, by = chroma((RED, GREEN, BLUE), REC_709)
    exr(f"{folder}/rgb.exr", part(rgb()))
    exr(f"{folder}/yc.exr", part({"Y": single(y), "RY": single(ry), "BY": single(by)}))
    exr(f"{folder}/y.exr", part({"Y": half(RED)}))
    exr(f"{folder}/ya.exr", part({"Y": half(RED), "A": half(0 * ONES)}))
    exr(f"{folder}/roughness.exr", part({"R": half(RED)}))
    exr(f"{folder}/grey.exr", part(rgb(rgb=(RED, RED, RED))))
    # Chroma of every second column and row: of a colour that is the same everywhere but for its brightness.
    scale = (X + 1 + WIDTH * Y) / 32
    smooth = tuple(scale * c for c in (1.0, 0.5, 0.25))
    y, ry, by = chroma(smooth, REC_709)
    exr(f"{folder}/smooth.exr", part(rgb(kind=single, rgb=smooth)))
    subsampled(f"{folder}/subsampled.exr", y, ry, by, 1)
    subsampled(f"{folder}/subsampled_zip.exr", y, ry, by, 16)
    y, ry, by = chroma((RED, GREEN, BLUE), P3_LUMINANCE)
    exr(f"{folder}/p3.exr", part(rgb(kind=single), chromaticities=P3))
    as_709 = np.moveaxis(np.stack([RED, GREEN, BLUE], axis=-1) @ P3_TO_709.T, -1, 0)
    exr(f"{folder}/p3_as_709.exr", part(rgb(kind=single, rgb=as_709)))
    exr(f"{folder}/p3_yc.exr", part({"Y": single(y), "RY": single(ry), "BY": single(by)}, chromaticities=P3))


def rgbe(rgb):
    """Four bytes for each pixel; colours that are exact."""
    largest = np.max(rgb, axis=-1)
    exponent = np.where(largest > 0, np.frexp(largest)[1], -128)
    mantissa = np.floor(rgb * np.exp2(8.0 - exponent)[..., None])
    return np.concatenate([mantissa, exponent[..., None] + 128], axis=-1).astype(np.uint8)


def hdr(path, header, pixels, resolution=f"-Y {HEIGHT} +X {WIDTH}", ends="\n"):
    path = HERE / path
    path.parent.mkdir(parents=True, exist_ok=True)
    text = ends.join([*header, "", resolution, ""])
    path.write_bytes(text.encode("latin-1") + pixels.tobytes())


def radiance(folder, refused):
    picture = np.stack([RED, GREEN, BLUE], axis=-1)
    pixels = rgbe(picture)
    plain = ["#?RADIANCE", "FORMAT=32-bit_rle_rgbe"]
    exr(f"{folder}/picture.exr", part(rgb()))
    hdr(f"{folder}/plain.hdr", plain, pixels)
    hdr(f"{folder}/rgbe_magic.hdr", ["#?RGBE", *plain[1:]], pixels)
    hdr(f"{folder}/autopano.hdr", ["#?AUTOPANO", "# caf\xe9", *plain[1:]], pixels, ends="\r\n")
    hdr(f"{folder}/no_format.hdr", ["#?RADIANCE", "oconv scene.rad", "GAMMA=2.2", "PIXASPECT=0.5"], pixels)
    exposures = ["EXPOSURE=4", "\tEXPOSURE=100", "COLORCORR= 1 2 4", "EXPOSURE= 0.5"]
    hdr(f"{folder}/exposure.hdr", [*plain, *exposures], rgbe(2 * picture * [1, 2, 4]))
    turned = {
        f"+Y {HEIGHT} +X {WIDTH}": pixels[::-1],
        f"-Y {HEIGHT} -X {WIDTH}": pixels[:, ::-1],
        f"+Y {HEIGHT} -X {WIDTH}": pixels[::-1, ::-1],
        f"+X {WIDTH} -Y {HEIGHT}": pixels.transpose(1, 0, 2),
        f"+X {WIDTH} +Y {HEIGHT}": pixels[::-1].transpose(1, 0, 2),
        f"-X {WIDTH} -Y {HEIGHT}": pixels[:, ::-1].transpose(1, 0, 2),
        f"-X {WIDTH} +Y {HEIGHT}": pixels[::-1, ::-1].transpose(1, 0, 2),
    }
    for resolution, turned_pixels in turned.items():
        name = resolution.lower().replace("+", "plus_").replace("-", "minus_").replace(" ", "")
        for axis in "xy":
            for size in (WIDTH, HEIGHT):
                name = name.replace(f"{axis}{size}", f"{axis}_")
        hdr(f"{folder}/{name.strip('_')}.hdr", plain, turned_pixels, resolution)
    as_709 = np.moveaxis(picture @ P3_TO_709.T, -1, 0)
    exr(f"{folder}/p3_as_709.exr", part(rgb(kind=single, rgb=as_709)))
    hdr(f"{folder}/p3.hdr", [*plain, "PRIMARIES= " + " ".join(map(str, P3))], pixels)
    # Scanlines of 8 pixels in the new run-length encoding: each component as one piece.
    runs = b"".join(
        bytes([2, 2, 0, WIDTH]) + b"".join(bytes([WIDTH]) + bytes(row[:, c]) for c in range(4)) for row in pixels
    )
    hdr(f"{folder}/new_runs.hdr", plain, np.frombuffer(runs, np.uint8))
    # CIE XYZ of the picture (IEC 61966-2-1), rounded to eight bits.
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    hdr(f"{folder}/xyze.hdr", [plain[0], "FORMAT=32-bit_rle_xyze"], rgbe(picture @ to_xyz.T))
    hdr(f"{refused}/cut.hdr", plain, pixels[:3])
    hdr(f"{refused}/format.hdr", [plain[0], "FORMAT=32-bit_rle_hsve"], pixels)
    hdr(f"{refused}/exposure.hdr", [*plain, "EXPOSURE=0"], pixels)
    hdr(f"{refused}/resolution.hdr", plain, pixels, f"-Y {HEIGHT} +Y {WIDTH}")


def sizes(folder):
    """Files of a few hundred bytes that claim pictures of gigabytes."""
    exr(f"{folder}/data.exr", part(rgb()))
    path = HERE / f"{folder}/data.exr"
    small = path.read_bytes()

    def widened(window, size):
        start = small.index(window.encode() + b"\0box2i\0") + len(window) + 7 + 4
        return small[:start] + struct.pack("<4i", 0, 0, size - 1, size - 1) + small[start + 16 :]

    path.write_bytes(widened("dataWindow", 16384))
    (HERE / f"{folder}/display.exr").write_bytes(widened("displayWindow", 16384))
    (HERE / f"{folder}/display_30.exr").write_bytes(widened("displayWindow", 1 << 30))
    hdr(f"{folder}/sky.hdr", ["#?RADIANCE"], np.zeros(40, np.uint8), "-Y 8192 +X 16384")


if __name__ == "__main__":
    layers("valid/exr-layers")
    windows("valid/exr-windows", "invalid/exr-windows")
    colours("valid/exr-colour")
    radiance("valid/radiance-hdr", "invalid/radiance-hdr")
    exr("invalid/exr-layers/normals.exr", part({n: half(ONES) for n in "XYZ"}))
    exr("invalid/exr-layers/deep.exr", deep())
    exr("invalid/exr-layers/nan_alpha.exr", part({**rgb(), "A": half(np.where(X == 3, np.nan, 1))}))
    exr("invalid/exr-layers/nan.exr", part({**rgb(), "R": half(np.where(X + 8 * Y == 11, np.nan, 1))}))
    sizes("invalid/image-size")
