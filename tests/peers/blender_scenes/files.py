"""What the exporter may write: containers, formats of textures, options."""

import bpy

from .geometry import bend, orange
from .kit import README, ball, checks, cube, lamp, last, material, ramp, scene, stage, textured, world


def shown():
    stage()
    made = material(Roughness=0.7)
    textured(made, checks(4, (0.9, 0.6, 0.2), (0.1, 0.3, 0.6)))
    cube(made)
    other = material("metal", Metallic=1.0, Roughness=0.3)
    textured(other, ramp())
    ball(other, at=(1.4, -0.6, 0.4), radius=0.4)


@scene(export=README, args=["--camera", "Camera", "--env", "0.05,0.05,0.05"])
def as_the_readme_says():
    rig = bend()
    rig.pose.bones["high"].rotation_mode = "XYZ"
    rig.pose.bones["high"].rotation_euler = (0, 0, 0.9)
    cube(orange(), size=0.5, at=(1.3, -0.5, 0.4)).modifiers.new("s", "SUBSURF").levels = 2
    bpy.context.object.modifiers["s"].render_levels = 2
    lamp("SPOT", 400, at=(-2, -2, 3), turn=(40, -30, 0), spot_size=1.0, size=0.05)
    world((0.05, 0.05, 0.05))


@scene(ending=".gltf")
def separate_files():
    shown()


@scene(ending=".gltf", export={"export_texture_dir": "textures of mine"})
def separate_files_in_a_folder():
    shown()


@scene(export={"export_image_format": "JPEG", "export_image_quality": 95})
def textures_jpeg():
    shown()


@scene(export={"export_image_format": "WEBP", "export_image_quality": 95})
def textures_webp():
    shown()


@scene(export={"export_image_add_webp": True, "export_image_webp_fallback": True})
def textures_webp_and_fallback():
    shown()


@scene(export={"export_image_format": "NONE"}, differs="exported without images")
def textures_none():
    shown()


@scene(export={"export_yup": False})
def z_up():
    shown()


@scene(export={"export_materials": "NONE"}, differs="exported without materials, the lamp's too")
def materials_none():
    shown()


@scene(export={"export_tangents": True})
def tangents():
    shown()


@scene(export={"export_normals": False}, differs="without normals the specification asks for flat shading")
def normals_none():
    stage()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=1)
    last(material(Base_Color=(0.8, 0.35, 0.1), Metallic=1.0, Roughness=0.2), (0, 0, 1), smooth=True)


@scene(export={"export_draco_mesh_compression_enable": True}, refused="export without compression")
def compressed_by_draco():
    shown()


@scene(export={"export_extras": True, "export_attributes": True, "export_shared_accessors": True})
def extras_and_attributes():
    shown()
    of = bpy.context.object
    of["note"] = "mine"
    of.data.attributes.new("_heat", "FLOAT", "POINT")


@scene(export={"use_selection": True})
def selection_alone():
    shown()
    for of in bpy.context.scene.objects:
        of.select_set(True)


@scene(export={"export_hierarchy_full_collections": True})
def collections_as_nodes():
    shown()


@scene(export={"export_original_specular": True})
def original_specular():
    stage()
    ball(material(Base_Color=(0.1, 0.1, 0.1), Roughness=0.2, Specular_IOR_Level=0.9))


@scene(ending=".gltf")
def names_of_any_kind():
    """Names with spaces, quotes and letters of other scripts."""
    stage()
    made = material("Größe 'x' % 100 #", Roughness=0.7)
    textured(made, checks(4))
    cube(made).name = "объект 立方体"


@scene()
def several_scenes():
    """The exporter writes all scenes of the file; the active one is drawn."""
    shown()
    other = bpy.data.scenes.new("Other")
    of = bpy.data.objects.new("lamp", bpy.data.meshes.new("empty"))
    other.collection.objects.link(of)
