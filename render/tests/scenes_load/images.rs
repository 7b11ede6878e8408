//! Image formats, good, damaged and hostile.

use crate::{Folder, Loaded};
use exr::prelude::*;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgb32FImage, RgbImage};
use render::image::from_srgb;
use render::scene::{Bitmap, Environment, Texture};
use std::io::Cursor;

/// Two by one pixels: (255, 128, 0), (0, 0, 51).
fn encoded(format: ImageFormat) -> Vec<u8> {
    if format == ImageFormat::Hdr {
        let pixel = |x, _| if x == 0 { Rgb([1.0, 0.5, 0.0]) } else { Rgb([0.0, 0.0, 4.0]) };
        written(&Rgb32FImage::from_fn(2, 1, pixel).into(), format)
    } else {
        let pixel = |x, _| if x == 0 { Rgb([255, 128, 0]) } else { Rgb([0, 0, 51]) };
        written(&RgbImage::from_fn(2, 1, pixel).into(), format)
    }
}

fn written(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image.write_to(&mut out, format).unwrap();
    out.into_inner()
}

fn exr_of(pixel: (f32, f32, f32)) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let channels = SpecificChannels::rgb(move |_: Vec2<usize>| pixel);
    Image::from_channels((4, 2), channels).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

fn texture(name: &str, content: &[u8], parameters: &str) -> std::result::Result<Bitmap, String> {
    let body = format!(
        "<shape type='cube'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>
         <string name='filename' value='{name}'/>{parameters}</texture></bsdf></shape>"
    );
    match &Folder::new().with(name, content).scene(&body)?.0.textures[0] {
        Texture::Bitmap(bitmap) => Ok(bitmap.clone()),
        other => panic!("{other:?}"),
    }
}

fn environment(name: &str, content: &[u8], parameters: &str) -> Loaded {
    let body = format!("<emitter type='envmap'><string name='filename' value='{name}'/>{parameters}</emitter>");
    Folder::new().with(name, content).scene(&body)
}

fn first(bitmap: &Bitmap) -> [f32; 3] {
    bitmap.texels.get(0).to_array()
}

fn near(a: [f32; 3], b: [f32; 3], tolerance: f32) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} is not {b:?}");
}

#[test]
fn display_formats_are_decoded_unless_raw() {
    let png = encoded(ImageFormat::Png);
    near(first(&texture("t.png", &png, "").unwrap()), [1.0, 0.2159, 0.0], 1e-4);
    near(first(&texture("t.png", &png, "<boolean name='raw' value='true'/>").unwrap()), [1.0, 0.5020, 0.0], 1e-4);
    near(first(&texture("t.png", &png, "<float name='gamma' value='1'/>").unwrap()), [1.0, 0.5020, 0.0], 1e-4);
    near(first(&texture("t.png", &png, "<float name='gamma' value='2'/>").unwrap()), [1.0, 0.2520, 0.0], 1e-4);
    near(first(&texture("t.png", &png, "<float name='gamma' value='-1'/>").unwrap()), [1.0, 0.2159, 0.0], 1e-4);
    let jpeg = texture("t.jpg", &encoded(ImageFormat::Jpeg), "").unwrap();
    assert_eq!((jpeg.width, jpeg.height), (2, 1));
    // The format is known by its content, not by its name.
    near(first(&texture("t.jpg", &png, "").unwrap()), [1.0, 0.2159, 0.0], 1e-4);
}

#[test]
fn channels_become_numbers() {
    let png = encoded(ImageFormat::Png);
    let green = texture("t.png", &png, "<string name='channel' value='g'/><boolean name='raw' value='true'/>").unwrap();
    near(first(&green), [0.502; 3], 1e-3);
    assert!(texture("t.png", &png, "<string name='channel' value='q'/>").unwrap_err().contains("no channel `q`"));
}

/// Every value that 8 bits have, through the loader, as decoding gives it; and no more memory than they take.
#[test]
fn stored_values_decode_exactly() {
    let image = RgbImage::from_fn(256, 1, |x, _| Rgb([x as u8, 255 - x as u8, 7]));
    let png = written(&image.into(), ImageFormat::Png);
    for (parameters, curve) in [("", from_srgb as fn(f32) -> f32), ("<boolean name='raw' value='true'/>", |x| x)] {
        let texels = texture("t.png", &png, parameters).unwrap().texels;
        assert_eq!(texels.bytes(), 3 * 256);
        for i in 0..=255u8 {
            let value = |byte: u8| curve(f32::from(byte) / 255.0);
            assert_eq!(texels.get(i.into()).to_array(), [value(i), value(255 - i), value(7)], "{i}");
        }
    }
    let deep = ImageBuffer::<Luma<u16>, _>::from_fn(300, 1, |x, _| Luma([x as u16 * 200]));
    let texels = texture("t.png", &written(&deep.into(), ImageFormat::Png), "").unwrap().texels;
    assert_eq!(texels.bytes(), 2 * 300);
    for i in 0..300u16 {
        assert_eq!(texels.get(i.into()).x, from_srgb(f32::from(i * 200) / 65535.0), "{i}");
    }
    // The numbers of this EXR fit half precision, but for the last.
    for (blue, bytes) in [(0.25, 2), (0.1, 4)] {
        let texels = texture("t.exr", &exr_of((0.5, -2.0, blue)), "").unwrap().texels;
        assert_eq!((texels.bytes(), texels.get(0).to_array()), (3 * bytes * texels.len(), [0.5, -2.0, blue]));
    }
}

