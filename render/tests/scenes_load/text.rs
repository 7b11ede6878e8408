//! Scene text: parameters, includes, references, transforms, numbers, and where errors point.

use crate::{Folder, error, scene, scene_text, warning};
use glam::{Vec3, Vec3A};
use render::scene::{Geometry, Light};

/// Position of the only light.
fn position(body: &str) -> Vec3A {
    match scene(body).lights.as_slice() {
        [Light::Point { position, .. }] => *position,
        other => panic!("{other:?}"),
    }
}

/// Where a transform takes the origin and the x axis.
fn transform(operations: &str) -> (Vec3, Vec3) {
    let body = format!("<shape type='rectangle'><transform name='to_world'>{operations}</transform></shape>");
    let scene = scene(&body);
    let Geometry::Mesh(mesh) = &scene.shapes[0].geometry else { panic!() };
    let (a, b) = (mesh.positions[0], mesh.positions[1]);
    ((mesh.positions[0] + mesh.positions[2]) / 2.0, (b - a) / 2.0)
}

fn near(a: Vec3, b: [f32; 3]) {
    assert!((a - Vec3::from(b)).abs().max_element() < 1e-5, "{a} is not {b:?}");
}

#[test]
fn defaults_yield_to_the_caller_and_to_earlier_ones() {
    let text = "<default name='w' value='10'/><default name='w' value='20'/><default name='path' value='a$w'/>
        <sensor type='perspective'><film type='hdrfilm'><integer name='width' value='$w'/></film></sensor>
        <bsdf type='diffuse' id='x_$path'/>";
    let folder = Folder::new().with("scene.xml", format!("<scene version='3.0.0'>{text}</scene>"));
    assert_eq!(folder.load("scene.xml", &[]).unwrap().0.camera.film.width, 10);
    assert_eq!(folder.load("scene.xml", &[("w", "30")]).unwrap().0.camera.film.width, 30);
    let (_, warnings) = folder.load("scene.xml", &[("wdith", "30")]).unwrap();
    assert_eq!(warnings, ["-D wdith: the scene has no such parameter"]);
}

/// As Mitsuba puts parameters in: the longest name that is known, wherever it stands.
#[test]
fn parameters_stand_anywhere_in_a_value() {
    let body = "<default name='n' value='1'/><default name='na' value='2'/><default name='nab' value='3'/>
        <default name='a-b.c' value='4'/><default name='none' value=''/>";
    for (value, expected) in [
        ("$n$na", 12.0),
        ("$nax1", 0.0),
        ("$nab$n$none", 31.0),
        ("$na5", 25.0),
        ("$no", 0.0),
        ("0.$n$n", 0.11),
        ("$n.5", 1.5),
        ("$a-b.c", 4.0),
        ("-$n", -1.0),
        ("$n${n}", 0.0),
    ] {
        let light = format!("{body}<emitter type='point'><point name='position' x='{value}' y='0' z='0'/></emitter>");
        match Folder::new().scene(&light) {
            Ok((scene, _)) => assert!(
                matches!(scene.lights[0], Light::Point { position, .. } if (position.x - expected).abs() < 1e-6),
                "{value}: {:?}",
                scene.lights
            ),
            Err(e) => assert!(expected == 0.0 && e.contains("position"), "{value}: {e}"),
        }
    }
    let scene = scene("<bsdf type='diffuse' id='a\\$n'/><shape type='sphere'><ref id='a\\$n'/></shape>");
    assert_eq!(scene.material_names, ["a$n"]);
}

#[test]
fn undefined_parameter_names_its_place() {
    let e = error("<shape type='sphere'>\n  <float name='radius' value='$r'/></shape>");
    assert_eq!(
        e,
        "scene.xml:3:3: <float name=\"radius\">: the parameter $r has no value: add a <default> or give -D r=…"
    );
}

#[test]
fn columns_count_characters() {
    let e = error("<!-- ÄÖÜ --> <shape type='sphere'><float name='radius' value='x'/></shape>");
    assert!(e.starts_with("scene.xml:2:35: <float name=\"radius\">: `x` is not a number"), "{e}");
}

#[test]
fn parameters_cannot_grow_without_end() {
    let mut body = String::from("<default name='a' value='0123456789'/>");
    for (i, name) in ('b'..'m').enumerate() {
        let before = (b'a' + i as u8) as char;
        body += &format!("<default name='{name}' value='{}'/>", format!("${before}").repeat(10));
    }
    assert!(error(&body).contains("grows beyond"));
}

