"""The parts that scenes are built of. Numbers are Blender's: metres, z up, radians, watts."""

from dataclasses import dataclass, field
from math import radians

import bpy
import numpy as np
from mathutils import Vector


@dataclass
class Scene:
    """One export: how it is built, and how the two programs are asked."""

    name: str
    build: object
    # Options of bpy.ops.export_scene.gltf beside the usual ones.
    export: dict = field(default_factory=dict)
    # Options of `render image`.
    args: list = field(default_factory=list)
    # Frame that Cycles draws.
    frame: int = 1
    width: int = 96
    height: int = 72
    # Samples per pixel of Cycles.
    samples: int = 192
    # Samples per pixel of `render`.
    spp: int = 128
    # Why the pictures differ by nature, if they do.
    differs: str = ""
    # What `render` must refuse the file with, where it must.
    refused: str = ""
    # What its warnings must tell.
    warns: list = field(default_factory=list)
    # Ending of the exported file.
    ending: str = ".glb"
    # Whether the function is given the folder, to put files there.
    in_folder: bool = False


SCENES: list[Scene] = []

# What render/README.md tells people to choose; all else is the exporter's default.
README = {"export_animations": True, "export_apply": True, "export_rest_position_armature": False}


def scene(**options):
    """Registers a function that builds a scene, under its name."""

    def register(build):
        SCENES.append(Scene(build.__name__.replace("_", "-"), build, **options))
        return build

    return register


