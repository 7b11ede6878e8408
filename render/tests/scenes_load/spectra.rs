//! Colours as scene text writes them.

use crate::{Folder, error, scene, scene_text};
use glam::Vec3A;
use render::scene::{ColorTexture, Environment, Material, Scene};

fn reflectance(s: &Scene) -> Vec3A {
    match s.materials[0] {
        Material::Diffuse { reflectance: ColorTexture::Constant(c) } => c,
        ref other => panic!("{other:?}"),
    }
}

fn reflected(color: &str) -> Vec3A {
    reflectance(&scene(&format!("<shape type='sphere'><bsdf type='diffuse'>{color}</bsdf></shape>")))
}

fn radiance(version: &str, color: &str) -> Vec3A {
    let text = scene_text(version, &format!("<emitter type='constant'>{color}</emitter>"));
    match Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap().0.environment {
        Some(Environment::Constant(c)) => c,
        other => panic!("{other:?}"),
    }
}

fn near(a: Vec3A, b: [f32; 3]) {
    assert!((a - Vec3A::from(b)).abs().max_element() < 2e-3, "{a} is not {b:?}");
}

#[test]
fn rgb_and_srgb() {
    near(reflected("<rgb name='reflectance' value='0.1, 0.2 0.3'/>"), [0.1, 0.2, 0.3]);
    near(reflected("<rgb name='reflectance' value='0.4'/>"), [0.4; 3]);
    near(reflected("<rgb name='reflectance' value='#ff8000'/>"), [1.0, 0.502, 0.0]);
    near(reflected("<srgb name='reflectance' value='#ff8000'/>"), [1.0, 0.2159, 0.0]);
    near(reflected("<srgb name='reflectance' value='0.5'/>"), [0.2140; 3]);
    near(reflected("<float name='reflectance' value='0.3'/>"), [0.3; 3]);
}

#[test]
fn spectra_become_rgb() {
    near(reflected("<spectrum name='reflectance' value='0.7'/>"), [0.7; 3]);
    near(reflected("<spectrum name='reflectance' value='360:0.7, 830:0.7'/>"), [0.7; 3]);
    let red = reflected("<spectrum name='reflectance' value='600:0 620:1 830:1'/>");
    assert!(red.x > 0.4 && red.y < 0.1 && red.z < 0.1, "{red}");
    // Only version 3 calls a constant spectrum of a light illuminant E.
    near(radiance("0.6.0", "<spectrum name='radiance' value='2'/>"), [2.0; 3]);
    near(radiance("3.0.0", "<spectrum name='radiance' value='2'/>"), [2.4096, 1.8965, 1.8176]);
    near(radiance("3.0.0", "<rgb name='radiance' value='2'/>"), [2.0; 3]);
    let warm = radiance("3.0.0", "<blackbody name='radiance' temperature='2800K' scale='1e-3'/>");
    assert!(warm.x > 1.5 * warm.y && warm.y > 1.5 * warm.z, "{warm}");
}

/// As Mitsuba 3.9 draws them in its spectral mode.
#[test]
fn spectra_that_are_plugins() {
    let flat = "<string name='wavelengths' value='300, 900'/><string name='values' value='1 1'/>";
    let e = [1.2048, 0.9483, 0.9089];
    near(radiance("3.0.0", &format!("<spectrum type='irregular' name='radiance'>{flat}</spectrum>")), e);
    let regular = "<float name='wavelength_min' value='300'/><float name='wavelength_max' value='900'/>
        <string name='values' value='1 1 1'/>";
    near(radiance("3.0.0", &format!("<spectrum type='regular' name='radiance'>{regular}</spectrum>")), e);
    let warm = radiance(
        "3.0.0",
        "<spectrum type='blackbody' name='radiance'><float name='temperature' value='5000'/></spectrum>",
    );
    assert!((warm / Vec3A::new(15280.6, 12094.7, 9591.1) - 1.0).abs().max_element() < 1e-2, "{warm}");
    near(
        radiance("3.0.0", "<texture type='d65' name='radiance'><rgb name='color' value='1 .5 .25'/></texture>"),
        [1.0, 0.5, 0.25],
    );
    near(reflected(&format!("<spectrum type='irregular' name='reflectance'>{flat}</spectrum>")), [1.0; 3]);
    for (wrong, what) in [
        (
            "irregular'><string name='wavelengths' value='1 2'/><string name='values' value='1'/>",
            "2 wavelengths, but 1",
        ),
        ("irregular'><string name='wavelengths' value='2 1'/><string name='values' value='1 1'/>", "must increase"),
        ("irregular'><string name='wavelengths' value=''/><string name='values' value=''/>", "must increase"),
        ("regular'><string name='values' value='1'/>", "2 to 65536 values"),
        ("blackbody'>", "above 0 K"),
    ] {
        let e = error(&format!(
            "<shape type='sphere'><bsdf type='diffuse'><spectrum name='reflectance' type='{wrong}</spectrum></bsdf></shape>"
        ));
        assert!(e.contains(what), "{e}");
    }
}

#[test]
fn spectra_from_files() {
    let body =
        "<shape type='sphere'><bsdf type='diffuse'><spectrum name='reflectance' filename='flat.spd'/></bsdf></shape>";
    let folder = Folder::new().with("flat.spd", "# nm value\n300 0.25\n\n900 0.25 # end\n");
    near(reflectance(&folder.scene(body).unwrap().0), [0.25; 3]);
    let e = Folder::new().with("flat.spd", "300 0.25\n400 a\n").scene(body).unwrap_err();
    assert!(e.contains("flat.spd:2: `a` is not a number"), "{e}");
}

#[test]
fn wrong_colours_are_refused() {
    for (color, what) in [
        ("<rgb name='reflectance' value='1 2'/>", "1 or 3 numbers"),
        ("<rgb name='reflectance' value='#12345'/>", "#rrggbb"),
        ("<rgb name='reflectance' value='-1 0 0'/>", "not negative"),
        ("<rgb name='reflectance' value='inf'/>", "not finite"),
        ("<spectrum name='reflectance' value='500:1 400:1'/>", "must increase"),
        ("<spectrum name='reflectance' value='1 2 3'/>", "wavelength:value"),
        ("<spectrum name='reflectance'/>", "either `value` or `filename`"),
        ("<blackbody name='reflectance' temperature='-3'/>", "above 0 K"),
    ] {
        let e = error(&format!("<bsdf type='diffuse'>\n{color}</bsdf>"));
        assert!(e.starts_with("scene.xml:3:1: <") && e.contains(what), "{e}");
    }
}
