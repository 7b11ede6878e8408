"""Textures: colours and data, wrapping, filtering, transforms, sets of coordinates, normals."""

import bpy
import numpy as np

from .kit import (
    ball,
    checks,
    cube,
    image,
    link,
    material,
    nodes,
    normal_mapped,
    plane,
    principled,
    ramp,
    scene,
    stage,
    sun,
    textured,
    waves,
)


def board(made, **how):
    """A board that faces the camera."""
    return plane(made, at=(0, 0, 1.2), turn=(70, 0, 0), **how)


def repeat(of, x, y=None):
    """Scales the coordinates of a plane."""
    layer = of.data.uv_layers.active.data
    uv = np.empty(2 * len(layer), dtype=np.float32)
    layer.foreach_get("uv", uv)
    layer.foreach_set("uv", ((uv.reshape(-1, 2) - 0.25) * (x, y or x)).ravel())


@scene()
def texture_srgb():
    stage()
    made = material(Roughness=0.8)
    textured(made, ramp())
    board(made)


@scene(differs="Cycles blends the numbers of the file, glTF the light that they stand for")
def texture_of_few_pixels():
    stage()
    made = material(Roughness=0.8)
    textured(made, checks(2, (1, 1, 1), (0, 0, 0), 1))
    board(made)


@scene(differs="glTF's base colours are always sRGB: the exporter drops Non-Color")
def texture_of_numbers_as_colour():
    stage()
    made = material(Roughness=0.8)
    textured(made, ramp(), space="Non-Color")
    board(made)


def wrapped(extension, interpolation="Linear"):
    stage()
    made = material(Roughness=0.8)
    textured(made, ramp(8), extension=extension, interpolation=interpolation)
    repeat(board(made), 3)


@scene()
def wrap_repeat():
    wrapped("REPEAT")


@scene()
def wrap_extend():
    wrapped("EXTEND")


@scene()
def wrap_mirror():
    wrapped("MIRROR")


@scene(differs="glTF has no clip: the exporter writes CLAMP_TO_EDGE or REPEAT")
def wrap_clip():
    wrapped("CLIP")


@scene()
def filter_closest():
    wrapped("REPEAT", "Closest")


@scene()
def filter_cubic():
    wrapped("REPEAT", "Cubic")


def mapped(location=(0, 0, 0), rotation=0.0, scale=(1, 1, 1)):
    stage()
    made = material(Roughness=0.8)
    texture = textured(made, ramp(16))
    mapping, uv = nodes(made, "ShaderNodeMapping"), nodes(made, "ShaderNodeUVMap")
    mapping.inputs["Location"].default_value = location
    mapping.inputs["Rotation"].default_value = (0, 0, rotation)
    mapping.inputs["Scale"].default_value = scale
    link(made, uv.outputs[0], mapping.inputs["Vector"])
    link(made, mapping.outputs[0], texture.inputs["Vector"])
    board(made)


@scene()
def uv_moved():
    mapped(location=(0.3, 0.2, 0))


@scene()
def uv_turned():
    mapped(rotation=0.6)


@scene()
def uv_scaled():
    mapped(scale=(2.5, 1.5, 1))


@scene()
def uv_all():
    mapped((0.3, 0.2, 0), 0.6, (2.5, 1.5, 1))


@scene()
def second_uv_map():
    stage()
    made = material(Roughness=0.8)
    texture = textured(made, ramp(16))
    link(made, nodes(made, "ShaderNodeUVMap", uv_map="Other").outputs[0], texture.inputs["Vector"])
    of = board(made)
    other = of.data.uv_layers.new(name="Other")
    for i, corner in enumerate(((0, 1), (0, 0), (1, 0), (1, 1))):
        other.data[i].uv = (0.8 * corner[0] + 0.1, corner[1])


def painted(domain, kind):
    made = material(Roughness=0.8)
    node = nodes(made, "ShaderNodeVertexColor", layer_name="Paint")
    link(made, node.outputs["Color"], principled(made).inputs["Base Color"])
    of = ball(made)
    attribute = of.data.color_attributes.new("Paint", kind, domain)
    at = [v.co for v in of.data.vertices]
    index = range(len(at)) if domain == "POINT" else [l.vertex_index for l in of.data.loops]
    for value, i in zip(attribute.data, index):
        value.color = (0.5 + 0.5 * at[i].x, 0.5 + 0.5 * at[i].z, 0.3, 1.0)
    of.data.color_attributes.active_color = attribute


@scene()
def vertex_colours_of_corners():
    stage()
    painted("CORNER", "BYTE_COLOR")


@scene()
def vertex_colours_of_points():
    stage()
    painted("POINT", "FLOAT_COLOR")