#[test]
fn includes_share_parameters_and_ids() {
    let folder =
        Folder::new().with("parts/light.xml", "<scene version='3.0.0'><include filename='deeper.xml'/></scene>").with(
            "parts/deeper.xml",
            "<scene version='3.0.0'><emitter type='point'><point name='position' x='$x' y='0' z='0'/></emitter>
             <bsdf type='diffuse' id='shared'/></scene>",
        );
    let body = "<default name='x' value='7'/><include filename='parts/light.xml'/>
        <shape type='sphere'><ref id='shared'/></shape>";
    let (scene, _) = folder.scene(body).unwrap();
    assert!(matches!(scene.lights[0], Light::Point { position, .. } if position.x == 7.0));
    assert_eq!(scene.material_names, ["shared"]);
}

#[test]
fn cyclic_includes_are_refused() {
    let folder = Folder::new()
        .with("a.xml", "<scene version='3.0.0'><include filename='b.xml'/></scene>")
        .with("b.xml", "<scene version='3.0.0'>\n<include filename='a.xml'/></scene>");
    assert_eq!(folder.load("a.xml", &[]).unwrap_err(), "b.xml:2:1: <include>: a.xml includes itself");
}

#[test]
fn includes_that_double_are_refused() {
    let mut folder = Folder::new();
    for i in 0..20 {
        let include = format!("<include filename='{}.xml'/>", i + 1);
        folder = folder.with(&format!("{i}.xml"), format!("<scene version='3.0.0'>{include}{include}</scene>"));
    }
    folder = folder.with("20.xml", "<scene version='3.0.0'/>");
    assert!(folder.load("0.xml", &[]).unwrap_err().contains("more than 10000 files included"));
}

#[test]
fn missing_include_names_the_element() {
    let e = error("<include filename='gone.xml'/>");
    assert!(e.starts_with("scene.xml:2:1: <include>: gone.xml: cannot read: "), "{e}");
}

#[test]
fn references_work_in_any_order_and_may_not_be_cyclic() {
    let s = scene(
        "<shape type='sphere'><ref id='b'/></shape><bsdf type='twosided' id='b'><ref id='a'/></bsdf><bsdf type='diffuse' id='a'/>",
    );
    assert_eq!(s.material_names, ["a", "b"]);
    let e =
        error("<bsdf type='twosided' id='a'><ref id='b'/></bsdf>\n<bsdf type='twosided' id='b'><ref id='a'/></bsdf>");
    assert!(e.contains("contains this reference"), "{e}");
    let e = error("<shape type='sphere'><ref id='gone'/></shape>");
    assert_eq!(e, "scene.xml:2:22: <ref id=\"gone\">: nothing has the id `gone`");
    let e = error("<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>");
    assert!(e.ends_with("the id `a` is used twice"), "{e}");
    let aliased =
        scene("<bsdf type='diffuse' id='a'/><alias id='a' as='c'/><shape type='sphere'><ref id='c'/></shape>");
    assert_eq!(aliased.material_names, ["a"]);
}

#[test]
fn transforms_apply_in_order_from_the_left() {
    let (origin, x) = transform("<translate x='1'/><scale value='2'/><rotate z='1' angle='90'/>");
    near(origin, [0.0, 2.0, 0.0]);
    near(x, [0.0, 2.0, 0.0]);
    let (origin, x) = transform("<scale x='2' y='3'/><matrix value='0 -1 0 5  1 0 0 6  0 0 1 7  0 0 0 1'/>");
    near(origin, [5.0, 6.0, 7.0]);
    near(x, [0.0, 2.0, 0.0]);
    let (origin, x) = transform("<matrix value='0 -1 0 1 0 0 0 0 1'/><translate value='1, 2 3'/>");
    near(origin, [1.0, 2.0, 3.0]);
    near(x, [0.0, 1.0, 0.0]);
    for name in ["lookat", "lookAt"] {
        // Mitsuba's frame has x to the left: looking along −z with y up, x is −x.
        let (origin, x) = transform(&format!("<{name} origin='0 0 4' target='0 0 0' up='0 1 0'/>"));
        near(origin, [0.0, 0.0, 4.0]);
        near(x, [-1.0, 0.0, 0.0]);
    }
    let (_, x) = transform("<lookat origin='0 0 0' target='0 0 1'/>");
    assert!((x.length() - 1.0).abs() < 1e-6 && x.z.abs() < 1e-6);
}

#[test]
fn singular_transforms_are_refused() {
    for (operation, what) in [
        ("<scale x='0'/>", "singular"),
        ("<rotate angle='10'/>", "the axis is zero"),
        ("<lookat origin='1 2 3' target='1 2 3' up='0 1 0'/>", "coincide"),
        ("<lookat origin='0 0 0' target='0 1 0' up='0 1 0'/>", "parallel"),
        ("<matrix value='1 2 3'/>", "9 or 16"),
        ("<matrix value='1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1'/>", "last row"),
        ("<translate x='nan'/>", "not finite"),
        ("<shear x='1'/>", "no such transform"),
    ] {
        let e = error(&format!("<shape type='cube'><transform name='to_world'>{operation}</transform></shape>"));
        assert!(e.starts_with("scene.xml:2:") && e.contains(what), "{e}");
    }
}

