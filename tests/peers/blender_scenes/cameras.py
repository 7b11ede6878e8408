"""Cameras: lenses, sensors, shapes of pictures, several of them."""

import bpy

from .kit import ball, cube, look, material, place, scene, stage


def shown():
    stage()
    cube(material(Base_Color=(0.8, 0.35, 0.1), Roughness=0.6), size=1.2, at=(-0.5, 0, 0.6), turn=(0, 0, 30))
    ball(material(Base_Color=(0.1, 0.35, 0.8), Roughness=0.6), radius=0.5, at=(0.9, -0.6, 0.5))


def lens(**settings):
    shown()
    for key, value in settings.items():
        setattr(bpy.context.scene.camera.data, key, value)


@scene()
def camera_wide():
    lens(lens=18.0)


@scene(width=64, height=96)
def camera_upright():
    lens(lens=35.0)


@scene(width=64, height=96)
def camera_upright_sensor_horizontal():
    lens(lens=35.0, sensor_fit="HORIZONTAL")


@scene()
def camera_sensor_vertical():
    lens(lens=35.0, sensor_fit="VERTICAL", sensor_height=20.0)


@scene()
def camera_sensor_large():
    lens(lens=60.0, sensor_width=54.0)


@scene(width=120, height=40)
def camera_panorama():
    lens(lens=24.0)


@scene()
def camera_orthographic():
    lens(type="ORTHO", ortho_scale=5.0)


@scene(width=64, height=96)
def camera_orthographic_upright():
    lens(type="ORTHO", ortho_scale=6.0)


@scene(differs="glTF's cameras have no shift: the exporter drops it")
def camera_shifted():
    lens(shift_x=0.2, shift_y=-0.1)


@scene()
def camera_out_of_focus_slightly():
    """Depth of field is dropped; here it hardly shows."""
    lens()
    bpy.context.scene.camera.data.dof.use_dof = True
    bpy.context.scene.camera.data.dof.focus_distance = 6.7
    bpy.context.scene.camera.data.dof.aperture_fstop = 11


@scene(args=["--camera", "Second"])
def camera_second():
    shown()
    bpy.context.scene.camera = look(at=(5, -3, 2), lens=50, name="Second")


@scene(args=["--camera", "1"])
def camera_by_number():
    """The exporter writes objects by name."""
    shown()
    bpy.context.scene.camera = look(at=(5, -3, 2), lens=50, name="Second")


@scene(args=["--camera", "Second"])
def camera_with_the_name_of_its_data():
    shown()
    bpy.context.scene.camera = look(at=(-4, -3, 2), lens=50, name="Second")
    bpy.context.scene.camera.data.name = "Lens"


@scene()
def camera_under_scaled_parent():
    shown()
    camera = bpy.context.scene.camera
    above = place(None, scale=(0.5, 0.5, 0.5), name="rig")
    camera.location, camera.parent = camera.location * 2, above


@scene()
def camera_rolled():
    shown()
    bpy.context.scene.camera.rotation_euler.rotate_axis("Z", 0.5)


@scene()
def camera_clips():
    """What is nearer than the start of the clip is not seen."""
    shown()
    bpy.context.scene.camera.data.clip_start = 5.8
