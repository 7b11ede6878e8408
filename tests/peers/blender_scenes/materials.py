"""Surfaces that reflect: everything of a Principled material but textures and glass."""

import bpy
import numpy as np

from .kit import ball, checks, cube, glow, link, look, material, nodes, plane, principled, scene, stage, sun, textured


def shown(**inputs):
    """A ball of a material on the stage."""
    stage()
    made = material(**inputs)
    ball(made)
    return made


@scene()
def metal_polished():
    shown(Base_Color=(0.9, 0.7, 0.3), Metallic=1.0, Roughness=0.08)


@scene()
def metal_half_rough():
    shown(Base_Color=(0.9, 0.7, 0.3), Metallic=1.0, Roughness=0.5)


@scene()
def metal_rough():
    shown(Base_Color=(0.95, 0.9, 0.85), Metallic=1.0, Roughness=1.0)


@scene()
def metal_floor_grazing():
    stage(floor=material(Base_Color=(0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.35))
    cube(material(Base_Color=(0.7, 0.1, 0.1)))


@scene()
def metal_half():
    shown(Base_Color=(0.2, 0.6, 0.9), Metallic=0.5, Roughness=0.4)


@scene()
def metal_with_tinted_edge():
    shown(Base_Color=(0.7, 0.7, 0.7), Metallic=1.0, Roughness=0.2, Specular_Tint=(0.9, 0.8, 0.7))


@scene()
def dielectric_polished():
    shown(Base_Color=(0.7, 0.1, 0.1), Roughness=0.1)


@scene()
def dielectric_rough():
    shown(Base_Color=(0.7, 0.7, 0.1), Roughness=0.7)


@scene()
def dielectric_white_floor():
    stage(floor=material(Base_Color=(0.9, 0.9, 0.9), Roughness=0.3))
    cube(material(Base_Color=(0.7, 0.1, 0.1)))


@scene()
def dielectric_under_sun_grazing():
    stage(lights=False, wall=False, floor=material(Base_Color=(0.8, 0.8, 0.8), Roughness=0.3))
    bpy.data.objects.remove(bpy.context.scene.camera)
    look(at=(0, -6, 0.5), to=(0, 0, 0.2))
    sun()


@scene()
def index_low():
    shown(Base_Color=(0.5, 0.5, 0.5), Roughness=0.2, IOR=1.2)


@scene(differs="the exporter drops the index of what has neither transmission nor a tint of the reflection")
def index_high():
    shown(Base_Color=(0.5, 0.5, 0.5), Roughness=0.2, IOR=2.2)


@scene()
def index_high_and_tinted():
    shown(Base_Color=(0.5, 0.5, 0.5), Roughness=0.2, IOR=2.2, Specular_Tint=(1.0, 0.9, 0.7))


@scene()
def specular_none():
    shown(Base_Color=(0.5, 0.2, 0.5), Roughness=0.2, Specular_IOR_Level=0.0)


@scene()
def specular_full():
    shown(Base_Color=(0.5, 0.2, 0.5), Roughness=0.2, Specular_IOR_Level=1.0)


@scene()
def specular_tinted():
    shown(Base_Color=(0.1, 0.1, 0.1), Roughness=0.2, Specular_Tint=(1.0, 0.3, 0.1))


@scene()
def coat_smooth():
    shown(Base_Color=(0.5, 0.05, 0.05), Roughness=0.6, Coat_Weight=1.0, Coat_Roughness=0.03)


@scene()
def coat_rough():
    shown(Base_Color=(0.5, 0.05, 0.05), Roughness=0.6, Coat_Weight=0.7, Coat_Roughness=0.4)


@scene()
def coat_over_metal():
    shown(Base_Color=(0.8, 0.5, 0.3), Metallic=1.0, Roughness=0.4, Coat_Weight=1.0, Coat_Roughness=0.1)


@scene(differs="glTF's coat has no colour: the exporter drops Coat Tint")
def coat_tinted():
    shown(Base_Color=(0.8, 0.8, 0.8), Coat_Weight=1.0, Coat_Tint=(1.0, 0.3, 0.2))


@scene(differs="fibres: glTF has the model of Estevez and Kulla, Cycles that of Zeltner et al.")
def sheen():
    stage(floor=material(Base_Color=(0.05, 0.05, 0.1), Roughness=0.9, Sheen_Weight=1.0, Sheen_Roughness=0.4))


@scene(differs="KHR_materials_anisotropy is ignored, with a warning", warns=["KHR_materials_anisotropy"])
def anisotropic_metal():
    shown(Base_Color=(0.8, 0.8, 0.8), Metallic=1.0, Roughness=0.4, Anisotropic=0.8)


@scene()
def subsurface():
    """The exporter drops Subsurface Weight, which hardly shows here."""
    shown(Base_Color=(0.8, 0.3, 0.2), Subsurface_Weight=1.0, Subsurface_Scale=1.0, Subsurface_Radius=(3.0, 2.0, 1.0))


@scene(differs="glTF's base is Lambertian: the exporter drops Diffuse Roughness")
def diffuse_rough():
    shown(Base_Color=(0.6, 0.6, 0.6), Diffuse_Roughness=1.0, Roughness=1.0)


@scene()
def alpha_blend():
    shown(Base_Color=(0.8, 0.1, 0.1), Alpha=0.4)


@scene()
def alpha_zero():
    shown(Base_Color=(0.8, 0.1, 0.1), Alpha=0.0)


@scene()
def alpha_hashed():
    made = shown(Base_Color=(0.1, 0.6, 0.1), Alpha=0.6)
    made.surface_render_method = "DITHERED"


@scene()
def alpha_layers():
    stage()
    for i in range(4):
        plane(
            material(f"layer {i}", Base_Color=(0.2 + 0.2 * i, 0.5, 0.8 - 0.2 * i), Alpha=0.3),
            at=(0, 0.4 * i - 0.6, 1),
            turn=(90, 0, 0),
        )


def holes(made, clip):
    """Alpha from a ramp; above ½ by the node that the exporter takes for a mask."""
    y, x = np.mgrid[0:64, 0:64] / 63
    pixels = np.stack([0 * x + 0.8, 0.3 * y, 0.2 + 0 * x, x], -1)
    texture = textured(made, pixels)
    alpha = principled(made).inputs["Alpha"]
    if not clip:
        return link(made, texture.outputs["Alpha"], alpha)
    step = nodes(made, "ShaderNodeMath", operation="ROUND")
    link(made, texture.outputs["Alpha"], step.inputs[0])
    link(made, step.outputs[0], alpha)


@scene()
def alpha_of_texture():
    stage()
    made = material(Roughness=0.8)
    holes(made, clip=False)
    plane(made, at=(0, 0, 1.1), turn=(90, 0, 0))


@scene()
def alpha_clip():
    stage()
    made = material(Roughness=0.8)
    holes(made, clip=True)
    plane(made, at=(0, 0, 1.1), turn=(90, 0, 0))


@scene()
def emission_strength():
    stage(lights=False)
    ball(glow((1.0, 0.6, 0.2), 5.0))


@scene()
def emission_and_colour():
    stage()
    ball(material(Base_Color=(0.1, 0.6, 0.2), Emission_Color=(0.2, 0.1, 0.4), Emission_Strength=0.8))


@scene()
def emission_texture():
    stage()
    made = material(Base_Color=(0, 0, 0), Specular_IOR_Level=0.0, Emission_Strength=0.6)
    textured(made, checks(4, (1, 0.5, 0.1), (0, 0, 0.1)), "Emission Color", interpolation="Closest")
    plane(made, at=(0, 1, 1.2), turn=(75, 0, 0), scale=(1.2, 1.2, 1))


@scene()
def emission_half_there():
    stage(lights=False)
    plane(
        material(
            Base_Color=(0, 0, 0), Specular_IOR_Level=0.0, Emission_Color=(1, 1, 1), Emission_Strength=6.0, Alpha=0.4
        ),
        at=(0.6, 0, 2.6),
        turn=(15, 15, 0),
    )
    cube(material(Base_Color=(0.3, 0.6, 0.8)), size=0.9, at=(0, 0, 0.45))


@scene()
def emission_behind_mask():
    stage(lights=False)
    plane(glow((1, 0.9, 0.8), 6.0), at=(0, 0.2, 3.2), size=3)
    made = material(Roughness=0.9)
    holes(made, clip=True)
    plane(made, at=(0, 0, 2.2), size=3)


@scene()
def emission_of_front_alone():
    stage(lights=False)
    made = glow((1, 1, 1), 5.0)
    made.use_backface_culling = True
    ball(made, at=(0.8, 0, 1.2), radius=0.5)
    cube(material(Base_Color=(0.8, 0.3, 0.3)), at=(-0.8, 0, 0.5), size=1)


@scene()
def emission_of_a_culled_sheet():
    """Cycles knows no culling."""
    stage(lights=False)
    made = glow((1, 1, 1), 5.0)
    made.use_backface_culling = True
    plane(made, at=(0, 0.5, 1.2), turn=(90, 0, 0), size=1)
    cube(material(Base_Color=(0.8, 0.3, 0.3)), at=(-1, -1, 0.4), size=0.8)


@scene()
def emission_closed_and_half_there():
    stage(lights=False)
    ball(
        material(
            Base_Color=(0, 0, 0), Specular_IOR_Level=0.0, Emission_Color=(1, 0.7, 0.4), Emission_Strength=6.0, Alpha=0.4
        )
    )


@scene()
def emission_shader_alone():
    """A material of an Emission node, without Principled."""
    stage(lights=False)
    made = bpy.data.materials.new("emission")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.remove(principled(made))
    shine = nodes(made, "ShaderNodeEmission")
    shine.inputs["Color"].default_value, shine.inputs["Strength"].default_value = (0.4, 0.7, 1.0, 1.0), 4.0
    link(made, shine.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs[0])
    ball(made)


@scene()
def backface_culling():
    stage()
    made = material(Base_Color=(0.2, 0.5, 0.8))
    made.use_backface_culling = True
    plane(made, at=(-1, 0, 1), turn=(90, 0, 0), size=1.6)
    plane(made, at=(1, 0, 1), turn=(-90, 0, 0), size=1.6)


@scene()
def no_material():
    stage()
    cube()
