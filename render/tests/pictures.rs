//! Pictures for people and for compositors, as the command writes them: formats, views, alpha, parts of a film.

mod support;

use render::image::{Pixels, read, read_pixels};
use support::Folder;

/// A ball of radius 1 at distance 4 under a grey sky; `bsdf` stands for what it is made of.
fn ball(bsdf: &str, filter: &str) -> String {
    format!(
        r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective"><float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/>{filter}</film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <shape type="sphere">{bsdf}</shape></scene>"#
    )
}

const GREY: &str = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6"/></bsdf>"#;
const BOX: &str = r#"<rfilter type="box"/>"#;

/// Its pixels, alpha as the fourth number.
fn rgba(pixels: &Pixels) -> Vec<[f32; 4]> {
    pixels.raster.pixels().collect()
}

/// Share of the film that the ball takes: it is a disk with the tangent of asin(1/4).
fn share() -> f64 {
    let (radius, half) = (0.25f64.asin().tan(), 20f64.to_radians().tan());
    std::f64::consts::PI * radius * radius / (4.0 * half * half)
}

fn folder(scene: &str) -> Folder {
    Folder::with(scene, &[])
}

fn mean_alpha(pixels: &Pixels) -> f64 {
    rgba(pixels).iter().map(|p| f64::from(p[3])).sum::<f64>() / rgba(pixels).len() as f64
}

fn bytes(f: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(f.path(name)).unwrap()
}

#[test]
fn every_format_shows_the_same_picture() {
    let f = folder(&ball(GREY, BOX));
    f.ok("image scene.xml --spp 16 -o a.exr -o a.png -o a.jpg -o b.JPEG -o a.webp --exposure 0.5 --view agx");
    f.ok("image scene.xml --spp 16 -o c.png -o c.webp --exposure 0.5 --view agx --threads 1");
    assert!(bytes(&f, "a.png") == bytes(&f, "c.png") && bytes(&f, "a.webp") == bytes(&f, "c.webp"));
    assert!(bytes(&f, "a.jpg") == bytes(&f, "b.JPEG") && bytes(&f, "a.jpg").starts_with(&[0xff, 0xd8, 0xff]));
    let png = read_pixels(&f.path("a.png")).unwrap();
    assert_eq!(rgba(&read_pixels(&f.path("a.webp")).unwrap()), rgba(&png));
    let jpeg = read_pixels(&f.path("a.jpg")).unwrap();
    let differences = rgba(&jpeg).into_iter().zip(rgba(&png)).map(|(a, b)| (a[1] - b[1]).abs());
    assert!(differences.sum::<f32>() / (24.0 * 24.0) < 0.02);
    // The ball reflects 0.6 of the sky, half a stop brighter.
    let level = |p: &Pixels| 255.0 * rgba(p)[12 * 24 + 12][1];
    assert!((level(&png) - level_of_agx(0.3 * 2f32.sqrt())).abs() < 2.0, "{}", level(&png));
}

/// The level of a grey.
fn level_of_agx(light: f32) -> f32 {
    use render::image::view::{Display, View};
    255.0 * Display::new(View::Agx, 0.0).values([light; 3])[1]
}

#[test]
fn the_default_view_is_the_light_itself() {
    let f = folder(&ball(GREY, BOX));
    f.ok("image scene.xml --spp 4 -o a.exr -o a.png");
    f.ok("image scene.xml --spp 4 -o b.png --view standard --exposure 0");
    f.ok("image scene.xml --spp 4 -o c.png -o c.exr --exposure -1");
    f.ok("image scene.xml --spp 4 -o d.png --view filmic");
    assert!(bytes(&f, "a.png") == bytes(&f, "b.png") && bytes(&f, "a.png") != bytes(&f, "d.png"));
    assert!(bytes(&f, "a.exr") == bytes(&f, "c.exr"), "EXR keeps the light");
    let (light, half) = (read(&f.path("a.exr")).unwrap(), read(&f.path("c.png")).unwrap());
    let far = light.pixels.iter().zip(&half.pixels).map(|(a, b)| (0.5 * a[0] - b[0]).abs()).fold(0.0, f32::max);
    assert!(far < 0.005, "{far}");
    f.bad("image scene.xml -o a.exr --view agx", "--view needs an output for a screen");
    f.bad("image scene.xml -o a.exr --exposure 1", "--exposure needs an output for a screen");
    f.bad("image scene.xml -o a.png --exposure 65", "--exposure");
    f.bad("image scene.xml -o a.png --exposure nan", "--exposure");
    f.bad("image scene.xml -o a.png --view raw", "--view");
    f.bad("image scene.xml -o a.webp --width 20000", "WebP has at most 16384 pixels either way");
    f.bad("image scene.xml -o a.gif", ".webp");
}

