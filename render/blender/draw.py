"""Draws a scene of Blender with `render`, with what the exporter of glTF loses: world, area lamps, sizes of point lamps, exposure,
view transform, camera, its depth of field, size of the picture. No add-on; nothing is changed in the file.

  blender -b room.blend --python render/blender/draw.py -- -o room.png --time 30
  python render/blender/draw.py room.blend -- -o room.png --time 30        (pip install bpy==4.5.*)

What stands after `--` is for `render image`, and wins over what the file says, but for:

  --render PROGRAM     the program [default: render, of the path]
  --frame N            the frame that is drawn [default: the file's]
  --export FILE.glb    keep the scene there, its sky beside it as FILE.sky.exr; the command to draw it again is printed
  --export-only        draw nothing
  --sky-width N        pixels of a sky that is not even [default: 2048]
"""

import argparse
import math
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

import bpy  # first: it knows where the two below are
import bmesh
from mathutils import Matrix

# Blender's names of what `--view` knows.
VIEWS = {"Standard": "standard", "AgX": "agx", "Filmic": "filmic"}
# Point lamps below this radius, in metres, are points.
POINT = 0.001


def warn(what):
    print(f"draw.py: {what}", file=sys.stderr)


class Wrong(Exception):
    """What cannot be drawn, in words."""


def arguments():
    """Ours, and those of `render image`."""
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(prog="draw.py", usage=__doc__, add_help=False, allow_abbrev=False)
    parser.add_argument("--render", default="render")
    parser.add_argument("--frame", type=int)
    parser.add_argument("--export")
    parser.add_argument("--export-only", action="store_true")
    parser.add_argument("--sky-width", type=int, default=2048)
    ours, theirs = parser.parse_known_args(given)
    if ours.export and not ours.export.endswith(".glb"):
        parser.error("--export: the name must end with .glb")
    if ours.export_only and not ours.export:
        parser.error("--export-only: where to, says --export")
    if not 2 <= ours.sky_width <= 16384:
        parser.error("--sky-width: 2 to 16384")
    return ours, theirs


# Lamps


def colour(light):
    """Watts of each channel, whatever the lamp is."""
    tint = light.temperature_color if light.use_temperature else (1, 1, 1)
    return [light.energy * 2**light.exposure * c * t for c, t in zip(light.color, tint)]


def area(light):
    """Corners of an area lamp in its own frame, facing −z, and its area as it is placed by `matrix`."""
    wide, high = light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    if light.shape in ("SQUARE", "RECTANGLE"):
        return [(-wide / 2, -high / 2, 0), (-wide / 2, high / 2, 0), (wide / 2, high / 2, 0), (wide / 2, -high / 2, 0)]
    # Of as many corners, and so much larger, that it has the area of the ellipse to a millionth.
    count = 64
    grow = math.sqrt(math.pi / (count / 2 * math.sin(2 * math.pi / count))) / 2
    turns = [-2 * math.pi * i / count for i in range(count)]
    return [(grow * wide * math.cos(t), grow * high * math.sin(t), 0) for t in turns]


