//! Scattering models, textures, emitters.

use crate::{Folder, error, scene, scene_text, warning};
use glam::{Vec2, Vec3A};
use render::scene::*;

/// All materials of a scene of version 3 with a cube of this material; the cube's is the last.
fn materials(bsdf: &str) -> Vec<Material> {
    scene(&format!("<shape type='cube'>{bsdf}</shape>")).materials
}

fn material(bsdf: &str) -> Material {
    materials(bsdf).pop().unwrap()
}

/// The same of version 0.6, with the number of warnings.
fn legacy(bsdf: &str) -> (Material, usize) {
    let text = scene_text("0.6.0", &format!("<shape type='cube'>{bsdf}</shape>"));
    let (mut scene, warnings) = Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap();
    (scene.materials.pop().unwrap(), warnings.len())
}

fn grey(v: f32) -> ColorTexture {
    ColorTexture::Constant(Vec3A::splat(v))
}

fn number(v: f32) -> FloatTexture {
    FloatTexture::Constant(v)
}

#[test]
fn phong_and_ward_with_their_defaults() {
    assert_eq!(
        material("<bsdf type='phong'/>"),
        Material::Phong { diffuse: grey(0.5), specular: grey(0.2), exponent: number(30.0) }
    );
    let ward = "<bsdf type='ward'><float name='alpha_u' value='0.5'/><string name='variant' value='ward'/></bsdf>";
    let expected = Material::Ward {
        variant: WardVariant::Ward,
        diffuse: grey(0.5),
        specular: grey(0.2),
        alpha_u: number(0.5),
        alpha_v: number(0.1),
    };
    assert_eq!(material(ward), expected);
    assert!(
        error("<shape type='cube'><bsdf type='ward'><float name='alpha' value='0'/></bsdf></shape>")
            .contains("above 0")
    );
    // Version 0.6 scales reflectances that exceed 1 together.
    let bright = "<bsdf type='phong'><rgb name='diffuseReflectance' value='0.9'/><rgb name='specularReflectance' value='0.9'/></bsdf>";
    let (Material::Phong { diffuse: ColorTexture::Constant(kd), .. }, 1) = legacy(bright) else { panic!() };
    assert!((kd.x - 0.495).abs() < 1e-6);
}

#[test]
fn conductors_by_name_and_by_numbers() {
    let Material::RoughConductor { eta, k, distribution, alpha_u, .. } = material(
        "<bsdf type='roughconductor'><string name='material' value='Au'/><string name='distribution' value='ggx'/>
         <float name='alpha' value='0.3'/></bsdf>",
    ) else {
        panic!()
    };
    let (ColorTexture::Constant(eta), ColorTexture::Constant(k)) = (eta, k) else { panic!() };
    assert!((eta - Vec3A::new(0.143, 0.375, 1.442)).abs().max_element() < 2e-3 && k.x > 3.9);
    assert_eq!((distribution, alpha_u), (Distribution::Ggx, number(0.3)));
    let mirror = Material::Conductor { eta: grey(0.0), k: grey(1.0), specular: grey(1.0) };
    assert_eq!(material("<bsdf type='conductor'><string name='material' value='none'/></bsdf>"), mirror);
    assert_eq!(material("<bsdf type='conductor'/>"), mirror);
    // Version 0.6 means copper in air.
    assert!(matches!(legacy("<bsdf type='conductor'/>").0,
            Material::Conductor { eta: ColorTexture::Constant(eta), .. } if eta.x < 0.21 && eta.z > 1.0));
    let given = "<bsdf type='conductor'><rgb name='eta' value='2'/><rgb name='k' value='4'/><float name='extEta' value='2'/></bsdf>";
    assert!(matches!(legacy(given).0, Material::Conductor { eta, k, .. } if eta == grey(1.0) && k == grey(2.0)));
    for (inside, what) in [
        ("<string name='material' value='Xx'/>", "no such conductor: `Xx`"),
        ("<string name='material' value='Au'/><rgb name='eta' value='1'/>", "either `material` or"),
        ("<string name='material' value='Au'/><texture type='checkerboard' name='k'/>", "either `material` or"),
    ] {
        let e = error(&format!("<shape type='cube'><bsdf type='conductor'>{inside}</bsdf></shape>"));
        assert!(e.contains(what), "{e}");
    }
}