def material(name="material", **inputs):
    """A Principled material; `Base_Color=…` sets the input "Base Color"."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    node = principled(made)
    for key, value in inputs.items():
        node.inputs[key.replace("_", " ")].default_value = colour(value) if "Color" in key or "Tint" in key else value
    return made


def colour(rgb):
    return (*rgb, 1.0) if len(rgb) == 3 else rgb


def principled(of):
    return next(n for n in of.node_tree.nodes if n.type == "BSDF_PRINCIPLED")


def nodes(of, kind, **settings):
    """A new node, with what is set on it."""
    node = of.node_tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def link(of, source, target):
    of.node_tree.links.new(source, target)


def image(name, pixels, space="sRGB", ending="PNG"):
    """A picture from an array of rows from below, values as the file has them, packed into the scene."""
    pixels = np.asarray(pixels, dtype=np.float32)
    if pixels.shape[2] == 3:
        pixels = np.concatenate([pixels, np.ones_like(pixels[..., :1])], -1)
    made = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=bool((pixels[..., 3] < 1).any()))
    made.colorspace_settings.name = space
    made.alpha_mode = "CHANNEL_PACKED" if ending == "PNG" else "STRAIGHT"
    made.pixels.foreach_set(pixels.ravel())
    made.file_format = ending
    made.pack()
    return made


def checks(n=8, a=(0.9, 0.9, 0.9), b=(0.2, 0.2, 0.2), pixels=16):
    """n × n fields of so many pixels in width and height, the first of colour a."""
    y, x = np.mgrid[0 : pixels * n, 0 : pixels * n] // pixels
    return np.where(((x + y) % 2 == 0)[..., None], np.array(a, dtype=np.float32), np.array(b, dtype=np.float32))


def ramp(n=32):
    """Red grows to the right, green upwards."""
    y, x = np.mgrid[0:n, 0:n] / (n - 1)
    return np.stack([0.1 + 0.8 * x, 0.1 + 0.8 * y, 0.3 + 0 * x], -1)


def waves(n=64, count=6, slope=0.35):
    """Normals of waves along both axes."""
    y, x = (np.mgrid[0:n, 0:n] + 0.5) / n * 2 * np.pi * count
    normal = np.stack([slope * np.cos(x), slope * np.sin(y), np.ones_like(x)], -1)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def textured(of, pixels, into="Base Color", output="Color", **settings):
    """An image texture before an input of the Principled node; returns its node."""
    space = settings.pop("space", "sRGB")
    ending = settings.pop("ending", "PNG")
    node = nodes(of, "ShaderNodeTexImage", **settings)
    node.image = image(f"{of.name} {into}", pixels, space, ending)
    link(of, node.outputs[output], principled(of).inputs[into])
    return node


def normal_mapped(of, pixels, strength=1.0, into="Normal"):
    """A tangent-space normal map; returns its texture node."""
    bend = nodes(of, "ShaderNodeNormalMap")
    bend.inputs["Strength"].default_value = strength
    texture = nodes(of, "ShaderNodeTexImage")
    texture.image = image(f"{of.name} normals", pixels, "Non-Color")
    link(of, texture.outputs["Color"], bend.inputs["Color"])
    link(of, bend.outputs["Normal"], principled(of).inputs[into])
    return texture


def place(made, at=(0, 0, 0), turn=(0, 0, 0), scale=(1, 1, 1), name=None):
    """Puts an object, or a new one for data, into the scene; the turn is in degrees."""
    if not isinstance(made, bpy.types.Object):
        made = bpy.data.objects.new(name or made.name if made else name, made)
    if made.name not in bpy.context.scene.collection.objects:
        bpy.context.scene.collection.objects.link(made)
    made.location, made.scale = at, scale
    made.rotation_euler = [radians(a) for a in turn]
    return made


def last(of=None, at=None, turn=(0, 0, 0), scale=(1, 1, 1), smooth=False):
    """The object that an operator just made, finished."""
    made = bpy.context.object
    if of is not None:
        made.data.materials.append(of)
    if smooth:
        made.data.shade_smooth()
    return place(made, at if at is not None else made.location, turn, scale)


def ball(of=None, at=(0, 0, 1), radius=1.0, smooth=True, **how):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius)
    return last(of, at, smooth=smooth, **how)


def cube(of=None, at=(0, 0, 1), size=1.4, **how):
    bpy.ops.mesh.primitive_cube_add(size=size)
    return last(of, at, **how)


def plane(of=None, at=(0, 0, 0), size=2.0, **how):
    bpy.ops.mesh.primitive_plane_add(size=size)
    return last(of, at, **how)


def lamp(kind, energy, at=(0, 0, 4), turn=(0, 0, 0), rgb=(1, 1, 1), size=0.0, **settings):
    """A lamp of Blender, a point unless it has a size."""
    made = bpy.data.lights.new(kind.title(), kind)
    made.energy, made.color = energy, rgb
    if kind == "SUN":
        made.angle = size
    elif kind != "AREA":
        made.shadow_soft_size = size
    for key, value in settings.items():
        setattr(made, key, value)
    return place(made, at, turn)


def sun(energy=3.0, turn=(35, 20, 0), **settings):
    return lamp("SUN", energy, turn=turn, **settings)


def glow(rgb=(1, 1, 1), strength=6.0):
    """A material of lamps."""
    return material(
        "lamp", Base_Color=(0, 0, 0), Specular_IOR_Level=0.0, Emission_Color=rgb, Emission_Strength=strength
    )


def matte(rgb=(0.5, 0.5, 0.5)):
    return material("matte", Base_Color=rgb, Roughness=1.0, Specular_IOR_Level=0.0)


def look(at=(0, -6, 3), to=(0, 0, 0.7), lens=40.0, name="Camera", **settings):
    """A camera that looks at a point, and takes the picture if it is the first."""
    data = bpy.data.cameras.new(name)
    data.lens = lens
    for key, value in settings.items():
        setattr(data, key, value)
    made = place(data, at)
    made.rotation_euler = (Vector(to) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = bpy.context.scene.camera or made
    return made


def stage(lights=True, floor=None, wall=True):
    """A floor, a wall behind it that shines a little, a broad lamp, and the camera."""
    plane(floor or matte(), size=14)
    if wall:
        shine = material(
            "wall", Base_Color=(0.3, 0.4, 0.6), Roughness=0.8, Emission_Color=(0.3, 0.4, 0.6), Emission_Strength=0.4
        )
        plane(shine, at=(0, 5, 3), size=14, turn=(90, 0, 0))
    if lights:
        plane(glow(), at=(2.5, -1.5, 4), size=2.5, turn=(20, 30, 0))
    look()


def world(rgb, strength=1.0):
    """An even world."""
    made = bpy.data.worlds.new("World")
    made.use_nodes = True
    back = made.node_tree.nodes["Background"]
    back.inputs["Color"].default_value, back.inputs["Strength"].default_value = colour(rgb), strength
    bpy.context.scene.world = made
    return made