/// Alpha is the share of the film's filter that the ball covers, by every method; its colour has no sky in it.
#[test]
fn a_transparent_background() {
    for method in ["path", "irradiance", "auto", "eas", "sh"] {
        let f = folder(&ball(GREY, BOX));
        f.ok(&format!(
            "image scene.xml --spp 64 --method {method} --tau 0.1 --transparent -o a.exr -o a.png -o a.webp"
        )
        .replace("--method path --tau 0.1", ""));
        let (exr, png) = (read_pixels(&f.path("a.exr")).unwrap(), read_pixels(&f.path("a.png")).unwrap());
        assert_eq!(rgba(&read_pixels(&f.path("a.webp")).unwrap()), rgba(&png));
        assert!((mean_alpha(&exr) - share()).abs() < 0.003, "{method}: {} not {}", mean_alpha(&exr), share());
        assert!((mean_alpha(&png) - share()).abs() < 0.003);
        for (light, shown) in rgba(&exr).iter().zip(&rgba(&png)) {
            let [r, _, _, alpha] = *light;
            assert!((r - 0.3 * alpha).abs() < 0.01, "{method}: multiplied by alpha: {light:?}");
            assert!(alpha == 0.0 || (255.0 * shown[0] - 148.9).abs() < 5.0, "{method}: not multiplied: {shown:?}");
        }
        assert!(rgba(&exr).iter().any(|p| p[3] > 0.1 && p[3] < 0.9) && rgba(&exr)[0] == [0.0; 4]);
    }
}

/// A wider filter softens alpha as it softens the picture.
#[test]
fn alpha_follows_the_filter() {
    let alpha = |filter: &str| {
        let f = folder(&ball(GREY, filter));
        f.ok("image scene.xml --spp 256 --transparent -o a.exr");
        read_pixels(&f.path("a.exr")).unwrap()
    };
    let (sharp, soft) = (alpha(BOX), alpha(r#"<rfilter type="gaussian"><float name="stddev" value="1.5"/></rfilter>"#));
    let partly = |p: &Pixels| rgba(p).iter().filter(|p| p[3] > 0.02 && p[3] < 0.98).count();
    assert!(partly(&soft) > 2 * partly(&sharp), "{} {}", partly(&soft), partly(&sharp));
    for p in &rgba(&soft) {
        assert!((p[0] - 0.3 * p[3]).abs() < 0.01, "{p:?}");
    }
}

/// What is seen through holes is behind the picture; what mirrors and glass show of the sky is in it.
#[test]
fn masks_mirrors_and_glass() {
    let mask = format!(r#"<bsdf type="mask"><float name="opacity" value="0.25"/>{GREY}</bsdf>"#);
    for (bsdf, opacity, color) in [
        // Either side of the ball stops a quarter of what comes to it.
        (mask.as_str(), 1.0 - 0.75 * 0.75, None),
        (r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#, 1.0, Some(0.5)),
        (r#"<bsdf type="dielectric"><float name="int_ior" value="1.0"/></bsdf>"#, 1.0, Some(0.5)),
        (r#"<bsdf type="thindielectric"/>"#, 1.0, Some(0.5)),
    ] {
        for method in ["path", "irradiance --tau 0.1"] {
            let f = folder(&ball(bsdf, BOX));
            f.ok(&format!("image scene.xml --spp 256 --transparent --method {method} -o a.exr"));
            let exr = read_pixels(&f.path("a.exr")).unwrap();
            let found = mean_alpha(&exr);
            assert!((found - opacity * share()).abs() < 0.01, "{bsdf} {method}: {found}");
            let middle = rgba(&exr)[12 * 24 + 12];
            assert!(color.is_none_or(|c| (middle[1] - c).abs() < 0.02), "{bsdf} {method}: {middle:?}");
        }
    }
}

#[test]
fn what_has_no_alpha_is_refused() {
    let f = folder(&ball(GREY, BOX));
    f.bad("image scene.xml --transparent -o a.png -o a.jpg", "a.jpg: JPEG holds no transparency");
    f.ok("image scene.xml --spp 1 -o a.exr");
    assert_eq!(mean_alpha(&read_pixels(&f.path("a.exr")).unwrap()), 1.0, "no alpha without --transparent");
}

/// Crops know where they lie: two of one size are compared only where they are of one place.
#[test]
fn other_crops_are_not_compared() {
    let f = folder(&ball(GREY, BOX));
    f.ok("image scene.xml --spp 1 -o a.exr --crop 0,0,5,4");
    f.ok("image scene.xml --spp 1 -o b.exr --crop 10,6,5,4");
    f.ok("image scene.xml --spp 1 -o c.exr --crop 10,6,5,4 --seed 2");
    f.ok("image scene.xml --spp 1 -o b.png --crop 10,6,5,4");
    f.bad(
        "compare a.exr b.exr",
        "other parts of one picture: pixels (0, 0) to (4, 3) and (10, 6) to (14, 9) of the film",
    );
    f.ok("compare b.exr c.exr");
    f.ok("compare b.png a.exr");
    let b = read_pixels(&f.path("b.exr")).unwrap();
    assert_eq!((b.raster.width, b.raster.height, b.windows.unwrap().data.min), (5, 4, [10, 6]));
}

#[test]
fn lenses_focus_on_the_middle() {
    let f = folder(&ball(GREY, BOX));
    let (_, err) = f.ok("image scene.xml --spp 4 -o a.exr --aperture 0.3");
    assert!(err.contains("render: focused at 3.0") && err.contains("what the middle of the picture shows"), "{err}");
    f.ok("image scene.xml --spp 4 -o sharp.exr");
    f.ok("image scene.xml --spp 4 -o closed.exr --aperture 0");
    assert!(bytes(&f, "sharp.exr") == bytes(&f, "closed.exr") && bytes(&f, "sharp.exr") != bytes(&f, "a.exr"));
    f.ok("image scene.xml --spp 4 -o one.exr --aperture 0.3 --focus 3 --threads 1");
    f.ok("image scene.xml --spp 4 -o two.exr --aperture 0.3 --focus 3 --threads 2");
    assert!(bytes(&f, "one.exr") == bytes(&f, "two.exr"));
}