/// The index from a texture: what reflects is Fresnel's term of the value at the point, over the index outside.
#[test]
fn conductors_with_an_index_from_a_texture() {
    let checker = |name, a, b| {
        format!(
            "<texture type='checkerboard' name='{name}'><rgb name='color0' value='{a}'/><rgb name='color1' value='{b}'/></texture>"
        )
    };
    let bsdf = |kind| {
        format!(
            "<shape type='rectangle'><bsdf type='{kind}'>{}{}<float name='ext_eta' value='2'/></bsdf></shape>",
            checker("eta", "1", "3"),
            checker("k", "4", "8")
        )
    };
    let rough = scene(&bsdf("roughconductor"));
    let half = Vec3A::splat(0.5);
    assert!(matches!(rough.materials[0], Material::RoughConductor { eta: ColorTexture::Scaled(_, e),
        k: ColorTexture::Scaled(_, k), .. } if e == half && k == half));
    let world = render::world::World::new(scene(&bsdf("conductor"))).unwrap();
    for (at, eta, k) in [(Vec3A::new(-0.4, -0.6, 1.0), 0.5f32, 2.0f32), (Vec3A::new(0.4, -0.6, 1.0), 1.5, 4.0)] {
        let ray = render::ray::Ray::new(at, Vec3A::NEG_Z);
        let sample =
            world.bsdf(&world.interaction(&ray, &world.intersect(&ray))).sample(0.5, Vec2::splat(0.5)).unwrap();
        let expected = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        assert!((sample.weight.sum().x - expected).abs() < 1e-4, "{at}: {} {expected}", sample.weight.sum());
    }
}

#[test]
fn dielectrics_and_plastics() {
    assert!(
        matches!(material("<bsdf type='dielectric'/>"), Material::Dielectric { eta, .. } if (eta - 1.5046 / 1.000277).abs() < 1e-6)
    );
    let water = "<string name='int_ior' value='water'/><float name='ext_ior' value='1'/>";
    assert!(
        matches!(material(&format!("<bsdf type='thindielectric'>{water}</bsdf>")), Material::ThinDielectric { eta, .. } if eta == 1.333)
    );
    assert!(
        matches!(material(&format!("<bsdf type='roughdielectric'>{water}</bsdf>")), Material::RoughDielectric { eta, alpha_v, .. } if eta == 1.333 && alpha_v == number(0.1))
    );
    assert!(matches!(
        material("<bsdf type='plastic'><boolean name='nonlinear' value='true'/></bsdf>"),
        Material::Plastic { nonlinear: true, .. }
    ));
    assert!(matches!(
        material("<bsdf type='roughplastic'><float name='alpha' value='0.2'/></bsdf>"),
        Material::RoughPlastic { alpha: 0.2, nonlinear: false, .. }
    ));
    assert!(
        error("<shape type='cube'><bsdf type='dielectric'><string name='int_ior' value='mud'/></bsdf></shape>")
            .contains("no such dielectric: `mud`")
    );
    assert!(
        error("<shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf></shape>")
            .contains("index of refraction of 0")
    );
}