@scene()
def vertex_colours_times_texture():
    stage()
    made = material(Roughness=0.8)
    mix = nodes(made, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
    mix.inputs[0].default_value = 1.0
    texture = nodes(made, "ShaderNodeTexImage")
    texture.image = image("checks", checks(4))
    paint = nodes(made, "ShaderNodeVertexColor", layer_name="Paint")
    link(made, texture.outputs["Color"], mix.inputs[6])
    link(made, paint.outputs["Color"], mix.inputs[7])
    link(made, mix.outputs[2], principled(made).inputs["Base Color"])
    of = board(made)
    attribute = of.data.color_attributes.new("Paint", "BYTE_COLOR", "CORNER")
    for value, rgb in zip(attribute.data, ((1, 0.2, 0.2), (0.2, 1, 0.2), (0.2, 0.2, 1), (1, 1, 1))):
        value.color = (*rgb, 1)


@scene()
def colour_times_texture():
    stage()
    made = material(Roughness=0.8)
    mix = nodes(made, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
    mix.inputs[0].default_value = 1.0
    texture = nodes(made, "ShaderNodeTexImage")
    texture.image = image("checks", checks(4))
    link(made, texture.outputs["Color"], mix.inputs[6])
    mix.inputs[7].default_value = (0.9, 0.4, 0.2, 1)
    link(made, mix.outputs[2], principled(made).inputs["Base Color"])
    board(made)


@scene()
def roughness_and_metal_from_one_texture():
    stage()
    made = material(Base_Color=(0.8, 0.6, 0.4))
    y, x = np.mgrid[0:32, 0:32] / 31
    texture = nodes(made, "ShaderNodeTexImage")
    texture.image = image("orm", np.stack([1 + 0 * x, 0.1 + 0.8 * x, (y > 0.5).astype(float)], -1), "Non-Color")
    parts = nodes(made, "ShaderNodeSeparateColor")
    link(made, texture.outputs["Color"], parts.inputs[0])
    link(made, parts.outputs[1], principled(made).inputs["Roughness"])
    link(made, parts.outputs[2], principled(made).inputs["Metallic"])
    board(made)


@scene()
def roughness_from_grey_texture():
    stage()
    made = material(Base_Color=(0.8, 0.6, 0.4), Metallic=1.0)
    textured(made, checks(4, (0.1,) * 3, (0.7,) * 3), "Roughness", space="Non-Color")
    ball(made)


@scene()
def specular_tint_from_texture():
    stage()
    made = material(Base_Color=(0.05, 0.05, 0.05), Roughness=0.3)
    textured(made, checks(4, (1, 0.2, 0.2), (0.2, 1, 0.2)), "Specular Tint")
    ball(made)


@scene()
def coat_from_texture():
    stage()
    made = material(Base_Color=(0.1, 0.1, 0.3), Roughness=0.7)
    textured(made, checks(4, (1, 1, 1), (0, 0, 0)), "Coat Weight", space="Non-Color")
    ball(made)


def bumpy(strength=1.0, on=ball, mirrored=False, **inputs):
    made = material(**({"Base_Color": (0.6, 0.6, 0.6), "Roughness": 0.4} | inputs))
    normal_mapped(made, waves(), strength)
    of = on(made)
    if mirrored:
        repeat(of, -1, 1)


@scene()
def normal_map():
    stage()
    bumpy()


@scene()
def normal_map_strong():
    stage()
    bumpy(2.5)


@scene()
def normal_map_weak():
    stage()
    bumpy(0.3)


@scene()
def normal_map_mirrored():
    stage()
    bumpy(on=board, mirrored=True)


@scene()
def normal_map_of_metal():
    stage()
    bumpy(Metallic=1.0, Roughness=0.15)


@scene()
def normal_map_of_matte():
    stage()
    bumpy(Roughness=1.0, Specular_IOR_Level=0.0)


@scene()
def normal_map_under_sun():
    stage(lights=False)
    bumpy()
    sun(turn=(60, 30, 0))


@scene()
def normal_map_grazing():
    made = material(Base_Color=(0.5, 0.5, 0.5), Roughness=0.3)
    normal_mapped(made, waves())
    stage(lights=False, floor=made)
    bpy.context.scene.camera.location = (0, -6, 0.6)
    bpy.context.scene.camera.rotation_euler = (1.55, 0, 0)
    sun()


@scene()
def normal_map_under_coat():
    stage()
    made = material(Base_Color=(0.5, 0.1, 0.1), Roughness=0.4, Coat_Weight=1.0)
    normal_mapped(made, waves())
    ball(made)


@scene()
def normal_map_of_coat():
    stage()
    made = material(Base_Color=(0.5, 0.1, 0.1), Roughness=0.4, Coat_Weight=1.0)
    normal_mapped(made, waves(), into="Coat Normal")
    ball(made)


@scene()
def normal_map_of_glass():
    stage()
    bumpy(Base_Color=(1, 1, 1), Transmission_Weight=1.0, Roughness=0.2)


@scene(differs="glTF has no bump maps: the exporter drops them")
def bump_map():
    stage()
    made = material(Base_Color=(0.6, 0.6, 0.6), Roughness=0.4)
    bump, texture = nodes(made, "ShaderNodeBump"), nodes(made, "ShaderNodeTexImage")
    bump.inputs["Distance"].default_value = 0.3
    texture.image = image("heights", np.repeat(waves()[..., :1], 3, -1), "Non-Color")
    link(made, texture.outputs["Color"], bump.inputs["Height"])
    link(made, bump.outputs["Normal"], principled(made).inputs["Normal"])
    ball(made)


@scene(differs="glTF has no procedural textures: the exporter drops them")
def procedural_texture():
    stage()
    made = material(Roughness=0.8)
    noise = nodes(made, "ShaderNodeTexNoise")
    link(made, noise.outputs["Color"], principled(made).inputs["Base Color"])
    cube(made)
