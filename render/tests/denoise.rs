//! `--denoise`: options, layers, the same bytes for any number of threads, and how much noise is taken away.

mod support;

use assert_cmd::Command;
use std::path::Path;
use support::Folder;

/// Lit by a lamp on one side; a mirror shows a red wall that the camera does not see.
const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="5"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="6"/><translate z="-3"/></transform>
        <bsdf type="diffuse"/></shape>
    <shape type="rectangle"><bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="6"/><rotate y="1" angle="180"/><translate z="6"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.1, 0.1"/></bsdf></shape>
    <shape type="sphere"><point name="center" x="4" y="3" z="1"/><float name="radius" value="0.5"/>
        <emitter type="area"><rgb name="radiance" value="30"/></emitter></shape>
</scene>"#;

/// The library that the environment names, for tests of it; says so where there is none.
fn library() -> Option<String> {
    let named = std::env::var("OIDN_LIBRARY").ok().filter(|value| !value.is_empty());
    if named.is_none() {
        eprintln!("skipped: OIDN_LIBRARY names no Open Image Denoise");
    }
    named
}

fn channel(path: &Path, name: &str) -> Option<Vec<f32>> {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    Some(channels.iter().find(|c| c.name == *name)?.sample_data.values_as_f32().collect())
}

fn stats(f: &Folder) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(f.path("s.json")).unwrap()).unwrap()
}

#[test]
fn mistakes_are_named() {
    let f = Folder::with(SCENE, &[]);
    let run = "image scene.xml --spp 1 -o a.exr";
    for (options, what) in [
        ("--denoise median", "--denoise"),
        ("--denoise oidn --oidn nowhere/lib.so", "nowhere/lib.so: there is no such file or folder"),
        ("--denoise auto --oidn nowhere", "nowhere: there is no such file or folder"),
        ("--denoise oidn --oidn .", "the folder holds no Open Image Denoise (libOpenImageDenoise"),
        ("--denoise oidn --oidn scene.xml", "scene.xml: cannot be loaded: "),
        ("--denoise builtin --oidn scene.xml", "--oidn needs --denoise oidn or auto"),
        ("--denoise off --oidn scene.xml", "--oidn needs --denoise oidn or auto"),
        ("--oidn scene.xml", "--oidn needs --denoise oidn or auto"),
    ] {
        f.bad(&format!("{run} {options}"), what);
        assert!(!f.path("a.exr").exists(), "{options}");
    }
}

/// Without the library `oidn` says how to get it, `auto` that it does without, and neither happens after the work.
#[test]
fn a_missing_library_is_told() {
    let f = Folder::with(SCENE, &[]);
    let run = |options: &[&str]| {
        let mut command = Command::cargo_bin("render").unwrap();
        command.env_remove("OIDN_LIBRARY").current_dir(f.folder.path());
        let output = command.args(["image", "scene.xml", "--spp", "1", "-o", "a.exr"]).args(options).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = run(&["--denoise", "oidn"]);
    if code == Some(0) {
        eprintln!("skipped: the system has Open Image Denoise");
        return;
    }
    assert!(code == Some(2) && said.lines().count() == 1 && said.contains("pip download"), "{said}");
    let (code, said) = run(&["--denoise", "auto"]);
    assert!(code == Some(0) && said.contains("denoised by builtin") && said.contains("not installed"), "{said}");
}

/// The picture is denoised, the layers are not: they add up to the noisy one, which is that of a run without denoiser.
#[test]
fn the_noisy_picture_stays() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml --spp 32 -o noisy.exr --stats s.json");
    assert_eq!((&stats(&f)["denoiser"], stats(&f)["seconds"]["denoise"].as_f64()), (&"off".into(), Some(0.0)));
    for method in ["path", "irradiance"] {
        f.ok(&format!("image scene.xml --spp 32 --method {method} -o noisy.exr"));
        let (_, said) = f.ok(&format!(
            "image scene.xml --spp 32 --method {method} --denoise builtin -o a.exr -o a.png --stats s.json"
        ));
        assert!(said.contains("denoised by builtin in"), "{said}");
        let stats = stats(&f);
        assert!(stats["denoiser"] == "builtin" && stats["seconds"]["denoise"].as_f64() > Some(0.0), "{stats}");
        assert!(stats["fireflies"]["share"].as_f64() < Some(0.01) && stats["not_finite"] == 0, "{stats}");
        let get = |name: &str| channel(&f.path("a.exr"), name).unwrap_or_else(|| panic!("{name}"));
        let (clean, noisy) = (get("R"), get("noisy.R"));
        assert_eq!(Some(&noisy), channel(&f.path("noisy.exr"), "R").as_ref());
        assert!(clean != noisy && clean.iter().all(|x| x.is_finite() && *x >= 0.0));
        let layers = ["emission.R", "direct.diffuse.R", "direct.glossy.R", "indirect.diffuse.R", "indirect.glossy.R"];
        let layers = layers.map(get);
        for (i, w) in noisy.iter().enumerate() {
            // Layers have 11 bits.
            assert!((layers.iter().map(|l| l[i]).sum::<f32>() - w).abs() <= w.abs().max(1e-3) / 2048.0);
        }
    }
    // The variance is that of the noisy picture.
    f.ok("image scene.xml --spp 32 --denoise builtin -o a.exr");
    assert!(channel(&f.path("a.exr"), "variance.R").is_none());
    assert!(channel(&f.path("a.exr"), "noisy.variance.R").is_some());
    f.bad("compare a.exr noisy.exr --z-test", "not denoised");
}