#[test]
fn materials_made_of_others() {
    let all = materials("<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='phong'/></bsdf>");
    assert_eq!(all[2], Material::TwoSided { front: MaterialId(0), back: MaterialId(1) });
    let all = materials("<bsdf type='mask'><float name='opacity' value='0.3'/><bsdf type='diffuse'/></bsdf>");
    assert_eq!(all[1], Material::Mask { opacity: number(0.3), inner: MaterialId(0) });
    let all = materials(
        "<bsdf type='blendbsdf'><float name='weight' value='0.2'/><bsdf type='diffuse'/><bsdf type='phong'/></bsdf>",
    );
    assert_eq!(all[2], Material::Blend { weight: number(0.2), first: MaterialId(0), second: MaterialId(1) });
    assert!(matches!(material("<bsdf type='null'/>"), Material::Mask { opacity: FloatTexture::Constant(0.0), .. }));
    for bsdf in ["twosided", "mask", "blendbsdf", "bumpmap", "normalmap", "mixturebsdf"] {
        error(&format!("<shape type='cube'><bsdf type='{bsdf}'/></shape>"));
    }
}

#[test]
fn mixtures_keep_their_shares() {
    let mixture = |weights: &str| {
        materials(&format!(
            "<bsdf type='mixturebsdf'><string name='weights' value='{weights}'/>
             <bsdf type='diffuse'/><bsdf type='phong'/><bsdf type='plastic'/></bsdf>"
        ))
    };
    // Share of every leaf under the last material.
    fn shares(all: &[Material], id: usize, weight: f32, out: &mut Vec<f32>) {
        if let Material::Blend { weight: FloatTexture::Constant(w), first, second } = &all[id] {
            shares(all, first.0 as usize, weight * (1.0 - w), out);
            shares(all, second.0 as usize, weight * w, out);
        } else {
            out[id] += weight;
        }
    }
    for (weights, expected) in [("0.2, 0.3, 0.5", vec![0.2, 0.3, 0.5]), ("0.1 0.2 0.3", vec![0.1, 0.2, 0.3, 0.4])] {
        let all = mixture(weights);
        let mut out = vec![0.0; all.len()];
        shares(&all, all.len() - 1, 1.0, &mut out);
        let close = expected.iter().zip(&out).all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-6);
        assert!(close, "{out:?}");
    }
}

#[test]
fn normal_and_bump_maps() {
    let png = || {
        let mut out = std::io::Cursor::new(Vec::new());
        image::RgbImage::from_pixel(1, 1, image::Rgb([128, 128, 255]))
            .write_to(&mut out, image::ImageFormat::Png)
            .unwrap();
        out.into_inner()
    };
    let texture =
        "<texture type='bitmap' name='n'><string name='filename' value='n.png'/></texture><bsdf type='diffuse'/>";
    let load = |bsdf: &str| {
        let body = format!("<shape type='cube'>{bsdf}</shape>");
        Folder::new().with("n.png", png()).scene(&body).unwrap().0
    };
    let scene = load(&format!("<bsdf type='normalmap'>{texture}</bsdf>"));
    assert!(matches!(scene.materials[1], Material::NormalMap { inner: MaterialId(0), .. }));
    // Normals are never decoded as colours.
    assert!((scene.textures[0].eval(&Vec2::ZERO.into()).x - 0.502).abs() < 1e-3);
    let scene = load(&format!("<bsdf type='bumpmap'><float name='scale' value='3'/>{texture}</bsdf>"));
    assert!(matches!(scene.materials[1], Material::BumpMap { scale: 3.0, .. }));
    let scaled = "<texture type='scale'><float name='scale' value='5'/><texture type='checkerboard'/></texture>";
    assert!(matches!(
        material(&format!("<bsdf type='bumpmap'>{scaled}<bsdf type='diffuse'/></bsdf>")),
        Material::BumpMap { scale: 5.0, .. }
    ));
}

