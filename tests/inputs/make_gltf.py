#!/usr/bin/env python3
"""Writes the glTF files of gltf-area-lamp, gltf-skin, gltf-instances, gltf-quantized, gltf-animation and gltf-left-out, valid and
invalid: python3 make_gltf.py

A glowing square from (-1, -1) to (1, 1), seen from z = 5 by a camera of four by four units."""
import base64
import json
import pathlib
import struct

HERE = pathlib.Path(__file__).parent
FORMATS = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


class File:
    """A glTF file with the square as mesh 0 and the camera as node 0."""

    def __init__(self, corners=CORNERS, format="f", normalized=False):
        self.data = b""
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"camera": 0, "translation": [0, 0, 5]}],
            "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 0.1, "zfar": 100}}],
            "materials": [{"emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}],
            "accessors": [],
            "bufferViews": [],
        }
        positions = self.accessor(corners, format, normalized)
        indices = self.accessor([0, 1, 2, 0, 2, 3], "H")
        self.primitive = {"attributes": {"POSITION": positions}, "indices": indices, "material": 0}
        self.json["meshes"] = [{"primitives": [self.primitive]}]

    def accessor(self, rows, format="f", normalized=False):
        """Appends numbers or rows of numbers; rows start at multiples of four bytes."""
        rows = [row if isinstance(row, (tuple, list)) else (row,) for row in rows]
        size = struct.calcsize(format) * len(rows[0])
        stride = size if len(rows[0]) == 1 else -(-size // 4) * 4
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": stride * len(rows)}
        if stride != size:
            view["byteStride"] = stride
        self.data += b"".join(struct.pack(f"<{len(r)}{format}", *r).ljust(stride, b"\0") for r in rows)
        self.data = self.data.ljust(-(-len(self.data) // 4) * 4, b"\0")
        self.json["bufferViews"].append(view)
        accessor = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": FORMATS[format],
                    "count": len(rows), "type": TYPES[len(rows[0])]}
        if normalized:
            accessor["normalized"] = True
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def node(self, parent=None, **fields):
        """Appends a node, to the scene or to a parent."""
        nodes = self.json["nodes"]
        nodes.append(fields)
        above = self.json["scenes"][0]["nodes"] if parent is None else nodes[parent].setdefault("children", [])
        above.append(len(nodes) - 1)
        return len(nodes) - 1

    def skin(self, joints, inverse=None):
        skin = {"joints": joints}
        if inverse:
            skin["inverseBindMatrices"] = self.accessor(inverse)
        self.json.setdefault("skins", []).append(skin)
        return len(self.json["skins"]) - 1

    def animation(self, *channels):
        """Appends an animation; a channel is node, path, times, accessor of values, and the interpolation."""
        animation = {"channels": [], "samplers": []}
        for node, path, times, output, interpolation in channels:
            target = {"sampler": len(animation["samplers"]), "target": {"node": node, "path": path}}
            animation["channels"].append(target)
            sampler = {"input": self.accessor(times), "output": output, "interpolation": interpolation}
            animation["samplers"].append(sampler)
        self.json.setdefault("animations", []).append(animation)

    def weights(self, rows, set=0, joints="B", weights="f", scale=1):
        """Joints and weights of the four corners, each a list of pairs."""
        pad = lambda values: tuple(values) + (0,) * (4 - len(values))
        attributes = self.primitive["attributes"]
        attributes[f"JOINTS_{set}"] = self.accessor([pad([j for j, _ in row]) for row in rows], joints)
        rows = [pad([w * scale for _, w in row]) for row in rows]
        attributes[f"WEIGHTS_{set}"] = self.accessor(rows, weights, weights != "f")

    def write(self, name):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        path = HERE / name
        path.parent.mkdir(exist_ok=True)
        buffers = [{"byteLength": len(self.data), "uri": uri}]
        path.write_text(json.dumps(self.json | {"buffers": buffers}, separators=(",", ":")) + "\n")


def scale(s):
    return (s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, 0, 0, 0, 1)


def one_joint(name, mesh={}, joint={}, rows=[[(0, 1)]] * 4, inverse=None, **types):
    file = File()
    file.weights(rows, **types)
    file.node(mesh=0, skin=file.skin([file.node(**joint)], inverse), **mesh)
    file.write(name)


def skins():
    right = {"translation": [1, 0, 0]}
    one_joint("valid/gltf-skin/moved.gltf", {"translation": [-1, 0, 0]}, right)
    one_joint("valid/gltf-skin/mirrored_node.gltf", {"scale": [-1, 1, 1]}, right)
    one_joint("valid/gltf-skin/flat_node.gltf", {"scale": [0, 0, 0]}, right)
    one_joint("valid/gltf-skin/mirrored_joint.gltf", joint={"scale": [-1, 1, 1], **right})
    named = {"EXT_mesh_gpu_instancing": {"attributes": {}}}
    one_joint("valid/gltf-skin/instances.gltf", {"extensions": named}, right)
    one_joint("valid/gltf-skin/no_weights.gltf", joint=right, rows=[[(0, 0)]] * 4)
    # A joint that is not there, with weight zero.
    one_joint("valid/gltf-skin/spare_joint.gltf", joint=right, rows=[[(0, 1), (9, 0)]] * 4)

    file = File()
    file.weights([[(0, 1)]] * 4)
    rig = file.node(scale=[0.01] * 3, rotation=[0.5 ** 0.5, 0, 0, 0.5 ** 0.5])
    joint = file.node(rig, rotation=[-(0.5 ** 0.5), 0, 0, 0.5 ** 0.5], translation=[100, 0, 0])
    file.node(rig, mesh=0, skin=file.skin([joint], [scale(100)]))
    file.write("valid/gltf-skin/rig_in_centimetres.gltf")

    # The left corners follow joint 0, the right ones both alike, and joint 1 is a unit to the right.
    left, both = [(0, 1)], [(0, 1), (1, 1)]
    for joints, weights, unit in [("B", "f", 0.3), ("H", "B", 255), ("B", "H", 65535)]:
        file = File()
        file.weights([left, both, both, left], joints=joints, weights=weights, scale=unit)
        file.node(mesh=0, skin=file.skin([file.node(), file.node(**right)], [scale(1)] * 2))
        file.write(f"valid/gltf-skin/weights_{joints}_{weights}.gltf".lower().replace("_h", "_16").replace("_b", "_8"))

    file = File()
    file.weights([[(0, 0.5)]] * 4)
    file.weights([[(1, 0.25), (2, 0.25)]] * 4, set=1)
    file.node(mesh=0, skin=file.skin([file.node(), file.node(**right), file.node(translation=[3, 0, 0])]))
    file.write("valid/gltf-skin/eight_joints.gltf")

    file = File()
    file.weights([[(0, 1)]] * 4)
    file.primitive["targets"] = [{"POSITION": file.accessor([(1, 0, 0)] * 4)}]
    joint = file.node(rotation=[0, 0, 0.5 ** 0.5, 0.5 ** 0.5])
    file.node(mesh=0, skin=file.skin([joint]), weights=[1])
    file.write("valid/gltf-skin/morph_first.gltf")

    file = File()
    file.weights([[(0, 1)]] * 4)
    for x in (-1, 1):
        joint = file.node(translation=[x, 0, 0])
        file.node(mesh=0, skin=file.skin([joint]))
    file.write("valid/gltf-skin/two_skins.gltf")

    file = File()
    file.node(mesh=0, skin=file.skin([file.node()]), **right)
    file.write("valid/gltf-skin/no_joints.gltf")

    one_joint("invalid/gltf-skin/joint_out_of_range.gltf", rows=[[(0, 1)], [(7, 1)]] * 2)
    one_joint("invalid/gltf-skin/not_finite.gltf", rows=[[(0, float("nan"))]] * 4)
    file = File()
    file.weights([[(0, 1)]] * 4)
    file.node(mesh=0, skin=file.skin([file.node(), file.node()], [scale(1)]))
    file.write("invalid/gltf-skin/too_few_matrices.gltf")
    file = File()
    file.weights([[(0, 1)]] * 4)
    del file.primitive["attributes"]["WEIGHTS_0"]
    file.node(mesh=0, skin=file.skin([file.node()]))
    file.write("invalid/gltf-skin/joints_without_weights.gltf")


def instanced(name, fields={}, node={}, **attributes):
    file = File()
    named = {key: file.accessor(*rows) for key, rows in attributes.items()}
    extension = {"EXT_mesh_gpu_instancing": {"attributes": named} | fields}
    file.json |= {"extensionsUsed": list(extension), "extensionsRequired": list(extension)}
    file.node(mesh=0, extensions=extension, **node)
    file.write(name)
    return file


def instances():
    half = 0.5 ** 0.5
    sides = ([(-1, 0, 0), (1, 0, 0)],)
    instanced("valid/gltf-instances/moved.gltf", TRANSLATION=sides, SCALE=([(0.5, 0.5, 0.5)] * 2,))
    instanced("valid/gltf-instances/scaled.gltf", node={"translation": [1, 0, 0]}, SCALE=([(0.5, 0.5, 1), (1, 0, 1)],))
    # A quarter turn, in bytes, inside a node that is scaled along x.
    turned = [(0, 0, 90, 90)]
    instanced("valid/gltf-instances/turned.gltf", node={"scale": [0.5, 1, 1]}, ROTATION=(turned, "b", True),
              SCALE=([(0.5, 2, 1)],))
    instanced("valid/gltf-instances/own_attributes.gltf", TRANSLATION=([(1, 0, 0)],), _ID=([7], "H"))
    instanced("valid/gltf-instances/no_attributes.gltf", node={"translation": [1, 0, 0]})

    # Grey squares that a sun lights from the camera: 1/pi of its irradiance times the reflectance.
    file = File()
    file.json["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1},
                               "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}]
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": file.accessor(*sides)}}}
    file.json["extensionsUsed"] = ["EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_materials_specular"]
    file.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 683 * 3.14159265}]}}
    file.node(mesh=0, extensions=extension)
    file.node(extensions={"KHR_lights_punctual": {"light": 0}})
    file.write("valid/gltf-instances/lit.gltf")

    instanced("invalid/gltf-instances/lengths.gltf", TRANSLATION=sides, SCALE=([(1, 1, 1)],))
    instanced("invalid/gltf-instances/no_accessor.gltf", fields={"attributes": {"TRANSLATION": 9}})
    instanced("invalid/gltf-instances/not_finite.gltf", TRANSLATION=([(0, 0, 0), (float("inf"), 0, 0)],))
    instanced("invalid/gltf-instances/not_vectors.gltf", TRANSLATION=([1, 2],))


