//! Files and options of `render image`: nothing is lost, nothing is ignored.

mod support;

use render::image::read;
use std::fs;
use support::Folder;

/// A ball and a floor with a texture; what the hash of the cache file must see are parameters.
const SCENE: &str = r#"<scene version="3.0.0">
    <default name="k" value="1"/><default name="wrap" value="repeat"/><default name="flat" value="false"/>
    <default name="filter" value="nearest"/><default name="stddev" value="0.5"/><default name="depth" value="4"/>
    <default name="texels" value="texels.png"/>
    <integrator type="path"><integer name="max_depth" value="$depth"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="12"/><integer name="height" value="8"/>
            <rfilter type="gaussian"><float name="stddev" value="$stddev"/></rfilter>
        </film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <shape type="obj">
        <string name="filename" value="bent.obj"/><boolean name="face_normals" value="$flat"/>
        <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/><translate y="-1"/></transform>
        <bsdf type="diffuse"><texture type="bitmap" name="reflectance">
            <string name="filename" value="$texels"/><string name="filter_type" value="$filter"/>
            <string name="wrap_mode" value="$wrap"/><transform name="to_uv"><scale x="$k" y="$k"/></transform>
        </texture></bsdf>
    </shape>
</scene>"#;

const BENT: &str = "v -1 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv 0 1 1\nv 1 1 0\nvn -1 0 1\nvn 0 0 1\nvn 1 0 1\n\
    f 1//1 2//2 5//2 4//1\nf 2//2 3//3 6//3 5//2\n";

fn folder() -> Folder {
    let f = Folder::with(SCENE, &[]);
    fs::write(f.path("bent.obj"), BENT).unwrap();
    for (name, pixels) in [("texels.png", [[0.2; 3], [0.8; 3]]), ("others.png", [[0.8; 3], [0.2; 3]])] {
        let image = render::image::Image { width: 2, height: 1, pixels: pixels.to_vec() };
        render::image::write_png(&f.path(name), &image).unwrap();
    }
    f
}

/// The one line of a refusal.
fn refusal(f: &Folder, args: &str) -> String {
    let err = f.bad(args, "");
    assert!(err.starts_with("render: ") && err.lines().count() == 1, "{args}: {err}");
    err
}

/// What changes light makes a cache file stale; what the camera alone sees does not.
#[test]
fn a_cache_is_of_its_scene() {
    let f = folder();
    let base = "image scene.xml --method irradiance -o a.exr --cache c";
    let run = &format!("{base} --tau 0.2 --spp 1");
    f.ok(run);
    let kept = fs::read(f.path("c")).unwrap();
    for (change, what) in [
        ("-D k=7", "materials"),
        ("-D wrap=mirror", "materials"),
        ("-D filter=bilinear", "materials"),
        ("-D texels=others.png", "materials"),
        ("-D flat=true", "scene"),
        ("-D depth=5", "scene"),
        ("--max-depth 3", "scene"),
        ("--indirect-only", "part of the light"),
    ] {
        let err = refusal(&f, &format!("{run} {change}"));
        assert!(err.contains("c: the cache was filled for another") && err.contains(what), "{change}: {err}");
        assert!(fs::read(f.path("c")).unwrap() == kept, "{change}");
    }
    for change in ["-D stddev=1 --tau 0.2", "--width 16 --tau 0.2", "--tau 0.15"] {
        fs::write(f.path("c"), &kept).unwrap();
        f.ok(&format!("{base} --spp 2 {change}"));
        assert!(fs::read(f.path("c")).unwrap() != kept, "{change}: asks for more");
    }
}