def shining(name, radiance, hidden):
    """A black material that shines from its front and is not seen from behind; nor by the camera where it is hidden."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    node = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    most = max(radiance)
    values = {"Base Color": (0, 0, 0, 1), "Specular IOR Level": 0.0, "Roughness": 1.0, "Emission Strength": most}
    values["Emission Color"] = (*(c / most for c in radiance), 1)
    for key, value in values.items():
        node.inputs[key].default_value = value
    # What `render` reads.
    made["area_lamp"], made["hidden_from_camera"] = True, hidden
    return made


def area_mesh(light, matrix, hidden):
    """An area lamp as a mesh: its watts leave the front of its area as from a Lambertian lamp."""
    corners = area(light)
    mesh = bpy.data.meshes.new(light.name)
    mesh.from_pydata(corners, [], [list(range(len(corners)))])
    scale = matrix.to_scale()
    size = sum(p.area for p in mesh.polygons) * abs(scale.x * scale.y)
    if size <= 0:
        return None
    share = 1 / (math.pi * size) if light.normalize else 1 / math.pi
    mesh.materials.append(shining(light.name, [w * share for w in colour(light)], hidden))
    if light.spread < math.radians(179.9):
        warn(f"{light.name}: its spread of {math.degrees(light.spread):.0f}° is lost, it shines everywhere")
    return mesh


def ball_mesh(light, hidden):
    """A point lamp with a radius r as a ball. (Blender's soft falloff is dimmer at a distance d, by r²/d² of it.)"""
    mesh = bpy.data.meshes.new(light.name)
    made = bmesh.new()
    bmesh.ops.create_icosphere(made, subdivisions=4, radius=light.shadow_soft_size)
    made.to_mesh(mesh)
    made.free()
    mesh.shade_smooth()
    share = 1 / (4 * math.pi**2 * light.shadow_soft_size**2)
    mesh.materials.append(shining(light.name, [w * share for w in colour(light)], hidden))
    return mesh


def replace_lamps():
    """Puts meshes in the places of lamps that glTF has no word for; whether any other lamp is left."""
    found, left = [], False
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        thing = instance.object
        if thing.type != "LIGHT" or thing.original.hide_render:
            continue
        found.append((thing.original, instance.matrix_world.copy()))
    for thing, matrix in found:
        light = thing.data
        if light.use_nodes and any(n.type not in ("EMISSION", "OUTPUT_LIGHT") for n in light.node_tree.nodes):
            warn(f"{light.name}: its nodes are lost")
        dark = max(colour(light), default=0) <= 0
        mesh = None
        if light.type == "AREA" and not dark:
            mesh = area_mesh(light, matrix, not thing.visible_camera)
        elif light.type == "POINT" and not dark and light.shadow_soft_size > POINT:
            mesh = ball_mesh(light, not thing.visible_camera)
            # The radius is that of the world, whatever the scale of the object.
            matrix = Matrix.Translation(matrix.translation)
        elif light.type in ("SUN", "SPOT", "POINT"):
            left = True
            if light.type == "SUN" and light.angle > math.radians(1):
                warn(f"{light.name}: a sun of {math.degrees(light.angle):.1f}° is drawn with sharp shadows")
            if light.type == "SPOT" and light.shadow_soft_size > 0.01:
                warn(f"{light.name}: a spot of radius {light.shadow_soft_size:.2f} is drawn with sharp shadows")
        if mesh:
            made = bpy.data.objects.new(light.name, mesh)
            bpy.context.scene.collection.objects.link(made)
            made.matrix_world = matrix
    # Lamps that have become meshes must not be exported besides.
    for light in {thing.data for thing, _ in found if thing.data.type == "POINT"}:
        if light.shadow_soft_size > POINT:
            light.energy = 0
    return left


# World


def even(world):
    """The radiance of a world that is the same everywhere, or `None`."""
    if world is None:
        return (0, 0, 0)
    if not world.use_nodes:
        return tuple(world.color)
    output = next((n for n in world.node_tree.nodes if n.type == "OUTPUT_WORLD" and n.is_active_output), None)
    if output is None or not output.inputs["Surface"].is_linked:
        return (0, 0, 0)
    node = output.inputs["Surface"].links[0].from_node
    if node.type != "BACKGROUND" or any(i.is_linked for i in node.inputs):
        return None
    return tuple(c * node.inputs["Strength"].default_value for c in node.inputs["Color"].default_value[:3])


def bake(world, path, width):
    """All directions of a world as a picture, drawn by Cycles without anything before it."""
    scene = bpy.data.scenes.new("sky")
    scene.world = world
    camera = bpy.data.objects.new("sky", bpy.data.cameras.new("sky"))
    scene.collection.objects.link(camera)
    # Looking along Blender's +x, z up: what lies there is the middle of the picture.
    camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    scene.camera = camera
    camera.data.type = "PANO"
    # Blender 5 has it in the camera, before it was one of Cycles' settings.
    holder = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    holder.panorama_type = "EQUIRECTANGULAR"
    settings = scene.render
    settings.engine, settings.filepath = "CYCLES", str(path)
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = width, width // 2, 100
    kind = settings.image_settings
    kind.file_format, kind.color_mode, kind.color_depth, kind.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"
    scene.view_settings.view_transform = "Raw"
    scene.cycles.device, scene.cycles.samples = "CPU", 16
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    bpy.ops.render.render(scene=scene.name, write_still=True)
    bpy.data.objects.remove(camera)
    bpy.data.scenes.remove(scene)


def sky(world, path, width):
    """Options that give the world."""
    radiance = even(world)
    if radiance is None:
        bake(world, path, width)
        return ["--env", str(path)]
    return ["--env", ",".join(f"{c:.6g}" for c in radiance)] if any(radiance) else []


# Picture


def picture(scene, lossless):
    """Options that give camera, size and look."""
    camera, settings, view = scene.camera, scene.render, scene.view_settings
    percent = settings.resolution_percentage / 100
    options = ["--camera", camera.name]
    options += ["--width", str(round(settings.resolution_x * percent)), "--height", str(round(settings.resolution_y * percent))]
    data = camera.data
    if data.shift_x or data.shift_y:
        warn(f"{camera.name}: its shift is lost")
    if settings.pixel_aspect_x != settings.pixel_aspect_y:
        warn("pixels that are not square are drawn as squares")
    if data.dof.use_dof and data.type == "PERSP":
        focus = data.dof.focus_distance
        if data.dof.focus_object:
            away = data.dof.focus_object.matrix_world.translation - camera.matrix_world.translation
            focus = abs(away.dot(camera.matrix_world.col[2].xyz.normalized()))
        radius = data.lens / 1000 / (2 * data.dof.aperture_fstop)
        options += ["--aperture", f"{radius:.6g}", "--focus", f"{focus:.6g}"]
    if settings.film_transparent:
        options += ["--transparent"]
    if lossless:
        return options
    exposure = view.exposure + math.log2(max(scene.cycles.film_exposure, 1e-6))
    if exposure:
        options += ["--exposure", f"{exposure:.6g}"]
    if view.view_transform not in VIEWS:
        warn(f'the view transform "{view.view_transform}" is drawn as "Standard"')
    if view.look != "None" or view.gamma != 1 or view.use_curve_mapping:
        warn("look, gamma and curves of the colour management are lost")
    return options + ["--view", VIEWS.get(view.view_transform, "standard")]


def without(options, given):
    """Those that the command line does not give itself."""
    names, kept, i = {a.split("=")[0] for a in given}, [], 0
    while i < len(options):
        end = next((j for j in range(i + 1, len(options)) if options[j].startswith("--")), len(options))
        if options[i] not in names:
            kept += options[i:end]
        i = end
    return kept


def outputs(given):
    """Names after -o."""
    return [b for a, b in zip(given, given[1:]) if a in ("-o", "--output")] + [a[2:] for a in given if a[:2] == "-o" and a[2:]]


def main():
    ours, given = arguments()
    # As a module of Python: the file comes before `--`, by our own hand.
    if not bpy.app.binary_path and len(sys.argv) > 1 and sys.argv[1].endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(sys.argv[1]))
    scene = bpy.context.scene
    if ours.frame is not None:
        scene.frame_set(ours.frame)
    if scene.camera is None:
        raise Wrong("the scene has no active camera")
    if not ours.export_only and not outputs(given):
        raise Wrong("-o FILE is missing after --")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(ours.export or pathlib.Path(folder) / "scene.glb").absolute()
        lossless = not ours.export_only and all(o.endswith(".exr") for o in outputs(given))
        options = picture(scene, lossless)
        options += sky(scene.world, path.with_suffix(".sky.exr"), ours.sky_width)
        if replace_lamps():
            options += ["--light-units", "standard"]
        how = {"export_format": "GLB", "export_cameras": True, "export_lights": True, "export_extras": True}
        how |= {"export_animations": False, "export_apply": True, "use_renderable": True}
        bpy.ops.export_scene.gltf(filepath=str(path), **how)
        command = [ours.render, "image", str(path), *without(options, given), *given]
        if ours.export:
            print(shlex.join(command), flush=True)
        return 0 if ours.export_only else subprocess.run(command).returncode


try:
    code = main()
except (Wrong, OSError, RuntimeError) as error:
    warn(str(error).strip().splitlines()[-1])
    code = 2
# Blender goes on after a script that ends.
sys.stdout.flush()
sys.stderr.flush()
os._exit(code)