#[test]
fn points_and_numbers() {
    assert_eq!(
        position("<emitter type='point'><point name='position' value='1, 2, 3'/></emitter>"),
        Vec3A::new(1., 2., 3.)
    );
    assert_eq!(
        position("<emitter type='point'><point name='position' x='1e2' z='-3'/></emitter>"),
        Vec3A::new(100., 0., -3.)
    );
    assert!(error("<shape type='sphere'><float name='radius' value='1,5'/></shape>").contains("`1,5` is not a number"));
    assert!(
        error("<shape type='sphere'><boolean name='flip_normals' value='yes'/></shape>")
            .contains("neither true nor false")
    );
    for (word, value) in [("True", true), ("TRUE", true), (" true ", true), ("1", true), ("False", false), ("0", false)]
    {
        let body = format!("<shape type='sphere'><boolean name='flip_normals' value='{word}'/></shape>");
        assert!(matches!(&scene(&body).shapes[0].geometry, Geometry::Sphere(s) if s.inward == value), "{word}");
    }
    for (word, value) in [("2.5f", 2.5), ("1.F", 1.0), ("+3", 3.0), (" .5 ", 0.5), ("2e0", 2.0)] {
        let x = position(&format!("<emitter type='point'><point name='position' x='{word}' y='0' z='0'/></emitter>")).x;
        assert_eq!(x, value, "{word}");
    }
    assert!(error("<shape type='sphere'><float name='radius' value='5mm'/></shape>").contains("`5mm` is not a number"));
    assert!(error("<shape type='sphere'><string name='radius' value='1'/></shape>").contains("a number is needed"));
    assert!(
        error("<shape type='sphere'><float name='radius' value='1'/><float name='radius' value='2'/></shape>")
            .contains("given twice")
    );
}

#[test]
fn camel_case_and_snake_case_are_the_same() {
    let body = "<shape type='cube'><transform name='toWorld'><translate x='2'/></transform>
        <boolean name='flipNormals' value='true'/></shape>";
    let folder = Folder::new().with("old.xml", scene_text("0.6.0", body)).with("new.xml", scene_text("3.0.0", body));
    let (old, warnings) = folder.load("old.xml", &[]).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(old.shapes, folder.load("new.xml", &[]).unwrap().0.shapes);
}

#[test]
fn unused_parameters_are_named() {
    let w = warning("<shape type='sphere'>\n<float name='raduis' value='2'/></shape>");
    assert_eq!(w, "scene.xml:3:1: <float name=\"raduis\">: `raduis` has no effect in `sphere`");
}

