"""Lamps and worlds."""

from math import radians

import bpy
import numpy as np
import OpenEXR

from .kit import ball, cube, lamp, link, material, nodes, place, scene, stage, sun, world


def shown(**how):
    stage(lights=False, wall=False, **how)
    cube(material(Base_Color=(0.8, 0.35, 0.1), Roughness=0.6), size=1.2, at=(0, 0, 0.6), turn=(0, 0, 30))


@scene()
def point():
    shown()
    lamp("POINT", 400, at=(2, -2, 3))


@scene()
def point_coloured():
    shown()
    lamp("POINT", 400, at=(2, -2, 3), rgb=(1, 0.5, 0.2))


@scene()
def point_with_size():
    shown()
    lamp("POINT", 400, at=(2, -2, 3), size=0.1)


@scene(differs="glTF's lamps are points: shadows of a lamp of half a metre are soft")
def point_large():
    shown()
    lamp("POINT", 400, at=(1.2, -1.2, 1.6), size=0.6)


@scene()
def point_not_round():
    """A strength that is not a round number of watts."""
    shown()
    lamp("POINT", 271.8281828, at=(2, -2, 3))


@scene()
def point_under_scaled_parent():
    shown()
    above = place(None, at=(1, -1, 1), scale=(2, 2, 2), name="above")
    lamp("POINT", 400, at=(0.5, -0.5, 1)).parent = above


@scene()
def points_many():
    shown()
    for i in range(9):
        rgb = [(1, 0.3, 0.3), (0.3, 1, 0.3), (0.3, 0.3, 1)][i % 3]
        lamp("POINT", 60, at=(1.5 * (i % 3) - 1.5, 1.5 * (i // 3) - 2.5, 2 + 0.2 * i), rgb=rgb)


@scene()
def spot():
    shown()
    lamp("SPOT", 900, at=(1, -1, 4), turn=(14, 14, 0), spot_size=radians(45), spot_blend=0.15)


@scene()
def spot_hard():
    shown()
    lamp("SPOT", 900, at=(1, -1, 4), turn=(14, 14, 0), spot_size=radians(45), spot_blend=0.0)


@scene()
def spot_soft():
    shown()
    lamp("SPOT", 900, at=(1, -1, 4), turn=(14, 14, 0), spot_size=radians(60), spot_blend=1.0)


@scene()
def spot_wide():
    shown()
    lamp("SPOT", 900, at=(0, -1, 3), spot_size=radians(150), spot_blend=0.5)


@scene()
def sun_hard():
    shown()
    sun(3.0)


@scene()
def sun_of_half_a_degree():
    shown()
    sun(3.0, size=0.00918)


@scene()
def sun_coloured_and_point():
    shown()
    sun(2.0, rgb=(1, 0.9, 0.7), turn=(50, -20, 0))
    lamp("POINT", 200, at=(-2, -2, 2), rgb=(0.4, 0.6, 1))


@scene(export={"export_import_convert_lighting_mode": "COMPAT"}, warns=['lighting mode "Unitless"'])
def units_unitless():
    shown()
    lamp("POINT", 400, at=(2, -2, 3))
    sun(1.0)


@scene(export={"export_import_convert_lighting_mode": "RAW"}, warns=['lighting mode "Raw"'])
def units_raw():
    shown()
    lamp("POINT", 400, at=(2, -2, 3))
    sun(1.0)


@scene(export={"export_import_convert_lighting_mode": "COMPAT"}, args=["--light-units", "unitless"])
def units_named():
    shown()
    lamp("POINT", 271.8281828, at=(2, -2, 3))


@scene(export={"export_import_convert_lighting_mode": "RAW"}, warns=['lighting mode "Raw"'])
def units_raw_spot():
    shown()
    lamp("SPOT", 900, at=(1, -1, 4), turn=(14, 14, 0), spot_size=radians(60), spot_blend=0.3)


@scene(differs="glTF has no area lamps: the exporter drops them", args=["--env", "0.1,0.1,0.1"])
def area():
    shown()
    world((0.1, 0.1, 0.1))
    lamp("AREA", 100, at=(1, -1, 3), turn=(20, 20, 0))


@scene()
def point_exposed():
    shown()
    lamp("POINT", 400, at=(2, -2, 3), exposure=1.0)


@scene()
def point_warm():
    shown()
    lamp("POINT", 400, at=(2, -2, 3), use_temperature=True, temperature=3000.0)


@scene(args=["--env", "0.4,0.5,0.6"])
def world_even():
    shown()
    world((0.4, 0.5, 0.6))


@scene(args=["--env", "0.1,0.2,0.3"])
def world_strength():
    shown()
    world((0.2, 0.4, 0.6), 0.5)
    sun(2.0)


def sky(file, turn=0.0):
    """A sky of a bright patch before a slope, as a file for both programs."""
    h, w = 64, 128
    y, x = np.mgrid[0:h, 0:w]
    pixels = np.stack([0.2 + 0.6 * y / h, 0.3 + 0.4 * y / h, 0.5 + 0.3 * x / w], -1).astype(np.float32)
    pixels[40:50, 20:36] = (12, 10, 8)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    # Rows of Blender's pictures start below.
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels[::-1])}).write(str(file))
    made = world((1, 1, 1))
    texture = nodes(made, "ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(str(file))
    link(made, texture.outputs[0], made.node_tree.nodes["Background"].inputs[0])
    if turn:
        mapping, where = nodes(made, "ShaderNodeMapping"), nodes(made, "ShaderNodeTexCoord")
        mapping.inputs["Rotation"].default_value = (0, 0, radians(turn))
        link(made, where.outputs["Generated"], mapping.inputs["Vector"])
        link(made, mapping.outputs[0], texture.inputs["Vector"])


SKY = {"in_folder": True, "samples": 384}


@scene(args=["--env", "{folder}/sky.exr"], **SKY)
def world_of_picture(folder):
    shown()
    sky(folder / "sky.exr")


@scene(args=["--env", "{folder}/sky.exr", "--env-turn", "-60"], **SKY)
def world_of_picture_turned(folder):
    """The Mapping node turns the directions, so the sky the other way."""
    shown()
    sky(folder / "sky.exr", 60.0)


@scene(args=["--env", "{folder}/sky.exr"], **SKY)
def world_seen_in_a_mirror(folder):
    stage(lights=False, wall=False)
    ball(material(Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.05))
    sky(folder / "sky.exr")