def quantized(name, unit, format, normalized, **node):
    file = File([tuple(unit * x for x in corner) for corner in CORNERS], format, normalized)
    file.json |= {"extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]}
    file.node(mesh=0, **node)
    file.write(name)


def quantization():
    right = {"translation": [1, 0, 0]}
    quantized("valid/gltf-quantized/bytes.gltf", 1, "b", False, **right)
    quantized("valid/gltf-quantized/shorts.gltf", 1000, "h", False, scale=[0.001] * 3, **right)
    quantized("valid/gltf-quantized/normalized_bytes.gltf", 127, "b", True, **right)
    quantized("valid/gltf-quantized/normalized_shorts.gltf", 32767, "h", True, **right)

    # Everything in integers, the coordinates beyond one.
    file = File([tuple(100 * x for x in corner) for corner in CORNERS], "b")
    file.json |= {"extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]}
    target = {"POSITION": file.accessor([(100, 0, 0)] * 4, "b"), "NORMAL": file.accessor([(0, 0, 0)] * 4, "b", True)}
    file.primitive["targets"] = [target]
    file.primitive["attributes"]["NORMAL"] = file.accessor([(0, 0, 127)] * 4, "b", True)
    file.primitive["attributes"]["TANGENT"] = file.accessor([(127, 0, 0, 127)] * 4, "b", True)
    file.primitive["attributes"]["TEXCOORD_0"] = file.accessor([(0, 0), (9, 0), (9, 9), (0, 9)], "H")
    file.node(mesh=0, weights=[1], scale=[0.01] * 3)
    file.write("valid/gltf-quantized/morphed.gltf")

    file = File([tuple(100 * x for x in corner) for corner in CORNERS], "h")
    file.json |= {"extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]}
    file.weights([[(0, 1)]] * 4, weights="B", scale=255)
    file.node(mesh=0, skin=file.skin([file.node(**right)], [scale(0.01)]))
    file.write("valid/gltf-quantized/skinned.gltf")


def animations():
    x = lambda *values: [(value, 0, 0) for value in values]
    valid, invalid = "valid/gltf-animation/", "invalid/gltf-animation/"

    def square(**fields):
        file = File()
        return file, file.node(mesh=0, **fields)

    file, node = square()
    file.animation((node, "translation", [0, 1], file.accessor(x(-1, 1)), "LINEAR"))
    file.write(valid + "linear.gltf")
    file, node = square()
    file.animation((node, "translation", [0, 5 / 24, 7 / 24], file.accessor(x(-1, 1, 0)), "STEP"))
    file.write(valid + "step.gltf")
    file, node = square()
    file.animation((node, "translation", [1, 3], file.accessor(x(0, 0, 2, -2, 0, 0)), "CUBICSPLINE"))
    file.write(valid + "spline.gltf")

    # The values are zero but for the one at the end.
    file, node = square()
    file.accessor([1], "B")
    file.accessor(x(1))
    values, indices = (file.json["accessors"].pop()["bufferView"] for _ in range(2))
    file.json["accessors"].append({"componentType": 5126, "count": 2, "type": "VEC3", "sparse": {
        "count": 1, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}}})
    file.animation((node, "translation", [0, 1], len(file.json["accessors"]) - 1, "LINEAR"))
    file.write(valid + "sparse.gltf")

    # A joint, the square one unit to its right, turns by half a turn; in normalised shorts.
    file = File([(a + 1, b, c) for a, b, c in CORNERS])
    file.weights([[(0, 1)]] * 4)
    joint = file.node()
    file.node(mesh=0, skin=file.skin([joint]))
    turn = file.accessor([(0, 0, 0, 32767), (0, 0, -32767, 0)], "h", True)
    file.animation((joint, "rotation", [0, 1], turn, "LINEAR"))
    file.write(valid + "turned_joint.gltf")

    # Two targets, one unit to the right and two; in normalised bytes.
    file, node = square()
    file.primitive["targets"] = [{"POSITION": file.accessor([(d, 0, 0)] * 4)} for d in (1, 2)]
    weights = file.accessor([0, 0, 0, 255], "B", True)
    file.animation((node, "weights", [0, 1], weights, "LINEAR"))
    file.write(valid + "weights.gltf")

    file, node = square()
    file.animation((0, "translation", [0, 1], file.accessor([(0, 0, 5), (-2, 0, 5)]), "LINEAR"))
    file.write(valid + "camera.gltf")

    # Two animations: the second one moves the square, too, and halves its height.
    file, node = square()
    file.animation((node, "translation", [0, 1], file.accessor(x(-1, 1)), "LINEAR"))
    file.animation((node, "translation", [0, 1], file.accessor(x(0, 0)), "LINEAR"),
                   (node, "scale", [0, 1], file.accessor([(1, 1, 1), (1, 0.5, 1)]), "LINEAR"))
    file.json["animations"][1]["channels"].append({"sampler": 0, "target": {"path": "pointer"}})
    file.write(valid + "two.gltf")

    # A node with a matrix, which a translation replaces in part.
    file, node = square(matrix=[0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1])
    file.animation((node, "translation", [0], file.accessor(x(1)), "LINEAR"))
    file.write(valid + "matrix.gltf")

    file, node = square()
    file.write(valid + "nothing_moves.gltf")

    for name, node, times, values in [("backwards", 1, [1, 0], x(0, 1)), ("too_few", 1, [0, 1, 2], x(0, 1)),
                                      ("no_node", 7, [0, 1], x(0, 1)), ("not_a_time", 1, [0, float("nan")], x(0, 1))]:
        file, _ = square()
        file.animation((node, "translation", times, file.accessor(values), "LINEAR"))
        file.write(invalid + name + ".gltf")
    file, node = square()
    file.animation((node, "translation", [0, 1], file.accessor(x(0, 1)), "LINEAR"))
    file.json["animations"][0]["channels"][0]["sampler"] = 3
    file.write(invalid + "no_sampler.gltf")
    file.json["animations"][0]["channels"][0]["sampler"] = 0
    file.json["animations"][0]["samplers"][0]["output"] = 99
    file.write(invalid + "no_accessor.gltf")


def left_out():
    def extended(name, extension, required, **places):
        """`places`: lists of the file and what stands there in the extension's name."""
        file = File()
        file.node(mesh=0, translation=[1, 0, 0])
        file.json["extensionsUsed"] = [extension]
        if required:
            file.json["extensionsRequired"] = [extension]
        for place, value in places.items():
            where = file.primitive if place == "primitive" else file.json[place][0]
            where["extensions"] = {extension: value}
        return file, name

    draco, meshopt = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
    compressed = {"bufferView": 0, "attributes": {"POSITION": 0}}
    file, name = extended("valid/gltf-left-out/draco_and_plain.gltf", draco, False, primitive=compressed)
    file.write(name)
    file, name = extended("invalid/gltf-left-out/draco_required.gltf", draco, True, primitive=compressed)
    file.write(name)
    file, name = extended("invalid/gltf-left-out/draco_alone.gltf", draco, False, primitive=compressed)
    del file.json["accessors"][0]["bufferView"]
    file.write(name)
    file, name = extended("invalid/gltf-left-out/meshopt_required.gltf", meshopt, True)
    file.write(name)
    file, name = extended("valid/gltf-left-out/sky.gltf", "EXT_lights_image_based", True, scenes={"light": 0})
    file.write(name)
    file, name = extended("invalid/gltf-left-out/sky_not_required.gltf", "EXT_lights_image_based", False, scenes={"light": 0})
    file.write(name)

    file = File()
    hidden = file.node(extensions={"KHR_node_visibility": {"visible": False}})
    file.node(hidden, mesh=0)
    file.node(mesh=0, translation=[1, 0, 0], extensions={"KHR_node_visibility": {"visible": True}})
    file.json |= {"extensionsUsed": ["KHR_node_visibility"], "extensionsRequired": ["KHR_node_visibility"]}
    file.write("valid/gltf-left-out/hidden.gltf")

    # A morph target without data moves nothing.
    file = File()
    file.json["accessors"].append({"componentType": 5126, "count": 4, "type": "VEC3"})
    file.primitive["targets"] = [{"POSITION": len(file.json["accessors"]) - 1}]
    file.node(mesh=0, weights=[1], translation=[1, 0, 0])
    file.write("valid/gltf-morph/zeros.gltf")


def area_lamps():
    """A lamp as Blender has them before a large white wall, one unit behind; it shines on the wall or on the camera."""
    for name, turn, extras in [
        ("away", (0, 1, 0, 0), {"area_lamp": True}),
        ("towards", (0, 0, 0, 1), {"area_lamp": 1}),
        ("hidden", (0, 0, 0, 1), {"area_lamp": True, "hidden_from_camera": True}),
        ("hidden_away", (0, 1, 0, 0), {"area_lamp": True, "hidden_from_camera": True}),
        ("plain", (0, 1, 0, 0), {"area_lamp": False, "hidden_from_camera": True}),
    ]:
        file = File()
        file.json["asset"]["generator"] = "Khronos glTF Blender I/O v4.5.49"
        file.json["materials"][0] |= {"extras": extras, "doubleSided": True}
        specular = {"KHR_materials_specular": {"specularFactor": 0}}
        white = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}, "extensions": specular}
        file.json["materials"].append(white)
        file.json["extensionsUsed"] = ["KHR_materials_specular"]
        file.json["meshes"].append({"primitives": [file.primitive | {"material": 1}]})
        file.node(mesh=0, rotation=list(turn))
        file.node(mesh=1, scale=[4, 4, 1], translation=[0, 0, -1])
        file.write(f"valid/gltf-area-lamp/{name}.gltf")


if __name__ == "__main__":
    area_lamps()
    skins()
    instances()
    animations()
    left_out()
    quantization()
