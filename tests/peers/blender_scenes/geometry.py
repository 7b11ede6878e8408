"""Meshes and what makes them: shading, modifiers, parents, copies, skins, shape keys, curves and text."""

import bpy
from mathutils import Matrix

from .kit import ball, cube, last, material, place, plane, scene, stage


def orange():
    return material("orange", Base_Color=(0.8, 0.35, 0.1), Roughness=0.5)


def blue():
    return material("blue", Base_Color=(0.1, 0.3, 0.8), Roughness=0.5)


@scene()
def several_materials():
    stage()
    of = cube(orange())
    of.data.materials.append(blue())
    of.data.materials.append(material("metal", Metallic=1.0, Roughness=0.3))
    for i, polygon in enumerate(of.data.polygons):
        polygon.material_index = i % 3


@scene()
def shaded_flat():
    stage()
    ball(orange(), smooth=False)


@scene()
def shaded_smooth_of_few_faces():
    stage()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=1)
    last(orange(), (0, 0, 1), smooth=True)


@scene()
def shaded_smooth_by_angle():
    stage()
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.8, depth=1.6)
    of = last(orange(), (0, 0, 1), turn=(30, 20, 0), smooth=True)
    for edge in of.data.edges:
        edge.use_edge_sharp = (
            abs(of.data.vertices[edge.vertices[0]].co.z - of.data.vertices[edge.vertices[1]].co.z) < 0.1
        )


@scene()
def custom_normals():
    stage()
    of = plane(orange(), at=(0, 0, 1), turn=(60, 0, 0))
    of.data.normals_split_custom_set([(0.3, 0.1, 0.95)] * 4)


@scene()
def faces_of_many_corners():
    stage()
    bpy.ops.mesh.primitive_circle_add(vertices=9, radius=1, fill_type="NGON")
    of = last(orange(), (0, 0, 1.1), turn=(80, 0, 0))
    for i, v in enumerate(of.data.vertices):
        v.co *= 1.0 if i % 2 else 0.45


@scene()
def modifier_subdivision():
    stage()
    cube(orange(), smooth=True).modifiers.new("s", "SUBSURF").levels = 2
    bpy.context.object.modifiers["s"].render_levels = 2


@scene()
def modifier_array_and_mirror():
    stage()
    of = cube(orange(), size=0.4, at=(0, 0, 0.3))
    of.data.transform(Matrix.Translation((0.4, 0, 0)))
    array = of.modifiers.new("a", "ARRAY")
    array.count, array.use_relative_offset, array.use_constant_offset = 3, False, True
    array.constant_offset_displace = (0.3, 0.2, 0.5)
    of.modifiers.new("m", "MIRROR").use_axis = (True, False, False)


@scene()
def modifier_bevel_and_solidify():
    stage()
    of = plane(blue(), at=(0, 0, 1), turn=(30, 40, 0))
    of.modifiers.new("s", "SOLIDIFY").thickness = 0.4
    bevel = of.modifiers.new("b", "BEVEL")
    bevel.width, bevel.segments = 0.1, 3


@scene(export={"export_apply": False}, differs="without Apply Modifiers the exporter leaves them out")
def modifier_not_applied():
    stage()
    of = cube(orange(), size=0.5, at=(-1, 0, 0.5))
    of.modifiers.new("a", "ARRAY").count = 4


