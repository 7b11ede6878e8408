//! Files that scenes name: missing ones, other spellings, other encodings.

use crate::{Folder, Loaded, scene_text};
use render::scene::{Geometry, load};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

fn mesh(name: &str) -> String {
    format!("<shape type='obj' id='it'><string name='filename' value='{name}'/></shape>")
}

fn skip_missing(folder: Folder, body: &str) -> Loaded {
    let options = load::Options { skip_missing: true, ..load::Options::default() };
    folder.with("scene.xml", scene_text("3.0.0", body)).load_with("scene.xml", &options)
}

#[test]
fn missing_meshes_are_named_and_may_be_skipped() {
    let e = Folder::new().scene(&format!("\n{}", mesh("gone.obj"))).unwrap_err();
    assert_eq!(
        e,
        "scene.xml:3:1: <shape type=\"obj\" id=\"it\">: gone.obj: cannot read: No such file or directory (os error 2); \
         --skip-missing draws the rest"
    );
    let four: String = (0..4).map(|i| mesh(&format!("{i}.obj")).replace("'it'", &format!("'{i}'"))).collect();
    let body = format!(
        "{four}<shape type='shapegroup' id='g'>{}</shape>{}<shape type='sphere'/>",
        mesh("4.obj"),
        "<shape type='instance'><ref id='g'/></shape>"
    );
    let (scene, warnings) = skip_missing(Folder::new().with("1.obj", SQUARE), &body).unwrap();
    assert_eq!((scene.shapes.len(), scene.groups[0].shapes.len(), scene.instances.len()), (2, 0, 1));
    assert_eq!(warnings, ["--skip-missing: 4 shapes are left out: no 4.obj, 0.obj, 2.obj, …"]);
    // What is there, and broken, is an error.
    assert!(skip_missing(Folder::new().with("gone.obj", "v 1"), &mesh("gone.obj")).is_err());
    assert!(skip_missing(Folder::new(), "<include filename='gone.xml'/>").is_err());
}

#[test]
fn missing_textures_become_grey() {
    let bitmap = "<shape type='sphere'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>
        <string name='filename' value='gone.png'/><float name='gamma' value='5'/></texture></bsdf></shape>";
    let e = Folder::new().scene(bitmap).unwrap_err();
    assert!(e.ends_with("; --skip-missing draws an even grey instead"), "{e}");
    let (scene, warnings) = skip_missing(Folder::new(), bitmap).unwrap();
    assert_eq!(scene.textures[0].eval(&glam::Vec2::ZERO.into()), glam::Vec3A::splat(0.5));
    assert_eq!(warnings, ["--skip-missing: 1 textures are an even grey: no gone.png"]);
    let sky = "<emitter type='envmap'><string name='filename' value='gone.exr'/></emitter>";
    assert!(skip_missing(Folder::new(), sky).is_err());
}

#[test]
fn names_of_other_systems() {
    let folder = || Folder::new().with("models/Quad.obj", SQUARE).with("near.obj", SQUARE);
    let drawn =
        |name: &str| folder().scene(&mesh(name)).map(|(s, _)| matches!(s.shapes[0].geometry, Geometry::Mesh(_)));
    for name in ["models/Quad.obj", "models\\Quad.obj", ".\\models\\Quad.obj", "models/../near.obj"] {
        assert_eq!(drawn(name), Ok(true), "{name}");
    }
    for (name, hint) in [
        ("Models/quad.OBJ", "models/Quad.obj"),
        ("MODELS\\QUAD.obj", "models/Quad.obj"),
        ("Near.obj", "near.obj"),
        ("C:\\Users\\me\\near.obj", "near.obj"),
        ("/home/me/scenes/NEAR.obj", "near.obj"),
    ] {
        let e = drawn(name).unwrap_err();
        assert!(e.contains(&format!("; did you mean {hint}?")), "{name}: {e}");
    }
    assert!(!drawn("far.obj").unwrap_err().contains("did you mean"));
}

#[test]
fn scenes_and_spectra_in_other_encodings() {
    let body = "<shape type='obj'><string name='filename' value='größe.obj'/></shape>
        <bsdf type='diffuse'><spectrum name='reflectance' filename='s.spd'/></bsdf>";
    let text = |encoding: &str| {
        let declared =
            if encoding.is_empty() { String::new() } else { format!("<?xml version='1.0' encoding='{encoding}'?>") };
        format!("{declared}{}", scene_text("3.0.0", body))
    };
    let latin = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<_>>();
    let utf16 = |text: &str| text.encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<_>>();
    for bytes in [
        text("").into_bytes(),
        text("UTF-8").into_bytes(),
        format!("\u{feff}{}", text("")).into_bytes(),
        latin(&text("ISO-8859-1")),
        latin(&text("windows-1252")),
        latin(&text("")),
        utf16(&format!("\u{feff}{}", text("utf-16"))),
        utf16(&text("utf-16")),
    ] {
        let folder =
            Folder::new().with("größe.obj", SQUARE).with("s.spd", b"\xef\xbb\xbf# nm\n300 0.5 # \xb5W\n900 0.5");
        let (scene, _) = folder.with("s.xml", &bytes).load("s.xml", &[]).unwrap();
        assert_eq!(scene.shapes.len(), 1);
    }
    let e = Folder::new().with("s.xml", text("klingon")).load("s.xml", &[]).unwrap_err();
    assert_eq!(e, "s.xml: the encoding `klingon` is not known");
    let folder = Folder::new()
        .with("part.xml", latin("<?xml version='1.0' encoding='latin1'?><bsdf type='diffuse' id='grün'/>"));
    let (scene, _) =
        folder.scene("<include filename='part.xml'/><shape type='sphere'><ref id='grün'/></shape>").unwrap();
    assert_eq!(scene.material_names, ["grün"]);
}