/// With a budget of time `auto` uses records where ours denoises or nothing does, paths where the neural one does, unless an option
/// asks for records; and says which.
#[test]
fn auto_follows_the_denoiser() {
    let f = Folder::with(SCENE, &[]);
    let chosen = |options: &str| {
        let run = format!("image scene.xml --method auto --time 0.3 -o a.exr --stats s.json {options}");
        let (_, said) = f.ok(&run);
        let chosen = stats(&f)["chosen"].clone();
        assert_eq!(said.contains("auto traces paths"), chosen["method"] == "path", "{said}");
        assert!(chosen["samples"].as_u64() >= Some(1));
        chosen
    };
    for options in ["--denoise off", "--denoise builtin"] {
        let chosen = chosen(options);
        assert!(chosen["method"] == "records" && chosen["tau"].as_f64() > Some(0.0), "{chosen}");
    }
    let Some(library) = library() else {
        eprintln!("skipped in part: there is no Open Image Denoise");
        return;
    };
    assert_eq!(chosen(&format!("--oidn {library}"))["method"], "path");
    assert_eq!(chosen(&format!("--oidn {library} --tau 0.1"))["method"], "records");
}

/// What a mirror shows guides the denoiser.
#[test]
fn guides_follow_mirrors() {
    let f = Folder::with(SCENE, &[]);
    for method in ["path", "irradiance"] {
        f.ok(&format!("image scene.xml --spp 4 --method {method} -o a.exr"));
        let get = |name: &str, i: usize| channel(&f.path("a.exr"), name).unwrap()[i];
        let [middle, corner] = [12 * 32 + 16, 0];
        assert!((get("albedo.R", middle) - 0.7).abs() < 0.01 && (get("albedo.G", middle) - 0.1).abs() < 0.01);
        assert!(get("normal.Z", middle) < -0.99 && (get("depth.Z", middle) - 4.0).abs() < 0.01);
        assert!((get("albedo.G", corner) - 0.5).abs() < 0.01 && get("normal.Z", corner) > 0.99);
    }
}

#[test]
fn threads_and_repetition_change_nothing() {
    let f = Folder::with(SCENE, &[]);
    let mut kinds = vec!["builtin".to_owned()];
    kinds.extend(library().map(|path| format!("oidn --oidn {path}")));
    for kind in kinds {
        for method in ["path", "irradiance"] {
            let run = format!("image scene.xml --width 150 --spp 2 --method {method} --denoise {kind}");
            f.ok(&format!("{run} -o one.exr --threads 1"));
            f.ok(&format!("{run} -o two.exr --threads 2"));
            assert!(std::fs::read(f.path("one.exr")).unwrap() == std::fs::read(f.path("two.exr")).unwrap(), "{kind}");
        }
    }
    // One sample has no halves; a picture may be one pixel, or black.
    f.ok("image scene.xml --spp 1 --width 1 --height 1 --denoise builtin -o small.exr");
    f.ok("image scene.xml --spp 1 --max-depth 1 --denoise builtin -o black.exr");
}

/// A budget of time holds the denoiser too.
#[test]
fn time_is_set_aside() {
    let f = Folder::with(SCENE, &[]);
    let start = std::time::Instant::now();
    let (_, said) = f.ok("image scene.xml --time 0.5 -o a.exr --stats s.json");
    assert!(start.elapsed().as_secs_f64() < 4.0 && said.contains("denoised by"), "{said}");
    assert!(stats(&f)["denoiser"] != "off" && channel(&f.path("a.exr"), "noisy.G").is_some());
    let (_, said) = f.ok("image scene.xml --time 0.2 --denoise off -o a.exr");
    assert!(!said.contains("denoised") && channel(&f.path("a.exr"), "noisy.G").is_none());
}

/// rel_mse of 16 samples, noisy and denoised, against many.
fn errors(scene: &str, size: &str, depth: u32, denoiser: &str) -> [f64; 2] {
    let f = Folder::with(SCENE, &[]);
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes").join(scene);
    let run = format!("image {} {size} --max-depth {depth}", scene.display());
    f.ok(&format!("{run} --spp 1024 --seed 9 -o reference.exr"));
    ["off", denoiser].map(|denoiser| {
        f.ok(&format!("{run} --spp 16 --denoise {denoiser} -o a.exr"));
        let (json, _) = f.ok("compare a.exr reference.exr --json");
        serde_json::from_str::<serde_json::Value>(&json).unwrap()["rel_mse"].as_f64().unwrap()
    })
}

const SCENES: [(&str, &str); 3] = [
    ("cornell-glossy.xml", "--width 64 --height 64"),
    ("floor-n20.xml", "--width 64 --height 64"),
    ("room.glb", "--width 96 --height 54"),
];

/// Small pictures hold many edges in few pixels, and so are the hardest.
#[test]
fn our_own_halves_the_error() {
    for (scene, size) in SCENES {
        let [noisy, clean] = errors(scene, size, 5, "builtin");
        eprintln!("{scene}: {noisy:.4} -> {clean:.4}, {:.1} times less", noisy / clean);
        assert!(clean < 0.5 * noisy, "{scene}: {noisy} -> {clean}");
    }
}

#[test]
fn open_image_denoise_halves_the_error() {
    let Some(library) = library() else { return };
    for (scene, size) in SCENES {
        let [noisy, clean] = errors(scene, size, 5, &format!("oidn --oidn {library}"));
        eprintln!("{scene}: {noisy:.4} -> {clean:.4}, {:.1} times less", noisy / clean);
        assert!(clean < 0.3 * noisy, "{scene}: {noisy} -> {clean}");
    }
}