#[test]
fn checkerboards_scales_and_shared_textures() {
    let s = scene(
        "<texture type='checkerboard' id='t'><rgb name='color0' value='1 0 0'/><rgb name='color1' value='0 0 1'/>
             <transform name='to_uv'><scale x='2' y='4'/></transform></texture>
         <shape type='cube'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></shape>
         <shape type='cube'><bsdf type='diffuse'><texture type='scale' name='reflectance'><ref id='t'/>
             <rgb name='scale' value='0.5'/></texture></bsdf></shape>",
    );
    assert_eq!(s.textures.len(), 1);
    assert_eq!(s.textures[0].eval(&Vec2::new(0.2, 0.1).into()), Vec3A::X);
    assert_eq!(s.textures[0].eval(&Vec2::new(0.3, 0.1).into()), Vec3A::Z);
    let half = ColorTexture::Scaled(TextureId(0), Vec3A::splat(0.5));
    assert_eq!(s.materials[1], Material::Diffuse { reflectance: half });
    // Version 0.6: uv · scale + offset.
    let text = "<texture type='checkerboard' id='t'><float name='uscale' value='2'/><float name='uoffset' value='0.5'/></texture>
        <shape type='cube'><bsdf type='diffuse'><ref name='reflectance' id='t'/></bsdf></shape>";
    let (s, _) = Folder::new().with("s.xml", scene_text("0.6.0", text)).load("s.xml", &[]).unwrap();
    let Texture::Checkerboard { to_uv, .. } = s.textures[0] else { panic!() };
    assert_eq!(to_uv.transform_point2(Vec2::new(0.25, 0.25)), Vec2::new(1.0, 0.25));
}

#[test]
fn emitters() {
    let s = scene(
        "<shape type='rectangle'><emitter type='area'><rgb name='radiance' value='3'/></emitter></shape>
         <emitter type='point'><transform name='to_world'><translate y='2'/></transform></emitter>
         <emitter type='directional'><vector name='direction' x='0' y='-2' z='0'/><rgb name='irradiance' value='5'/></emitter>
         <emitter type='spot'><float name='cutoff_angle' value='40'/><transform name='to_world'><rotate y='1' angle='90'/></transform></emitter>
         <emitter type='constant'><rgb name='radiance' value='0.1'/></emitter>",
    );
    assert_eq!(s.shapes[0].emitter, Some(AreaEmitter { radiance: grey(3.0) }));
    // A lamp without material is black.
    assert_eq!(s.materials[0], Material::Diffuse { reflectance: grey(0.0) });
    assert_eq!(s.lights[0], Light::Point { position: Vec3A::Y * 2.0, intensity: Vec3A::ONE });
    assert_eq!(s.lights[1], Light::Directional { direction: Vec3A::NEG_Y, irradiance: Vec3A::splat(5.0) });
    assert!(matches!(s.lights[2], Light::Spot { direction, beam, .. }
        if (direction - Vec3A::X).length() < 1e-6 && (beam.to_degrees() - 30.0).abs() < 1e-4));
    assert_eq!(s.environment, Some(Environment::Constant(Vec3A::splat(0.1))));
    assert!(error("<emitter type='sky'/>").ends_with("the emitter `sky` is not supported"));
    assert!(error("<shape type='cube'><emitter type='point'/></shape>").contains("cannot belong to a shape"));
    assert!(
        error("<emitter type='directional'><vector name='direction' x='0'/></emitter>").contains("direction is zero")
    );
}

#[test]
fn principled_is_a_surface_and_a_coat() {
    let of = |parameters: &str| material(&format!("<bsdf type='principled'>{parameters}</bsdf>"));
    let eta = |parameters: &str| match of(parameters) {
        Material::Principled { eta, .. } => eta,
        other => panic!("{other:?}"),
    };
    assert!((eta("") - 1.5).abs() < 1e-5 && (eta("<float name='eta' value='1.7'/>") - 1.7).abs() < 1e-5);
    assert!((1.0001..1.02).contains(&eta("<float name='specular' value='0'/>")));
    let coated = of("<float name='clearcoat' value='0.5'/><float name='main_specular_sampling_rate' value='2'/>");
    assert!(matches!(coated, Material::Coat { added: true, .. }), "{coated:?}");
    for (parameters, what) in [
        ("<float name='specular' value='0.5'/><float name='eta' value='1.5'/>", "either `specular` or `eta`"),
        ("<float name='eta' value='0.5'/>", "`eta` must lie between 1 and 100"),
        ("<float name='specular' value='-1'/>", "`specular` must lie between 0 and 1"),
        ("<float name='sheen' value='2'/>", "`sheen` must lie between"),
    ] {
        let said = error(&format!("<shape type='cube'><bsdf type='principled'>{parameters}</bsdf></shape>"));
        assert!(said.contains(what), "{said}");
    }
}

