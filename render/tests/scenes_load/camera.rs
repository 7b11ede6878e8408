//! Sensor, film, filter, sampler, integrator.

use crate::{Folder, Loaded};
use render::scene::{Camera, Crop, Filter, Projection};

fn sensor(body: &str) -> Loaded {
    let text = format!("<scene version='3.0.0'>\n<sensor type='perspective'>{body}</sensor></scene>");
    Folder::new().with("scene.xml", text).load("scene.xml", &[])
}

fn opening(camera: &Camera) -> f32 {
    let Projection::Perspective { fov_x } = camera.projection else { panic!("{camera:?}") };
    fov_x
}

fn fov_x(axis: &str, width: u32, height: u32) -> f32 {
    let film = format!(
        "<film type='hdrfilm'><integer name='width' value='{width}'/><integer name='height' value='{height}'/></film>"
    );
    let axis = format!("<float name='fov' value='60'/><string name='fov_axis' value='{axis}'/>{film}");
    opening(&sensor(&axis).unwrap().0.camera).to_degrees()
}

#[test]
fn every_axis_of_the_field_of_view() {
    let of_height = |aspect: f32| 2.0 * (aspect * 30f32.to_radians().tan()).atan().to_degrees();
    let of_diagonal = |aspect: f32| {
        let half_diagonal = 30f32.to_radians().tan();
        2.0 * (half_diagonal * aspect / (1.0 + aspect * aspect).sqrt()).atan().to_degrees()
    };
    for (axis, width, height, expected) in [
        ("x", 400, 200, 60.0),
        ("y", 400, 200, of_height(2.0)),
        ("smaller", 400, 200, of_height(2.0)),
        ("smaller", 200, 400, 60.0),
        ("larger", 400, 200, 60.0),
        ("larger", 200, 400, of_height(0.5)),
        ("diagonal", 400, 200, of_diagonal(2.0)),
    ] {
        let got = fov_x(axis, width, height);
        assert!((got - expected).abs() < 1e-3, "{axis} {width}×{height}: {got}, not {expected}");
    }
    // A 50 mm lens on 36 mm × 24 mm film, cut to a square picture.
    let square = "<film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/></film>";
    let normal = opening(&sensor(square).unwrap().0.camera).to_degrees();
    let expected = 2.0 * (0.5 * 36f32.hypot(24.0) / 50.0 / 2f32.sqrt()).atan().to_degrees();
    assert!((normal - expected).abs() < 1e-3);
    let tele = sensor(&format!("<string name='focal_length' value='100mm'/>{square}")).unwrap().0.camera;
    assert!(opening(&tele) < 0.55 * normal.to_radians());
}

/// What Mitsuba 3.9 shows in each case: columns of 64 and rows of 40 that a square of 2 × 2 before the camera fills.
#[test]
fn principal_points_move_the_picture_as_in_mitsuba() {
    let film = "<film type='hdrfilm'><integer name='width' value='64'/><integer name='height' value='40'/></film>";
    let edges = |kind: &str, parameters: &str, operations: &str| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='{kind}'>{film}{parameters}<transform name='to_world'>{operations}
             <lookat origin='0 0 4' target='0 0 0' up='0 1 0'/></transform></sensor></scene>"
        );
        let camera = Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap().0.camera;
        let rays = render::camera::RayGenerator::new(&camera);
        let corners = [(-0.8, 1.1), (1.2, -0.9)].map(|(x, y)| rays.project(glam::Vec3A::new(x, y, 0.0)).unwrap());
        let [(a, top), (b, bottom)] = corners;
        [a.min(b), a.max(b), top, bottom].map(|e| e.round() as i32)
    };
    let fov = "<float name='fov' value='50'/>";
    let shift = "<float name='principal_point_offset_x' value='0.2'/>
        <float name='principal_point_offset_y' value='-0.1'/>";
    let both = format!("{fov}{shift}");
    assert_eq!(edges("perspective", fov, ""), [18, 53, 1, 35]);
    assert_eq!(edges("perspective", &both, ""), [5, 40, 5, 39]);
    assert_eq!(edges("perspective", &both, "<scale x='-1'/>"), [-1, 33, 5, 39]);
    // An orthographic sensor, which in Mitsuba has no principal point, moves the same way.
    assert_eq!(edges("orthographic", "", "<scale x='2' y='2'/>"), [19, 51, 2, 34]);
    assert_eq!(edges("orthographic", shift, "<scale x='2' y='2'/>"), [6, 38, 6, 38]);
}

