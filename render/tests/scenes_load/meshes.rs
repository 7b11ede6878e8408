//! Mesh formats, good, damaged and hostile.

use crate::{Folder, Loaded, error, scene};
use flate2::{Compression, write::ZlibEncoder};
use glam::{Vec2, Vec3};
use render::scene::{Geometry, Mesh};
use std::io::Write;

fn load(kind: &str, content: impl AsRef<[u8]>, parameters: &str) -> Loaded {
    let body = format!("<shape type='{kind}'><string name='filename' value='m.{kind}'/>{parameters}</shape>");
    Folder::new().with(&format!("m.{kind}"), content).scene(&body)
}

fn mesh(kind: &str, content: impl AsRef<[u8]>, parameters: &str) -> Mesh {
    let (scene, warnings) = load(kind, content, parameters).unwrap_or_else(|e| panic!("{e}"));
    assert!(warnings.is_empty(), "{warnings:?}");
    let Geometry::Mesh(mesh) = &scene.shapes[0].geometry else { panic!() };
    mesh.clone()
}

fn failure(kind: &str, content: impl AsRef<[u8]>) -> String {
    let e = load(kind, content, "").expect_err("an error is expected");
    assert!(e.starts_with(&format!("scene.xml:2:1: <shape type=\"{kind}\">: m.{kind}")), "{e}");
    e
}

const SQUARE: &str = "# a square\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nvn 0 0 1\n";

#[test]
fn obj_with_polygons_negative_indices_and_seams() {
    let m = mesh(
        "obj",
        format!("{SQUARE}o x\ng y\nusemtl z\ns off\nf 1/1/1 2/2/1 3/1/1 4/1/1\nf -4/1/1 -3/1/1 -2/1/1 # end\n"),
        "",
    );
    assert_eq!(m.triangles, [[0, 1, 2], [0, 2, 3], [0, 4, 2]]);
    // The texture's v is turned over, and corners with other coordinates are other vertices.
    assert_eq!(m.uvs, [Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.75), Vec2::Y, Vec2::Y, Vec2::Y]);
    assert_eq!(m.normals, [Vec3::Z; 5]);
    let kept = mesh("obj", format!("{SQUARE}f 1/1 2/2 3/1\n"), "<boolean name='flip_tex_coords' value='false'/>");
    assert_eq!(kept.uvs[1], Vec2::new(1.0, 0.25));
}