#[test]
fn environments_in_every_format() {
    for (name, content, expected) in [
        ("e.exr", exr_of((1.0, 2.0, 3.0)), [1.0, 2.0, 3.0]),
        ("e.hdr", encoded(ImageFormat::Hdr), [1.0, 0.5, 0.0]),
        ("e.png", encoded(ImageFormat::Png), [1.0, 0.2159, 0.0]),
    ] {
        let (scene, _) = environment(name, &content, "<float name='scale' value='2'/>").unwrap();
        let Some(Environment::Map(map)) = scene.environment else { panic!() };
        near(first(&map.image), expected, 0.01);
        assert_eq!(map.scale, 2.0);
    }
}

#[test]
fn environments_turn_but_do_not_shear() {
    let exr = exr_of((1.0, 1.0, 1.0));
    let turned =
        "<transform name='to_world'><rotate y='1' angle='90'/><scale value='3'/><translate x='9'/></transform>";
    let Some(Environment::Map(map)) = environment("e.exr", &exr, turned).unwrap().0.environment else { panic!() };
    assert!((map.to_world.x_axis - glam::Vec3A::NEG_Z).length() < 1e-5);
    let sheared = turned.replace("value='3'", "x='3'");
    assert!(environment("e.exr", &exr, &sheared).unwrap_err().contains("distorts"));
    let two = "</emitter><emitter type='constant'>";
    assert!(environment("e.exr", &exr, two).unwrap_err().contains("one environment"));
}

#[test]
fn pixels_must_be_finite_and_light_positive() {
    let e = environment("e.exr", &exr_of((1.0, f32::NAN, 0.0)), "").unwrap_err();
    assert!(e.ends_with("e.exr: pixel (0, 0) is not finite"), "{e}");
    let (scene, warnings) = environment("e.exr", &exr_of((1.0, -0.5, 0.0)), "").unwrap();
    assert!(warnings[0].contains("8 negative values of e.exr became 0"), "{warnings:?}");
    assert!(matches!(scene.environment, Some(Environment::Map(m)) if first(&m.image) == [1.0, 0.0, 0.0]));
}

#[test]
fn damaged_images_are_refused() {
    for (name, content) in
        [("t.png", encoded(ImageFormat::Png)), ("t.exr", exr_of((1., 2., 3.))), ("t.hdr", encoded(ImageFormat::Hdr))]
    {
        for length in (0..content.len() - 12).step_by(5) {
            let e = texture(name, &content[..length], "").unwrap_err();
            assert!(e.contains(name), "{e}");
        }
    }
    let e = texture("t.png", b"not an image", "").unwrap_err();
    assert!(e.ends_with("t.png: not an OpenEXR, Radiance HDR, PNG, JPEG or WebP image"), "{e}");
}

#[test]
fn huge_images_are_refused_before_they_are_allocated() {
    // A PNG header of 2 · 10⁹ × 2 · 10⁹ pixels, its checksum recomputed.
    let mut png = encoded(ImageFormat::Png);
    png[16..20].copy_from_slice(&2_000_000_000u32.to_be_bytes());
    png[20..24].copy_from_slice(&2_000_000_000u32.to_be_bytes());
    let mut crc = flate2::Crc::new();
    crc.update(&png[12..29]);
    png[29..33].copy_from_slice(&crc.sum().to_be_bytes());
    texture("t.png", &png, "").unwrap_err();
    let e = texture("t.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n", "").unwrap_err();
    assert!(e.contains("1000000 × 1000000 pixels, more than"), "{e}");
    // An OpenEXR data window of 2³⁰ × 2³⁰ pixels.
    let mut exr = exr_of((1.0, 1.0, 1.0));
    let window = exr.windows(10).position(|w| w == b"dataWindow").unwrap() + "dataWindow\0box2i\0".len() + 4;
    exr[window + 8..window + 16].copy_from_slice(&[(1i32 << 30).to_le_bytes(), (1i32 << 30).to_le_bytes()].concat());
    let e = texture("t.exr", &exr, "").unwrap_err();
    assert!(e.contains("t.exr"), "{e}");
}