#[test]
fn broken_text_names_the_line() {
    for (text, what) in [
        ("<scene version='3.0.0'>\n<shape></scene>", "broken.xml:2: "),
        (
            "<scene version='0.2.1'/>",
            "broken.xml:1:1: <scene>: version `0.2.1` (0.3 to 0.6, 2.x and 3.x are supported)",
        ),
        ("<scene/>", "no sensor"),
        ("<scene version='9'/>", "broken.xml:1:1: <scene>: version `9`"),
        ("<secne version='3.0.0'/>", "must be <scene>"),
        ("<scene version='3.0.0'/>", "no sensor"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><scene version='3.0.0'/>", "broken.xml:1: "),
        ("", "broken.xml:1: "),
    ] {
        let e = Folder::new().with("broken.xml", text).load("broken.xml", &[]).unwrap_err();
        assert!(e.contains(what), "{e}");
    }
    let e = Folder::new().with("binary.xml", [0xff, 0xfe, 0x00]).load("binary.xml", &[]).unwrap_err();
    assert_eq!(e, "binary.xml: damaged UTF-16LE text");
    let e = Folder::new().load("gone.xml", &[]).unwrap_err();
    assert!(e.starts_with("gone.xml: cannot read: "), "{e}");
    let e = Folder::new().with("scene.abc", "").load("scene.abc", &[]).unwrap_err();
    assert!(e.contains("the extension must be xml (Mitsuba), gltf or glb"), "{e}");
}

#[test]
fn text_of_a_file_stays_out_of_messages() {
    let long = "x".repeat(100_000);
    for body in [
        format!("<shape type='sphere'><float name='radius' value='{long}'/></shape>"),
        format!("<shape type='{long}'/>"),
        format!("<shape type='obj'><string name='filename' value='{long}'/></shape>"),
        "<shape type='a&#10;b'><string name='c&#10;d' value='e&#10;f'/></shape>".into(),
        "<shape type='obj'><string name='filename' value='e&#10;f.obj'/></shape>".into(),
    ] {
        let e = error(&body);
        assert!(e.len() < 1000 && !e.contains('\n'), "{e}");
    }
}

#[test]
fn a_scene_without_version_tells_it_by_its_names() {
    let version = |body: &str| {
        let text =
            format!("<scene>{body}<emitter type='constant'><spectrum name='radiance' value='1'/></emitter></scene>");
        let (scene, warnings) = Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        let neutral = scene.environment == Some(render::scene::Environment::Constant(Vec3A::ONE));
        (warnings[0].clone(), neutral)
    };
    let (new, neutral) = version("<sensor type='perspective'><float name='near_clip' value='1'/></sensor>");
    assert!(new.ends_with("no version is given: read as version 3.0") && !neutral, "{new}");
    let (old, neutral) = version("<sensor type='perspective'><float name='nearClip' value='1'/></sensor>");
    assert!(old.ends_with("read as version 0.6") && neutral, "{old}");
    let (oldest, neutral) = version("<camera type='perspective'/>");
    assert!(oldest.ends_with("read as version 0.3") && neutral, "{oldest}");
}

/// Each name that Mitsuba's upgrade to 0.4 changes.
#[test]
fn names_of_version_0_3() {
    let text = "<scene version='0.3.0'><camera type='perspective'><float name='fov' value='40'/>
        <boolean name='mapSmallerSide' value='False'/><transform name='toWorld'><translate z='2'/></transform>
        <sampler type='ldsampler'><integer name='sampleCount' value='8'/><integer name='depth' value='3'/></sampler>
        <film type='exrfilm'><integer name='width' value='20'/><integer name='height' value='40'/>
        <boolean name='alpha' value='false'/></film></camera>
        <luminaire type='constant'><spectrum name='intensity' value='2'/></luminaire>
        <luminaire type='directional'><rgb name='intensity' value='3'/><vector name='direction' z='1'/></luminaire>
        <luminaire type='point'><rgb name='intensity' value='4'/></luminaire>
        <shape type='sphere'><luminaire type='area'><blackbody name='intensity' temperature='5000' multiplier='1e-4'/>
        </luminaire></shape></scene>";
    let (scene, warnings) = Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap();
    assert_eq!(warnings, ["s.xml:1:1: <scene>: version 0.3.0 is read by Mitsuba's rules of upgrade"]);
    let camera = &scene.camera;
    assert!((camera.to_world.matrix3.determinant() + 1.0).abs() < 1e-6 && camera.to_world.translation.z == 2.0);
    let render::scene::Projection::Perspective { fov_x } = camera.projection else { panic!() };
    let larger = 2.0 * (0.5 * 20f32.to_radians().tan()).atan();
    assert!((fov_x - larger).abs() < 1e-6, "{fov_x}");
    assert_eq!(scene.integrator.spp, 8);
    assert_eq!(scene.environment, Some(render::scene::Environment::Constant(Vec3A::splat(2.0))));
    assert!(matches!(scene.lights[0], Light::Directional { irradiance, .. } if irradiance == Vec3A::splat(3.0)));
    assert!(matches!(scene.lights[1], Light::Point { intensity, .. } if intensity == Vec3A::splat(4.0)));
    let radiance = &scene.shapes[0].emitter.as_ref().unwrap().radiance;
    assert!(matches!(radiance, render::scene::ColorTexture::Constant(c) if (1.0..2.0).contains(&c.y)), "{radiance:?}");
    let smaller = text.replace("<boolean name='mapSmallerSide' value='False'/>", "");
    let (scene, _) = Folder::new().with("s.xml", smaller).load("s.xml", &[]).unwrap();
    assert_eq!(scene.camera.projection, render::scene::Projection::Perspective { fov_x: 40f32.to_radians() });
}

#[test]
fn an_included_file_may_be_one_element() {
    let folder = Folder::new().with("grey.xml", "<bsdf type='diffuse' version='3.0.0' id='grey'/>");
    let (scene, _) =
        folder.scene("<include filename='grey.xml'/><shape type='sphere'><ref id='grey'/></shape>").unwrap();
    assert_eq!(scene.material_names, ["grey"]);
}

#[test]
fn deep_nesting_is_refused() {
    let deep = format!("{}{}", "<bsdf type='twosided'>".repeat(5000), "</bsdf>".repeat(5000));
    assert!(error(&deep).contains("inside each other"), "deep");
}