#[test]
fn outputs_are_looked_at_before_the_work() {
    let f = folder();
    fs::create_dir(f.path("taken.exr")).unwrap();
    let scene = fs::read(f.path("scene.xml")).unwrap();
    let cached = "--method irradiance --tau 0.2";
    for (outputs, what) in [
        ("-o nowhere/a.exr --time 60", "nowhere/a.exr: there is no directory nowhere"),
        ("-o good.png -o nowhere/a.exr --spp 4000000", "nowhere/a.exr: there is no directory"),
        ("-o taken.exr --time 60", "taken.exr: is a directory, not a file"),
        ("-o a.exr -o ./a.exr --time 60", "./a.exr: is written twice by this command, as a.exr"),
        ("-o a.exr --stats scene.xml --time 60", "scene.xml: is read by this command too"),
        ("-o a.exr --stats nowhere/s.json --time 60", "nowhere/s.json: there is no"),
        ("-o a.exr --stats bent.obj --time 60", "bent.obj: is read by this command too"),
        ("-o a.exr -o texels.png --time 60", "texels.png: is read by this command too"),
        (&format!("-o a.exr {cached} --spp 4000000 --cache nowhere/c"), "nowhere/c: there is no"),
        (&format!("-o a.exr {cached} --spp 4000000 --cache a.exr"), "a.exr: is written twice"),
        (&format!("-o a.exr {cached} --spp 4000000 --show-records nowhere/r.png"), "nowhere/r.png: there is no"),
        (&format!("-o a.exr {cached} --spp 4000000 --show-records r.exr"), "r.exr: the name must end in .png"),
    ] {
        let err = refusal(&f, &format!("image scene.xml {outputs}"));
        assert!(err.contains(what), "{outputs}: {err}");
        assert_eq!(err.matches("No such file").count(), 0, "{err}");
    }
    assert_eq!(fs::read(f.path("scene.xml")).unwrap(), scene);
    assert!(!f.path("a.exr").exists() && !f.path("good.png").exists());
    let missing = refusal(&f, "image missing.xml -o a.exr");
    assert_eq!(missing.matches("missing.xml").count(), 1, "{missing}");
    let missing = refusal(&f, "compare missing.exr missing.exr --false-color taken.exr/x.png");
    assert_eq!(missing.matches("No such file").count(), 1, "{missing}");
    assert!(refusal(&f, "compare a.png texels.png --false-color texels.png").contains("is read by this command"));
    assert!(refusal(&f, "probe scene.xml --pixel 1,1 -o scene.xml").contains("scene.xml: is a file, not a directory"));
    assert!(refusal(&f, "chart scene.xml -o scene.xml/x").contains("is a file, not a directory"));
}

/// A place that was good before the work, and is not after it, takes nothing else with it.
#[cfg(target_os = "linux")]
#[test]
fn what_can_be_written_is_written() {
    let f = folder();
    let run = "image scene.xml --spp 1 -o full.png -o good.png --stats s.json";
    std::os::unix::fs::symlink("/dev/full", f.path("full.png")).unwrap();
    let err = refusal(&f, run);
    assert!(err.contains("full.png: No space left on device") && !err.contains("good.png"), "{err}");
    assert!(read(&f.path("good.png")).is_ok() && f.path("s.json").exists());
    let (out, _) = f.ok("image scene.xml --spp 1 -o a.exr --stats /dev/stdout");
    assert!(serde_json::from_str::<serde_json::Value>(&out).is_ok(), "{out}");
    // A limit of the shell on the size of files, in blocks of 512 or 1024 bytes: the picture is larger, the figures are not.
    let binary = assert_cmd::cargo::cargo_bin("render");
    let script = format!(
        "ulimit -f 4; exec {} image scene.xml --spp 1 --width 128 -o large.exr --stats small.json",
        binary.display()
    );
    let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(f.folder.path()).output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && err.contains("large.exr: File too large"), "{:?} {err}", output.status);
    assert!(f.path("small.json").exists() && !f.path("large.exr").exists());
    let left = fs::read_dir(f.folder.path()).unwrap().filter(|e| {
        let name = e.as_ref().unwrap().file_name();
        name.to_string_lossy().ends_with(".tmp")
    });
    assert_eq!(left.count(), 0, "temporary files are left");
}

#[cfg(target_os = "linux")]
#[test]
fn a_film_that_does_not_fit_is_refused() {
    let f = folder();
    let binary = assert_cmd::cargo::cargo_bin("render");
    let script = format!(
        "ulimit -v 4000000; exec {} image scene.xml --width 8192 --height 8192 --spp 1 --threads 1 -o a.exr",
        binary.display()
    );
    let output = std::process::Command::new("sh").args(["-c", &script]).current_dir(f.folder.path()).output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{err}");
    assert!(err.contains("a film of 8192 × 8192 pixels needs 10.") && err.contains("--crop"), "{err}");
    assert_eq!(err.lines().count(), 1, "{err}");
}

