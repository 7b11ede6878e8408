#!/usr/bin/env python3
"""Writes the glTF files of gltf-blender and gltf-sheen, and those of gltf-glass that hold something or are half metal: python3
make_gltf_layers.py

The square of make_gltf.py fills the view of a camera of one by one units; where it says so, before a wall that shines.
"""

import make_gltf

CUBE = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
# Two triangles for each face, seen from outside.
FACES = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]


class Layers(make_gltf.File):
    """A file with materials of its own, mesh 0 having the first."""

    def __init__(self, *materials, blender=True):
        super().__init__()
        self.json["materials"] = list(materials)
        self.json["cameras"][0]["orthographic"] |= {"xmag": 0.5, "ymag": 0.5}
        if blender:
            self.json["asset"]["generator"] = "Khronos glTF Blender I/O v4.5.51"
        used = {e for m in materials for e in m.get("extensions", {})}
        if used:
            self.json["extensionsUsed"] = sorted(used)

    def mesh(self, material, corners=make_gltf.CORNERS, indices=(0, 1, 2, 0, 2, 3)):
        primitive = {"attributes": {"POSITION": self.accessor(corners)}, "indices": self.accessor(indices, "H")}
        self.json["meshes"].append({"primitives": [primitive | {"material": material}]})
        return len(self.json["meshes"]) - 1

    def cube(self, material):
        return self.mesh(material, CUBE, FACES)

    def node_of(self, mesh, z=0, **fields):
        self.node(mesh=mesh, translation=[0, 0, z], **fields)


def surface(rgb=(0, 0, 0), alpha=1, metallic=0, roughness=1, **fields):
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*rgb, alpha],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        }
    } | fields


NO_SPECULAR = {"KHR_materials_specular": {"specularFactor": 0}}


def lamp(rgb=(1, 1, 1), alpha=1, **fields):
    if alpha < 1:
        fields["alphaMode"] = "BLEND"
    return surface(alpha=alpha, emissiveFactor=list(rgb), extensions=NO_SPECULAR, **fields)


def glass(index=1.5, metallic=0, rgb=(1, 1, 1), volume=None):
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": index}}
    if volume:
        extensions["KHR_materials_volume"] = volume
    return surface(rgb, metallic=metallic, roughness=0, extensions=extensions)


def layers():
    # The square, turned so that it is seen under a cosine of 0.2, in an even world.
    turn = {"rotation": [0.6324555, 0, 0, 0.7745967], "scale": [5, 5, 5]}
    for name, metallic, roughness in (("plastic", 0, 0.3), ("rough_metal", 1, 1)):
        file = Layers(surface((1, 1, 1), metallic=metallic, roughness=roughness))
        file.node(mesh=0, **turn)
        file.write(f"valid/gltf-blender/{name}.gltf")
    file = Layers()
    del file.primitive["material"]
    file.node(mesh=0)
    file.write("valid/gltf-blender/no_material.gltf")


def lamps():
    # A lamp that shines on both sides, partly there, before a wall; the camera sees its front or its back.
    half = lamp(alpha=0.4, doubleSided=True)
    for name, turn in (("front", [0, 0, 0, 1]), ("back", [0, 1, 0, 0])):
        file = Layers(half, lamp((0.5, 0.5, 0.5), doubleSided=True))
        file.node_of(0, rotation=turn)
        file.node_of(file.mesh(1), -3)
        file.write(f"valid/gltf-blender/lamp_{name}.gltf")
    # A closed one: its inside shines, too.
    file = Layers(half, lamp((0.5, 0.5, 0.5), doubleSided=True))
    file.node_of(file.cube(0))
    file.node_of(file.mesh(1), -3)
    file.write("valid/gltf-blender/lamp_closed.gltf")
    # From behind, with its back culled.
    for blender in (True, False):
        file = Layers(lamp(), blender=blender)
        file.node(mesh=0, rotation=[0, 1, 0, 0])
        file.write(f"valid/gltf-blender/lamp_culled{'' if blender else '_elsewhere'}.gltf")


def glasses():
    # Half metal, both black: what is left is half of the reflection of the glass.
    file = Layers(glass(metallic=0.5, rgb=(0, 0, 0)), blender=False)
    file.node(mesh=0)
    file.write("valid/gltf-glass/metal_half.gltf")
    # In the middle of a cube of two units, of index 1, that leaves a quarter, half and all of the light after one unit:
    # a square that shines, and a mirror, before which a wall shines behind the camera.
    absorbing = {"thicknessFactor": 1, "attenuationColor": [0.25, 0.5, 1], "attenuationDistance": 1}
    for blender in (False, True):
        file = Layers(glass(1.0, volume=absorbing), lamp(), blender=blender)
        file.node_of(file.cube(0))
        file.node_of(file.mesh(1))
        file.write(f"valid/gltf-glass/holds_a_lamp{'_blender' if blender else ''}.gltf")
    file = Layers(glass(1.0, volume=absorbing), surface((1, 1, 1), metallic=1, roughness=0), lamp(), blender=False)
    file.node_of(file.cube(0))
    file.node_of(file.mesh(1, [(0.9 * x, 0.9 * y, 0) for x, y, _ in make_gltf.CORNERS]))
    file.node_of(file.mesh(2), 8, rotation=[0, 1, 0, 0])
    file.write("valid/gltf-glass/holds_a_mirror.gltf")
    # A lamp in clear glass inside of the absorbing one, from which light comes half a unit through the outer glass.
    file = Layers(glass(1.0, volume=absorbing), glass(1.0), lamp(), blender=False)
    file.node_of(file.cube(0))
    file.node(mesh=file.cube(1), scale=[0.5] * 3)
    file.node(mesh=file.mesh(2), scale=[0.4] * 3)
    file.json["cameras"][0]["orthographic"] |= {"xmag": 0.3, "ymag": 0.3}
    file.write("valid/gltf-glass/holds_glass.gltf")


def sheen(rgb, roughness, base=(0, 0, 0), **fields):
    fibres = {"sheenColorFactor": list(rgb), "sheenRoughnessFactor": roughness} | fields
    return surface(base, extensions=NO_SPECULAR | {"KHR_materials_sheen": fibres})


def sheens():
    # Over black and white, seen under a cosine of 0.2, in an even world.
    turn = {"rotation": [0.6324555, 0, 0, 0.7745967], "scale": [5, 5, 5]}
    for name, rgb, roughness, base in (
        ("white", (1, 1, 1), 0.5, (1, 1, 1)),
        ("dyed", (0.8, 0.4, 0.2), 0.6, (1, 1, 1)),
        ("fibres", (0.8, 0.4, 0.2), 0.6, (0, 0, 0)),
        ("sharp", (1, 1, 1), 0.1, (0, 0, 0)),
        ("none", (0, 0, 0), 0.6, (1, 1, 1)),
    ):
        file = Layers(sheen(rgb, roughness, base), blender=False)
        file.node(mesh=0, **turn)
        file.write(f"valid/gltf-sheen/{name}.gltf")
    # Under a lamp 60 degrees from the normal, which is where the camera is.
    file = Layers(sheen((0.8, 0.4, 0.2), 0.6), blender=False)
    file.json["extensionsUsed"].append("KHR_lights_punctual")
    file.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 683.0}]}}
    file.node(mesh=0)
    file.node(rotation=[0.5, 0, 0, 0.8660254], extensions={"KHR_lights_punctual": {"light": 0}})
    file.write("valid/gltf-sheen/lamp.gltf")


if __name__ == "__main__":
    sheens()
    layers()
    lamps()
    glasses()