@scene()
def geometry_nodes_instances():
    stage()
    group = bpy.data.node_groups.new("points", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    new, join = group.nodes.new, group.links.new
    source, out, on = new("NodeGroupInput"), new("NodeGroupOutput"), new("GeometryNodeInstanceOnPoints")
    form, made, real = (
        new("GeometryNodeMeshUVSphere"),
        new("GeometryNodeSetMaterial"),
        new("GeometryNodeRealizeInstances"),
    )
    form.inputs["Radius"].default_value = 0.35
    made.inputs["Material"].default_value = orange()
    join(source.outputs[0], on.inputs["Points"])
    join(form.outputs[0], made.inputs[0])
    join(made.outputs[0], on.inputs["Instance"])
    join(on.outputs[0], real.inputs[0])
    join(real.outputs[0], out.inputs[0])
    cube(at=(0, 0, 1), size=1.2).modifiers.new("n", "NODES").node_group = group


def collection():
    """A collection of a ball and a cube that is not in the scene itself."""
    made = bpy.data.collections.new("pair")
    for of in (ball(orange(), at=(0, 0, 0.4), radius=0.4), cube(blue(), at=(0.5, 0.3, 0.2), size=0.4)):
        for user in list(of.users_collection):
            user.objects.unlink(of)
        made.objects.link(of)
    return made


def instances(made):
    for i in range(3):
        empty = place(
            None, at=(i - 1.2, 0.5 * i - 0.5, 0.1 * i), turn=(0, 0, 50 * i), scale=(1, 1, 1 + 0.4 * i), name=f"e{i}"
        )
        empty.instance_type, empty.instance_collection = "COLLECTION", made


@scene()
def collection_instances():
    stage()
    instances(collection())


@scene(export={"export_gpu_instances": True})
def collection_instances_on_the_gpu():
    stage()
    instances(collection())


@scene()
def linked_copies():
    stage()
    of = ball(orange(), at=(-1.2, 0, 0.5), radius=0.5)
    place(bpy.data.objects.new("b", of.data), at=(0, 0, 0.8), scale=(1.2, 0.6, 1.6))
    place(bpy.data.objects.new("c", of.data), at=(1.2, 0.4, 0.6), turn=(0, 40, 0), scale=(1, 1, 0.5))


@scene(export={"export_gpu_instances": True})
def linked_copies_on_the_gpu():
    stage()
    of = cube(blue(), at=(-1.2, 0, 0.5), size=0.8)
    for i in range(4):
        place(
            bpy.data.objects.new(f"b{i}", of.data),
            at=(0.9 * i - 0.6, 0.3 * i, 0.5 + 0.2 * i),
            turn=(10 * i, 20 * i, 0),
            scale=(1, 0.5 + 0.2 * i, 1),
        )


@scene()
def copy_with_its_own_material():
    stage()
    of = ball(orange(), at=(-0.8, 0, 0.6), radius=0.6)
    other = place(bpy.data.objects.new("b", of.data), at=(0.8, 0, 0.6))
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = blue()


@scene()
def parents_uneven():
    """A turned child of a stretched parent is sheared."""
    stage()
    above = place(None, at=(0, 0, 0.8), turn=(0, 0, 20), scale=(2, 0.7, 1), name="above")
    of = cube(orange(), at=(0, 0, 0), size=0.8, turn=(0, 0, 40))
    of.parent = above


@scene()
def parent_inverse():
    stage()
    above = place(None, at=(1, 1, 1), turn=(0, 30, 0), scale=(1.5, 1.5, 1.5), name="above")
    of = cube(orange(), at=(0, 0, 0.8), size=1.2)
    of.parent, of.matrix_parent_inverse = above, Matrix.Translation((-0.5, -0.5, -0.6))


@scene()
def scale_negative():
    stage()
    bpy.ops.mesh.primitive_monkey_add(size=1.6)
    last(orange(), (0, 0, 1), scale=(-1, 1, 1), turn=(0, 0, 25), smooth=True)


@scene()
def normals_inside_out():
    stage()
    cube(orange()).data.flip_normals()


def bend():
    """A column on a chain of bones."""
    stage()
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.35, depth=2.0)
    of = last(orange(), (0, 0, 1), smooth=True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=6)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.armature_add(location=(0, 0, 0))
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    first = rig.data.edit_bones[0]
    first.head, first.tail, first.name = (0, 0, 0), (0, 0, 1), "low"
    high = rig.data.edit_bones.new("high")
    high.head, high.tail, high.parent, high.use_connect = (0, 0, 1), (0, 0, 2), first, True
    bpy.ops.object.mode_set(mode="OBJECT")
    for name in ("low", "high"):
        group = of.vertex_groups.new(name=name)
        for v in of.data.vertices:
            share = min(max(v.co.z + 0.5, 0), 1)
            group.add([v.index], share if name == "high" else 1 - share, "REPLACE")
    of.parent = rig
    of.modifiers.new("rig", "ARMATURE").object = rig
    return rig


