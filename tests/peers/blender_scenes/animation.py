"""Frames of animations: Blender's frame f is --frame f at the scene's frames per second."""

import bpy

from .geometry import bend, orange, shapes
from .kit import README, ball, cube, lamp, scene, stage

MOVES = {"export_animations": True, "export_apply": False}


def keyed(of, path, keys, index=-1, interpolation=None):
    """Keys of a property: frame and value."""
    for frame, value in keys:
        if index < 0:
            setattr(of, path, value)
        else:
            getattr(of, path)[index] = value
        of.keyframe_insert(path, frame=frame, index=index)
    if interpolation:
        holder = of.id_data if of.animation_data is None else of
        for curve in holder.animation_data.action.fcurves:
            for key in curve.keyframe_points:
                key.interpolation = interpolation


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def object_moves():
    stage()
    keyed(cube(orange(), size=1), "location", [(1, (-1.5, 0, 0.5)), (24, (1.5, 0.5, 1.2))])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def object_turns_and_grows():
    stage()
    of = cube(orange(), size=1)
    keyed(of, "rotation_euler", [(1, (0, 0, 0)), (24, (1.2, 0.5, 3))])
    keyed(of, "scale", [(1, (1, 1, 1)), (24, (2, 1, 0.5))])


@scene(export=MOVES, args=["--frame", "7"], frame=7)
def object_steps():
    stage()
    keyed(
        cube(orange(), size=1),
        "location",
        [(1, (-1, 0, 0.5)), (6, (1, 0, 0.5)), (12, (0, 1, 1))],
        interpolation="CONSTANT",
    )


@scene(export=MOVES, args=["--frame", "9"], frame=9)
def object_moves_evenly():
    stage()
    keyed(cube(orange(), size=1), "location", [(1, (-1.5, 0, 0.5)), (24, (1.5, 0.5, 1.2))], interpolation="LINEAR")


@scene(export=MOVES | {"export_force_sampling": False}, args=["--frame", "9"], frame=9)
def object_moves_by_curves_of_the_file():
    stage()
    keyed(cube(orange(), size=1), "location", [(1, (-1.5, 0, 0.5)), (24, (1.5, 0.5, 1.2))])


@scene(export=MOVES, args=["--frame", "15", "--fps", "30"], frame=15)
def thirty_frames_per_second():
    stage()
    bpy.context.scene.render.fps = 30
    keyed(cube(orange(), size=1), "location", [(1, (-1.5, 0, 0.5)), (30, (1.5, 0.5, 1.2))])


@scene(export=MOVES, args=["--frame", "110"], frame=110)
def starts_at_frame_a_hundred():
    stage()
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 100, 124
    keyed(cube(orange(), size=1), "location", [(100, (-1.5, 0, 0.5)), (124, (1.5, 0.5, 1.2))])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def parents_move():
    stage()
    above = cube(orange(), size=0.8)
    child = ball(at=(0, 0, 0.8), radius=0.4)
    child.parent = above
    keyed(above, "rotation_euler", [(1, (0, 0, 0)), (24, (0, 1.5, 0))])
    keyed(child, "location", [(1, (0, 0, 0.8)), (24, (0.8, 0, 0.8))])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def armature_moves():
    bone = bend().pose.bones["high"]
    bone.rotation_mode = "XYZ"
    keyed(bone, "rotation_euler", [(1, (0, 0, 0)), (24, (0, 0, 1.4))])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def shape_keys_move():
    _, wide, tall = shapes()
    keyed(wide, "value", [(1, 0.0), (24, 1.0)])
    keyed(tall, "value", [(1, 1.0), (24, 0.2)])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def camera_moves():
    stage()
    cube(orange())
    camera = bpy.context.scene.camera
    keyed(camera, "location", [(1, (0, -6, 3)), (24, (2.5, -5, 3))])
    keyed(camera, "rotation_euler", [(1, (1.2, 0, 0)), (24, (1.2, 0, 0.45))])


@scene(export=MOVES, args=["--frame", "12"], frame=12)
def lamp_moves():
    stage(lights=False)
    cube(orange())
    keyed(lamp("POINT", 400, at=(2, -2, 3)), "location", [(1, (2, -2, 3)), (24, (-2, -2, 2))])


@scene(export=MOVES, frame=1, warns=["animations are ignored"])
def first_frame_without_asking():
    """Without --frame the file is drawn as its nodes stand: at the frame that was exported."""
    stage()
    keyed(cube(orange(), size=1), "location", [(1, (-1.5, 0, 0.5)), (24, (1.5, 0.5, 1.2))])


def constrained():
    stage()
    goal = cube(orange(), size=0.8)
    keyed(goal, "location", [(1, (-1.5, 0, 0.4)), (24, (1.5, 0, 0.4))])
    follower = ball(at=(0, 0, 0.6), radius=0.4)
    constraint = follower.constraints.new("COPY_LOCATION")
    constraint.target, constraint.use_offset = goal, True


@scene(export=MOVES | {"export_bake_animation": True}, args=["--frame", "12"], frame=12)
def constraint_baked():
    constrained()


@scene(
    export=MOVES,
    args=["--frame", "12"],
    frame=12,
    differs="without Bake All Objects Animations what only constraints move stands still",
)
def constraint_not_baked():
    constrained()


@scene(export=README | {"export_apply": False}, args=["--frame", "12"], frame=12)
def as_the_readme_says_at_a_frame():
    bone = bend().pose.bones["high"]
    bone.rotation_mode = "XYZ"
    keyed(bone, "rotation_euler", [(1, (0, 0, 0)), (24, (0, 0, 1.4))])
    keyed(bpy.context.scene.camera, "location", [(1, (0, -6, 3)), (24, (1, -5.5, 3.5))])
    keyed(lamp("POINT", 200, at=(2, -2, 3)), "location", [(1, (2, -2, 3)), (24, (-2, -2, 2))])