#[test]
fn obj_faces_with_and_without_attributes() {
    let faces = "f 4 1 3\nf 1/2/1 2/1/1 3//1\nf 2//1 3 1\n";
    let m = mesh("obj", SQUARE.replace("vt 0 0", "vt 0.5 # u") + faces, "");
    assert_eq!(m.triangles, [[0, 1, 2], [3, 4, 5], [6, 2, 1]]);
    // Zero where there are none; `v` of a single component is 0, at the bottom.
    let uvs = [Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, Vec2::new(1.0, 0.75), Vec2::new(0.5, 1.0), Vec2::ZERO, Vec2::ZERO];
    assert_eq!(m.uvs, uvs);
    assert_eq!(m.normals, [Vec3::Z; 7]);
    // Normals that are missing come from the faces, as in a file without any.
    let roof = "v 0 0 0\nv 1 0 -1\nv 1 1 -1\nv 0 1 0\nv -1 0 -1\nv -1 1 -1\nvn 0 1 1\nf 1 2 3 4\nf 1 4 6 5//1\n";
    let m = mesh("obj", roof, "");
    assert!((m.normals[0] - Vec3::Z).length() < 1e-6, "{}", m.normals[0]);
    assert!((m.normals[5] - Vec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-6);
}

#[test]
fn obj_errors_name_the_line() {
    for (line, what) in [
        ("f 1 2 9", "m.obj:9: vertex 9 is out of range: 4 given so far"),
        ("f 1 2 -5", "m.obj:9: vertex -5 is out of range"),
        ("f 1 2 0", "m.obj:9: vertex 0 is out of range"),
        ("f 1/7 2 3", "texture coordinate 7 is out of range"),
        ("f 1//2 2 3", "normal 2 is out of range"),
        ("f a b c", "`a` is not an index"),
        ("v 1 nan 2", "m.obj:9: vertex 5 lies at [1, NaN, 2]: not finite"),
        ("v 1 2", "expected 3 numbers, found 2"),
        ("v 1 2 x", "`x` is not a number"),
        ("vt # 1", "`#` is not a number"),
        ("v 1 2 3\rv 1 2\r\nv 3", "m.obj:10: expected 3 numbers, found 2"),
        ("v 1 2 1e30\nf 1 2 5", "vertex 2 lies at [1, 2, 1000000000000000000000000000000]"),
    ] {
        let e = failure("obj", format!("{SQUARE}{line}\n"));
        assert!(e.contains(what), "{e}");
    }
    assert!(failure("obj", b"v \xff 1 2\n").contains("m.obj:1: `\u{fffd}` is not a number"));
}

#[test]
fn missing_meshes_are_named() {
    let e = error("<shape type='obj'><string name='filename' value='gone.obj'/></shape>");
    assert!(e.starts_with("scene.xml:2:1: <shape type=\"obj\">: gone.obj: cannot read: "), "{e}");
    let e = error("<shape type='obj'><string name='filename' value='.'/></shape>");
    assert!(e.contains("not a file"), "{e}");
    let e = error("<shape type='obj'/>");
    assert!(e.ends_with("the parameter `filename` is missing"), "{e}");
    let (scene, warnings) = load("obj", "v 0 0 0\n", "").unwrap();
    assert!(scene.shapes.is_empty() && warnings[0].contains("no triangles"), "{warnings:?}");
}

#[test]
fn triangles_without_area_are_dropped_and_counted() {
    let (scene, warnings) = load("obj", format!("{SQUARE}f 1 2 3\nf 1 1 2\nf 1 3 1\n"), "").unwrap();
    assert_eq!(warnings, ["scene.xml:2:1: <shape type=\"obj\">: 2 triangles without area are not drawn"]);
    assert!(matches!(&scene.shapes[0].geometry, Geometry::Mesh(m) if m.triangles.len() == 1));
    let (_, warnings) = load("obj", format!("{SQUARE}f 1 2 3\nf 1 2\np 1\n"), "").unwrap();
    assert!(warnings[0].ends_with("1 faces of fewer than three corners are not drawn"), "{warnings:?}");
    assert!(warnings[1].ends_with("are not drawn: 1 `p`"), "{warnings:?}");
}

#[test]
fn normals_are_made_dropped_flipped_and_obeyed() {
    let roof = "v 0 0 0\nv 1 0 -1\nv 1 1 -1\nv 0 1 0\nv -1 0 -1\nv -1 1 -1\nf 1 2 3 4\nf 1 4 6 5\n";
    let smooth = mesh("obj", roof, "");
    assert!((smooth.normals[0] - Vec3::Z).length() < 1e-6, "{}", smooth.normals[0]);
    assert!(mesh("obj", roof, "<boolean name='face_normals' value='true'/>").normals.is_empty());
    let flipped = mesh("obj", roof, "<boolean name='flip_normals' value='true'/>");
    assert!((flipped.normals[0] + Vec3::Z).length() < 1e-6);
    assert_eq!(flipped.triangles[0], [0, 2, 1]);
    // The file's normals say which side is the front, against the winding.
    let turned = mesh("obj", format!("{SQUARE}f 3//1 2//1 1//1\n"), "");
    let [a, b, c] = turned.triangles[0].map(|i| turned.positions[i as usize]);
    assert!((b - a).cross(c - a).z > 0.0);
    // A mirror turns a mesh whose winding alone says which side is the front.
    let mirrored = mesh("obj", roof, "<transform name='to_world'><scale x='-1'/></transform>");
    assert!((mirrored.normals[0] + Vec3::Z).length() < 1e-6);
    // A normal of length zero takes its face's.
    let zero = mesh("obj", SQUARE.replace("vn 0 0 1", "vn 0 0 0") + "f 1//1 2//1 3//1\n", "");
    assert_eq!(zero.normals, [Vec3::Z; 3]);
}

const PLY_ASCII: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\n\
    property double z\nproperty uchar red\nproperty float s\nproperty float t\nelement face 1\n\
    property list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nend_header\n\
    0 0 0 9 0 0.25\n1 0 0 9 1 0\n1 1 0 9 1 1\n0 1 0 9 0 1\n4 0 1 2 3\n5\n";

/// The square with coordinates of its corners, one of which a second face contradicts.
const PLY_CORNERS: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 2\nproperty list uchar float texcoord\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n8 0 0 1 0 1 1 0 1 4 0 1 2 3\n6 .5 .5 1 1 1 0 3 0 2 1\n";

/// The mesh of `PLY_ASCII` in binary, numbers written by `f` (f32) and `i` (i32).
fn ply_binary(format: &str, f: fn(f32) -> [u8; 4], i: fn(i32) -> [u8; 4]) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
    )
    .into_bytes();
    for [x, y, u, v] in [[0., 0., 0., 0.25], [1., 0., 1., 0.], [1., 1., 1., 1.], [0., 1., 0., 1.]] {
        [x, y, 0.0, u, v].iter().for_each(|&n| out.extend(f(n)));
    }
    out.push(4);
    (0..4).for_each(|n| out.extend(i(n)));
    out
}

