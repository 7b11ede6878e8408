"""Glass: sheets and solids, clear, tinted, rough and absorbing."""

import bpy

from .kit import ball, checks, cube, glow, link, material, nodes, plane, principled, scene, stage, sun, textured


def glassy(name="glass", **inputs):
    return material(
        name, **({"Base_Color": (1, 1, 1), "Roughness": 0.0, "Transmission_Weight": 1.0, "IOR": 1.45} | inputs)
    )


def chequered():
    floor = material("floor", Roughness=1.0, Specular_IOR_Level=0.0)
    textured(floor, checks(12), interpolation="Closest")
    stage(floor=floor)


def absorbing(made, rgb, density, thickness=1.0):
    """A Volume Absorption node, and the group by which the exporter knows the thickness."""
    absorb = nodes(made, "ShaderNodeVolumeAbsorption")
    absorb.inputs["Color"].default_value, absorb.inputs["Density"].default_value = (*rgb, 1.0), density
    out = next(n for n in made.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
    link(made, absorb.outputs[0], out.inputs["Volume"])
    group = bpy.data.node_groups.get("glTF Material Output") or bpy.data.node_groups.new(
        "glTF Material Output", "ShaderNodeTree"
    )
    if not group.interface.items_tree:
        group.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    node = nodes(made, "ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Thickness"].default_value = thickness


@scene(samples=512)
def glass_ball():
    chequered()
    ball(glassy())


@scene(samples=512)
def glass_cube_tinted():
    chequered()
    cube(glassy(Base_Color=(0.5, 0.9, 0.6)), turn=(0, 0, 30))


@scene(samples=384)
def glass_frosted():
    chequered()
    ball(glassy(Roughness=0.3))


@scene(samples=384)
def glass_very_rough():
    chequered()
    ball(glassy(Roughness=0.7, Base_Color=(0.9, 0.7, 0.5)))


@scene(samples=512)
def glass_of_high_index():
    chequered()
    ball(glassy(IOR=2.0))


@scene()
def glass_half():
    chequered()
    ball(glassy(Base_Color=(0.2, 0.5, 0.9), Transmission_Weight=0.5, Roughness=0.2))


@scene()
def glass_and_metal():
    chequered()
    ball(glassy(Base_Color=(0.9, 0.6, 0.3), Metallic=0.5, Roughness=0.2))


SHEET = (
    "a single sheet is a thin pane, as in glTF's specification; in Cycles it bends light like the surface of a block"
)


@scene(differs=SHEET)
def glass_sheet():
    chequered()
    plane(glassy(), at=(0, -1, 1.2), turn=(80, 0, 10))


@scene(differs=SHEET)
def glass_sheet_tinted():
    chequered()
    plane(glassy(Base_Color=(0.3, 0.8, 0.9)), at=(0, -1, 1.2), turn=(80, 0, 10))


@scene(differs=SHEET)
def glass_sheet_rough():
    chequered()
    plane(glassy(Base_Color=(0.8, 0.8, 0.5), Roughness=0.3), at=(0, -1, 1.2), turn=(80, 0, 10))


@scene(samples=512)
def glass_box_of_six_sheets_inside_out():
    chequered()
    box = cube(glassy(Base_Color=(0.9, 0.8, 0.6)), turn=(0, 0, 25))
    box.data.flip_normals()


@scene(samples=512)
def absorbing_ball():
    chequered()
    made = glassy()
    absorbing(made, (0.3, 0.8, 0.4), 1.2)
    ball(made)


@scene(samples=512)
def absorbing_ball_with_something_inside():
    chequered()
    made = glassy(IOR=1.1)
    absorbing(made, (0.8, 0.4, 0.3), 1.0)
    ball(made)
    ball(material("core", Base_Color=(0.8, 0.8, 0.8), Roughness=1.0, Specular_IOR_Level=0.0), at=(0, 0, 1), radius=0.5)


def lamp_inside(index):
    chequered()
    made = glassy(IOR=index)
    absorbing(made, (0.3, 0.5, 0.9), 1.0)
    ball(made)
    ball(glow((1, 1, 1), 4.0), at=(0, 0, 1), radius=0.4)


@scene(samples=512)
def absorbing_ball_with_a_lamp_inside():
    lamp_inside(1.0)


@scene(samples=512, differs="radiance shrinks by the squared index as it leaves glass, which Cycles leaves out")
def refracting_ball_with_a_lamp_inside():
    lamp_inside(1.3)


@scene(samples=512)
def absorbing_scaled():
    chequered()
    made = glassy(IOR=1.2)
    absorbing(made, (0.3, 0.8, 0.4), 0.8)
    ball(made, radius=0.5, scale=(2, 2, 2))


@scene(samples=512)
def glass_alpha():
    chequered()
    ball(glassy(Alpha=0.5, Roughness=0.4))


@scene(samples=768, spp=512)
def glass_with_coat():
    chequered()
    ball(glassy(Roughness=0.4, Coat_Weight=1.0))


@scene()
def glass_textured():
    chequered()
    made = glassy(Roughness=0.2)
    textured(made, checks(4, (0.9, 0.3, 0.2), (0.2, 0.4, 0.9)))
    ball(made)


@scene(samples=384)
def glass_in_the_sun():
    """Cycles' shadow of glass in a sun is what its path tracing finds: none of the light through it."""
    stage(lights=False)
    ball(glassy(Roughness=0.3))
    sun()