#[test]
fn options_that_a_method_cannot_use_are_refused() {
    let f = folder();
    let records = "--method auto, eas, sh or irradiance";
    for (options, needs) in [
        ("--cache c", records),
        ("--tau 0.1", records),
        ("--radius hessian", records),
        ("--adaptive", records),
        ("--show-records r.png", records),
        ("--eas paper", "--method auto or eas"),
        ("--eas improved", "--method auto or eas"),
        ("--sources 16", "--method auto or eas"),
        ("--tables tables", "--method auto or eas"),
        ("--tables nowhere --method sh", "--method auto or eas"),
        ("--sources 16 --method irradiance", "--method auto or eas"),
        ("--order 5", "--method sh"),
        ("--basis spherical --method auto", "--method sh"),
        ("--gradients none --method eas", "--method sh"),
        ("--error 0.1 --method sh", "--method path"),
    ] {
        let err =
            refusal(&f, &format!("image scene.xml -o a.exr --spp 1 {options}").replace("--spp 1 --error", "--error"));
        let option = options.split(' ').next().unwrap();
        assert!(err.contains(&format!("render: {option} needs {needs}: ")), "{options}: {err}");
    }
    for (options, what) in [
        ("--orders 3 --methods path,eas", "--orders needs one of the --methods sh"),
        ("--sources 10 --methods sh", "--sources needs one of the --methods eas"),
        ("--taus 0.1 --methods path", "--taus needs one of the --methods irradiance"),
        ("--tables t --methods path,irradiance", "--tables needs one of the --methods eas"),
        ("--spp 4 --methods path", "--spp needs runs without a time budget"),
        ("--reference a.exr --reference-time 3", "--reference-time"),
    ] {
        let err = refusal(&f, &format!("chart scene.xml -o out {options}"));
        assert!(err.contains(what), "{options}: {err}");
    }
    assert!(!f.path("out").exists());
}

/// Every number: not a number, without end, of the wrong sign.
#[test]
fn numbers_are_refused_with_what_is_allowed() {
    let f = folder();
    let image = "image scene.xml -o a.exr";
    for (command, option, allowed) in [
        (image, "--max-depth", "a whole number from 1 to 4294967295; leave it out for the scene's own"),
        (image, "--spp", "a whole number from 1 to 4194304"),
        (image, "--width", "a whole number from 1 to 32768"),
        (image, "--height", "a whole number from 1 to 32768"),
        (image, "--threads", "a whole number from 1 to 1024"),
        (image, "--seed", "a whole number from 0 to"),
        (image, "--sources", "a whole number from 7 to 4096"),
        (image, "--order", "a whole number from 1 to 29"),
        (image, "--time", "seconds > 0"),
        (image, "--error", "a number > 0"),
        (image, "--tau", "a number from 0.0005 to 1"),
        (image, "--adaptive", "a fraction from 0.001 to 1"),
        ("probe scene.xml --pixel 1,1 -o out", "--tau", "a number from 0.0005 to 1"),
        ("probe scene.xml --pixel 1,1 -o out", "--width", "a whole number from 1 to 32768"),
        ("compare a.exr b.exr", "--fail-above", "a number ≥ 0"),
        ("compare a.exr b.exr --z-test", "--reference-spp", "a whole number from 1 to"),
        ("chart scene.xml -o out", "--times", "seconds > 0"),
        ("chart scene.xml -o out", "--taus", "a number from 0.0005 to 1"),
        ("chart scene.xml -o out", "--reference-error", "a number > 0"),
        ("chart scene.xml -o out", "--reference-time", "seconds > 0"),
        ("chart scene.xml -o out", "--orders", "a whole number from 1 to 29"),
    ] {
        for value in ["-1", "nan", "inf", "NaN", "x", "1e999"] {
            let err = refusal(&f, &format!("{command} {option} {value}"));
            assert!(err.contains(option) && err.contains(value) && err.contains(allowed), "{option} {value}: {err}");
            let finite = !allowed.starts_with("a whole") && ["nan", "inf", "NaN", "1e999"].contains(&value);
            assert!(!finite || err.contains("not a finite number"), "{option} {value}: {err}");
        }
        if option != "--adaptive" {
            let err = refusal(&f, &format!("{command} {option} -inf"));
            assert!(err.contains(option) && err.contains(allowed), "{option} -inf: {err}");
        }
    }
}