#[test]
fn ply_in_every_encoding() {
    let ascii = mesh("ply", PLY_ASCII, "");
    assert_eq!(ascii.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(ascii.uvs[0], Vec2::new(0.0, 0.25));
    let little = mesh("ply", ply_binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes), "");
    let big = mesh("ply", ply_binary("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes), "");
    assert_eq!((&ascii, &ascii), (&little, &big));
    let corners = mesh("ply", PLY_CORNERS, "");
    assert_eq!(corners.triangles, [[0, 1, 2], [0, 2, 3], [4, 2, 1]]);
    assert_eq!(corners.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y, Vec2::splat(0.5)]);
    assert_eq!(corners.positions[4], corners.positions[0]);
    let turned = mesh("ply", PLY_ASCII, "<boolean name='flip_tex_coords' value='true'/>");
    assert_eq!(turned.uvs[0], Vec2::new(0.0, 0.75));
}

#[test]
fn damaged_and_hostile_ply() {
    for (from, to, what) in [
        ("vertex 4", "vertex 1000000000000000", "m.ply:4: promises 1000000000000000 elements `vertex`"),
        ("4 0 1 2 3", "4 0 1 2 4", "m.ply:20: `face` 0: refers to vertex 4, but there are only 4"),
        ("4 0 1 2 3", "4 0 1 2 -1", "refers to vertex -1"),
        ("4 0 1 2 3", "4 0 1 2 1.5", "refers to vertex 1.5"),
        ("4 0 1 2 3", "-4 0 1 2 3", "a list of -4 entries"),
        ("4 0 1 2 3", "4000000000 0 1 2", "m.ply:21: the file ends after 0 of 1 elements `face`"),
        ("1 1 0 9", "1 inf 0 9", "vertex 2 lies at [1, inf, 0]: not finite"),
        ("1 1 0 9", "1 1e39 0 9", "vertex 2 lies at [1, inf, 0]: not finite"),
        ("1 1 0 9", "1 x 0 9", "m.ply:18: `vertex` 2: `x` is not a number"),
        ("1 1 0 9", "1 1 0 9 9", "m.ply:18: `vertex` 2: its line holds more numbers"),
        ("format ascii", "format klingon", "m.ply:2: `klingon` is not a format of PLY"),
        ("element edge", "element face", "m.ply:13: a second element `face`"),
        ("element edge", "elements edge", "m.ply:13: `elements` does not belong into a header"),
        ("end_header", "end", "`end` does not belong into a header"),
        ("property list uchar int vertex_indices", "property list float float vertex_indices", "must be an integer"),
    ] {
        let e = failure("ply", PLY_ASCII.replacen(from, to, 1));
        assert!(e.contains(what), "{from} → {to}: {e}");
    }
    let whole = ply_binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes);
    for length in (0..whole.len()).step_by(7) {
        failure("ply", &whole[..length]);
    }
    let mut nan = whole.clone();
    let x = whole.len() - 17 - 80;
    nan[x..x + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(failure("ply", &nan).contains("vertex 0 lies at [NaN, 0, 0]: not finite"));
    // A vertex that no face has may be anywhere.
    let stray = PLY_ASCII.replace("vertex 4", "vertex 5").replace("4 0 1 2 3", "nan 1e30 0 9 0 0\n4 0 1 2 3");
    assert_eq!(mesh("ply", stray, "").positions[4], Vec3::ZERO);
    // A list of 4 · 10⁹ entries, of which none is there.
    let list =
        "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
    failure("ply", [list.as_bytes(), &u32::MAX.to_le_bytes()].concat());
}

/// A serialized file whose only mesh has this content behind flags and name.
fn serialized(version: u16, flags: u32, content: &[u8]) -> Vec<u8> {
    let mut stream = ZlibEncoder::new(Vec::new(), Compression::best());
    stream.write_all(&flags.to_le_bytes()).unwrap();
    if version == 4 {
        stream.write_all(b"W\xfcrfel\0").unwrap();
    }
    stream.write_all(content).unwrap();
    let mut file = [0x041Cu16.to_le_bytes(), version.to_le_bytes()].concat();
    file.extend(stream.finish().unwrap());
    file.extend(&0u64.to_le_bytes()[..if version == 4 { 8 } else { 4 }]);
    file.extend(1u32.to_le_bytes());
    file
}

fn counts(vertices: u64, triangles: u64) -> Vec<u8> {
    [vertices.to_le_bytes(), triangles.to_le_bytes()].concat()
}

/// A triangle with texture coordinates, in single or double precision.
fn triangle(double: bool, last_index: u32) -> Vec<u8> {
    let mut out = counts(3, 1);
    for n in [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.] {
        if double { out.extend(f64::to_le_bytes(n)) } else { out.extend(f32::to_le_bytes(n as f32)) }
    }
    [0, 1, last_index].iter().for_each(|i: &u32| out.extend(i.to_le_bytes()));
    out
}

#[test]
fn serialized_in_every_version_and_precision() {
    for version in [3, 4] {
        for (flags, double) in [(0x1002, false), (0x2002, true)] {
            let m = mesh("serialized", serialized(version, flags, &triangle(double, 2)), "");
            assert_eq!((m.triangles.as_slice(), m.uvs[1], m.normals.len()), (&[[0, 1, 2]][..], Vec2::X, 3));
        }
        let unknown = mesh("serialized", serialized(version, 0xffff_c002, &triangle(false, 2)), "");
        assert_eq!(unknown.triangles, [[0, 1, 2]]);
        let flat = mesh("serialized", serialized(version, 0x1012, &triangle(false, 2)), "");
        assert!(flat.normals.is_empty());
    }
}

#[test]
fn damaged_and_hostile_serialized() {
    let good = serialized(4, 0x1002, &triangle(false, 2));
    let e = load("serialized", &good, "<integer name='shape_index' value='1'/>").unwrap_err();
    assert!(e.contains("shape index 1, but the file holds 1 meshes"), "{e}");
    let mut displaced = good.clone();
    let table = good.len() - 12;
    displaced[table] = 6;
    for (content, what) in [
        (serialized(4, 0x1002, &triangle(false, 3)), "but there are only 3"),
        (serialized(5, 0x1002, &triangle(false, 2)), "serialized version 5"),
        (serialized(4, 0x1000, &counts(u64::MAX, 1)), "cannot come from"),
        (serialized(4, 0x1000, &counts(3, u64::MAX / 2)), "cannot come from"),
        (serialized(4, 0x1000, &counts(1 << 30, 0)), "cannot come from"),
        (serialized(4, 0x1000, &counts(1000, 0)), "truncated"),
        (displaced, "offset 6 of mesh 0 is not the start of a mesh"),
        (b"PK\x03\x04 a zip file".to_vec(), "first bytes are not 1c 04"),
        (Vec::new(), "too short"),
    ] {
        let e = failure("serialized", &content);
        assert!(e.contains(what), "{e}");
    }
    // The checksum ends the stream, before the offset and the number of meshes.
    let mut damaged = good.clone();
    damaged[table - 1] ^= 1;
    assert!(failure("serialized", &damaged).contains("damaged: corrupt"));
    // A name without end.
    failure("serialized", serialized(4, 0x1000, &[b'x'; 1 << 20]));
    // 10⁸ vertices promised, of which 32 MiB of zeros fit 32 KiB: a zlib bomb.
    let mut bomb = counts(100_000_000, 0);
    bomb.resize(bomb.len() + (32 << 20), 0);
    assert!(failure("serialized", serialized(4, 0x1000, &bomb)).contains("cannot come from"));
    // Any single damaged byte and any truncation ends in an error or a mesh, never in a panic.
    for i in 0..good.len() {
        let mut damaged = good.clone();
        damaged[i] ^= 0x55;
        load("serialized", &damaged, "").ok();
        failure("serialized", &good[..i]);
    }
}

#[test]
fn elementary_shapes() {
    let s = scene(
        "<shape type='rectangle'/><shape type='cube'/><shape type='disk'/>
         <shape type='cylinder'><point name='p0' x='0' y='0' z='0'/><point name='p1' x='0' y='0' z='2'/></shape>
         <shape type='sphere'><point name='center' x='1' y='0' z='0'/><float name='radius' value='2'/>
             <transform name='to_world'><scale value='3'/></transform><boolean name='flip_normals' value='true'/></shape>",
    );
    assert_eq!(s.shapes.len(), 5);
    let Geometry::Sphere(sphere) = s.shapes[4].geometry else { panic!() };
    assert_eq!((sphere.center.x, sphere.radius, sphere.inward), (3.0, 6.0, true));
    let e = error("<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>");
    assert!(e.contains("scaled differently"), "{e}");
    assert!(error("<shape type='sphere'><float name='radius' value='0'/></shape>").contains("a sphere of radius 0 "));
    assert!(error("<shape type='cylinder'><float name='radius' value='-1'/></shape>").contains("a radius > 0"));
    assert!(error("<shape type='hair'/>").contains("the shape `hair` is not supported"));
}

#[test]
fn groups_and_instances() {
    let s = scene(
        "<shape type='shapegroup' id='g'><shape type='cube'/><shape type='sphere'/></shape>
         <shape type='instance'><ref id='g'/><transform name='to_world'><translate x='3'/></transform></shape>
         <shape type='instance'><ref id='g'/></shape>",
    );
    assert_eq!((s.shapes.len(), s.groups.len(), s.groups[0].shapes.len(), s.instances.len()), (0, 1, 2, 2));
    assert_eq!(s.instances[0].to_world.translation.x, 3.0);
    for (body, what) in [
        ("<shape type='instance'/>", "exactly one shapegroup"),
        ("<shape type='cube' id='c'/><shape type='instance'><ref id='c'/></shape>", "not a `cube`"),
        (
            "<shape type='shapegroup' id='g'><shape type='cube'><emitter type='area'/></shape></shape>
             <shape type='instance'><ref id='g'/></shape>",
            "cannot emit light",
        ),
    ] {
        let e = error(body);
        assert!(e.contains(what), "{e}");
    }
}