@scene(export={"export_apply": False, "export_rest_position_armature": False})
def skin_posed():
    rig = bend()
    rig.pose.bones["high"].rotation_mode = "XYZ"
    rig.pose.bones["high"].rotation_euler = (0, 0, 0.9)
    rig.pose.bones["low"].rotation_mode = "XYZ"
    rig.pose.bones["low"].rotation_euler = (0.3, 0, 0)


@scene(export={"export_apply": False, "export_rest_position_armature": False})
def skin_posed_and_scaled():
    rig = bend()
    rig.scale, rig.location = (0.7, 0.7, 0.7), (0.3, 0, 0)
    rig.pose.bones["high"].scale = (1.6, 1, 0.6)
    rig.pose.bones["high"].location = (0, 0.3, 0)


@scene(differs="Use Rest Position Armature, the exporter's default: without animations the pose is not in the file")
def skin_at_rest():
    rig = bend()
    rig.pose.bones["high"].rotation_mode = "XYZ"
    rig.pose.bones["high"].rotation_euler = (0, 0, 0.9)


def shapes():
    stage()
    of = ball(orange())
    of.shape_key_add(name="Basis")
    wide, tall = of.shape_key_add(name="wide"), of.shape_key_add(name="tall")
    for i, v in enumerate(of.data.vertices):
        wide.data[i].co = (1.7 * v.co.x, v.co.y, v.co.z)
        tall.data[i].co = (v.co.x, v.co.y, v.co.z + 0.8 * max(v.co.z, 0))
    return of, wide, tall


@scene(export={"export_apply": False})
def shape_keys():
    _, wide, tall = shapes()
    wide.value, tall.value = 0.7, 0.5


@scene(export={"export_apply": False, "export_try_sparse_sk": True, "export_try_omit_sparse_sk": True})
def shape_keys_sparse():
    of, wide, tall = shapes()
    for i, v in enumerate(of.data.vertices):
        wide.data[i].co = v.co * (1 + 0.6 * max(v.co.x - 0.2, 0))
    wide.value = 1.0


@scene()
def text():
    stage()
    data = bpy.data.curves.new("text", "FONT")
    data.body, data.extrude, data.size, data.align_x = "Bg8", 0.1, 1.4, "CENTER"
    data.materials.append(orange())
    place(data, at=(0, 0, 0.4), turn=(80, 0, 0))


@scene()
def curve_with_bevel():
    stage()
    bpy.ops.curve.primitive_bezier_circle_add(radius=1.0)
    bpy.context.object.data.bevel_depth = 0.2
    last(blue(), (0, 0, 1), turn=(70, 0, 0))


@scene(differs="the exporter drops metaballs")
def metaballs():
    stage()
    bpy.ops.object.metaball_add(type="BALL", radius=0.8)
    of = last(orange(), (0, 0, 0.9))
    element = of.data.elements.new()
    element.co, element.radius = (0.8, 0, 0.3), 0.7
    of.data.resolution = of.data.render_resolution = 0.1


@scene()
def loose_points_and_edges():
    stage()
    cube(orange())
    data = bpy.data.meshes.new("loose")
    data.from_pydata([(0, 0, 2), (1, 0, 2), (-1, 0, 1.5)], [(0, 1)], [])
    place(data)


@scene(export={"use_renderable": True})
def hidden_objects():
    """What is hidden in renders is exported only where the exporter is told so: Renderable Objects."""
    stage()
    cube(orange())
    ball(blue(), at=(1.2, -1, 0.5), radius=0.5).hide_render = True


@scene()
def far_from_the_origin():
    """Everything two kilometres away."""
    stage()
    cube(orange())
    for of in bpy.context.scene.objects:
        of.location.x += 2000


@scene()
def in_millimetres():
    """Everything a thousand times smaller."""
    stage()
    ball(orange())
    above = place(None, scale=(0.001,) * 3, name="above")
    for of in bpy.context.scene.objects:
        if of is not above:
            of.parent = above
    bpy.context.scene.camera.data.clip_start = 1e-5