#[test]
fn substitutes_are_announced_once() {
    for (bsdf, what) in [
        ("<bsdf type='roughdiffuse'/>", "`roughdiffuse` is drawn as `diffuse`"),
        ("<bsdf type='coating'><bsdf type='diffuse'/></bsdf>", "drawn as the bsdf inside"),
        ("<bsdf type='principled'><float name='flatness' value='0.5'/></bsdf>", "drawn without its `flatness`"),
        ("<bsdf type='principled'><float name='spec_trans' value='1'/></bsdf>", "drawn without its `spec_trans`"),
        (
            "<bsdf type='roughplastic'><texture type='checkerboard' name='alpha'/></bsdf>",
            "`alpha` of `roughplastic` is drawn as its mean",
        ),
        ("<bsdf type='roughconductor'><string name='distribution' value='phong'/></bsdf>", "drawn as `beckmann`"),
        ("<medium type='homogeneous' name='interior'/><bsdf type='diffuse'/>", "drawn without it"),
    ] {
        let w = warning(&format!("<shape type='cube'>\n{bsdf}</shape><shape type='sphere'/>"));
        assert!(w.starts_with("scene.xml:") && w.contains(what), "{w}");
    }
    assert!(error("<shape type='cube'><bsdf type='hk'/></shape>").ends_with("the bsdf `hk` is not supported"));
    assert!(error("<shape type='cube'><bsdf type='diffuse'/><bsdf type='phong'/></shape>").contains("has two"));
}

#[test]
fn a_rough_coat_with_a_texture_takes_its_mean() {
    let bsdf = "<bsdf type='roughplastic'><texture type='checkerboard' name='alpha'><rgb name='color0' value='0.1'/>
        <rgb name='color1' value='0.3'/></texture></bsdf>";
    let (scene, _) = Folder::new().scene(&format!("<shape type='cube'>{bsdf}</shape>")).unwrap();
    assert!(matches!(scene.materials[0], Material::RoughPlastic { alpha, .. } if (alpha - 0.2).abs() < 1e-6));
}

#[test]
fn numbers_outside_their_domain_are_refused() {
    for (bsdf, what) in [
        (
            "<bsdf type='diffuse'><rgb name='reflectance' value='1.5 0 0'/></bsdf>",
            "`reflectance` must lie between 0 and 1",
        ),
        ("<bsdf type='phong'><float name='exponent' value='-1'/></bsdf>", "`exponent` must lie between"),
        ("<bsdf type='mask'><float name='opacity' value='2'/><bsdf type='diffuse'/></bsdf>", "`opacity` must lie"),
        ("<bsdf type='roughplastic'><float name='alpha' value='-0.1'/></bsdf>", "above 0"),
    ] {
        let e = error(&format!("<shape type='cube'>{bsdf}</shape>"));
        assert!(e.starts_with("scene.xml:2:20: <bsdf") && e.contains(what), "{e}");
    }
    let bright = "<bsdf type='diffuse'><rgb name='reflectance' value='1.5 0 0'/></bsdf>";
    assert_eq!(legacy(bright), (Material::Diffuse { reflectance: ColorTexture::Constant(Vec3A::X * 0.99) }, 1));
    for (shape, what) in [
        (
            "<shape type='cube'><transform name='to_world'><scale value='1e40'/></transform></shape>",
            "not finite, or beyond",
        ),
        (
            "<shape type='sphere'><transform name='to_world'><translate x='1e40'/></transform></shape>",
            "a sphere of radius",
        ),
    ] {
        let e = error(shape);
        assert!(e.starts_with("scene.xml:2:1: <shape") && e.contains(what), "{e}");
    }
}