#[test]
fn film_crop_and_filter() {
    let film = "<film type='hdrfilm'><integer name='width' value='100'/><integer name='height' value='50'/>
        <integer name='crop_offset_x' value='10'/><integer name='crop_offset_y' value='20'/>
        <integer name='crop_width' value='30'/><integer name='crop_height' value='5'/>
        <string name='pixel_format' value='rgba'/><string name='component_format' value='float32'/>
        <rfilter type='tent'><float name='radius' value='1.5'/></rfilter></film>";
    let (scene, warnings) = sensor(film).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(scene.camera.film.crop, Some(Crop { x: 10, y: 20, width: 30, height: 5 }));
    assert_eq!(scene.camera.film.filter, Filter::Tent { radius: 1.5 });
    for (filter, expected) in [
        ("box", Filter::Box { radius: 0.5 }),
        ("gaussian", Filter::Gaussian { stddev: 0.5 }),
        ("lanczos", Filter::Gaussian { stddev: 0.5 }),
    ] {
        let (scene, warnings) = sensor(&format!("<film type='hdrfilm'><rfilter type='{filter}'/></film>")).unwrap();
        assert_eq!((scene.camera.film.filter, warnings.len()), (expected, usize::from(filter == "lanczos")));
    }
    let outside = film.replace("'30'", "'91'");
    assert!(sensor(&outside).unwrap_err().contains("in a film of 100 × 50"));
    assert!(sensor("<film type='hdrfilm'><integer name='width' value='0'/></film>").is_err());
    assert!(sensor("<film type='hdrfilm'><integer name='width' value='4000000000'/></film>").is_err());
    let luminance = "<film type='hdrfilm'><string name='pixel_format' value='luminance'/></film>";
    assert!(sensor(luminance).unwrap().1[0].contains("pixel format `luminance`: the picture is written as rgb"));
}

#[test]
fn placement_loses_its_scale_and_may_mirror() {
    let at = |operations: &str| sensor(&format!("<transform name='to_world'>{operations}</transform>"));
    let camera = at("<scale value='5'/><translate z='3'/>").unwrap().0.camera;
    assert!((camera.to_world.matrix3.determinant() - 1.0).abs() < 1e-5 && camera.to_world.translation.z == 3.0);
    let mirrored = at("<scale x='-1'/>").unwrap().0.camera;
    assert!((mirrored.to_world.matrix3.determinant() + 1.0).abs() < 1e-5);
    assert!(at("<scale x='2'/>").unwrap_err().contains("distorts"));
}

/// x and y are scaled to what the film shows, z moves the near plane.
#[test]
fn orthographic_sensors() {
    let at = |operations: &str| {
        let text = format!(
            "<scene version='3.0.0'><sensor type='orthographic'><float name='near_clip' value='0.5'/>
             <float name='far_clip' value='9'/><transform name='to_world'>{operations}</transform></sensor></scene>"
        );
        Folder::new().with("s.xml", text).load("s.xml", &[])
    };
    let (scene, warnings) = at("<scale x='10' y='10'/><rotate y='1' angle='90'/><translate z='3'/>").unwrap();
    let camera = scene.camera;
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(camera.projection, Projection::Orthographic { half_width: 10.0 });
    assert!((camera.to_world.matrix3.z_axis - glam::Vec3A::X).length() < 1e-6 && camera.to_world.translation.z == 3.0);
    assert_eq!((camera.near, camera.far), (0.5, 9.0));
    let deep = at("<scale x='2' y='2' z='4'/>").unwrap().0.camera;
    assert_eq!((deep.near, deep.far), (2.0, 10.5));
    for (wrong, what) in
        [("<scale x='2' y='3'/>", "distorts"), ("<scale x='0'/>", "singular"), ("<scale z='0'/>", "singular")]
    {
        let e = at(wrong).unwrap_err();
        assert!(e.contains(what), "{e}");
    }
}

#[test]
fn settings_of_integrator_and_sampler() {
    let text = "<scene version='0.5.0'><integrator type='path'><integer name='maxDepth' value='7'/>
        <integer name='rrDepth' value='3'/><boolean name='hideEmitters' value='true'/></integrator>
        <sensor type='perspective'><sampler type='ldsampler'><integer name='sampleCount' value='99'/></sampler></sensor></scene>";
    let (scene, warnings) = Folder::new().with("s.xml", text).load("s.xml", &[]).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let i = scene.integrator;
    assert_eq!((i.max_depth, i.rr_depth, i.hide_emitters, i.spp), (7, 3, true, 99));
    let endless = text.replace("'7'", "'-1'");
    assert_eq!(Folder::new().with("s.xml", endless).load("s.xml", &[]).unwrap().0.integrator.max_depth, u32::MAX);
    let wrong = text.replace("'7'", "'-2'");
    assert!(Folder::new().with("s.xml", wrong).load("s.xml", &[]).unwrap_err().contains("`max_depth` must be"));
    let other = text.replace("'path'", "'ppm'");
    let (_, warnings) = Folder::new().with("s.xml", other).load("s.xml", &[]).unwrap();
    assert!(warnings[0].contains("`ppm` is not known: path tracing is used"), "{warnings:?}");
}

#[test]
fn wrong_sensors_are_refused() {
    for (body, what) in [
        ("<float name='fov' value='180'/>", "180 degrees"),
        ("<string name='fov_axis' value='z'/><float name='fov' value='18'/>", "`z`"),
        ("<string name='focal_length' value='-5mm'/>", "focal length"),
        ("<film type='hdrfilm'><rfilter type='box'><float name='radius' value='1e9'/></rfilter></film>", "filter"),
        ("<float name='near_clip' value='5'/><float name='far_clip' value='1'/>", "clip"),
    ] {
        let e = sensor(body).unwrap_err();
        assert!(e.contains(what), "{e}");
    }
    let fisheye = "<scene version='3.0.0'>\n <sensor type='fisheye'/></scene>";
    let e = Folder::new().with("s.xml", fisheye).load("s.xml", &[]).unwrap_err();
    assert_eq!(
        e,
        "s.xml:2:2: <sensor type=\"fisheye\">: the sensor `fisheye` is not supported (only `perspective`, `thinlens` and `orthographic`)"
    );
}
