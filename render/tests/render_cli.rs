//! The command as others script against it: outputs, figures, exit codes, one line for every mistake.

mod support;

use std::path::Path;
use support::Folder;

const SCENE: &str = r#"<scene version="3.0.0">
    <default name="gray" value="0.6"/>
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/></film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="$gray"/></bsdf></shape>
</scene>"#;

fn pixels(path: &Path) -> render::image::Image {
    render::image::read(path).unwrap()
}

#[test]
fn renders_exr_and_png_and_writes_figures() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml -o a.exr --spp 16 --threads 1 --stats s.json");
    f.ok("image scene.xml -o b.exr --spp 16 --threads 2");
    assert_eq!(pixels(&f.path("a.exr")), pixels(&f.path("b.exr")));
    f.ok("image scene.xml -o a.png --spp 16");
    let png = pixels(&f.path("a.png"));
    assert_eq!((png.width, png.height), (24, 16));
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(f.path("s.json")).unwrap()).unwrap();
    for key in
        ["method", "rays", "records", "eas_mean", "bytes_per_record", "cache_bytes", "spp", "threads", "not_finite"]
    {
        assert!(!stats[key].is_null(), "{key}");
    }
    for key in ["load", "fit", "fill", "shade", "write", "total"] {
        assert!(stats["seconds"][key].is_number(), "{key}");
    }
    assert_eq!((&stats["spp"], &stats["method"]), (&16.into(), &"path".into()));
    // the sphere in the centre reflects 0.6 of 0.5; the corner is sky
    let exr = pixels(&f.path("a.exr"));
    assert!((exr.pixels[8 * 24 + 12][1] - 0.3).abs() < 0.01 && exr.pixels[0] == [0.5; 3]);
}

#[test]
fn shells_complete_and_man_has_pages() {
    let f = Folder::with(SCENE, &[]);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (script, _) = f.ok(&format!("completions {shell}"));
        assert!(script.contains("walk-chart") && script.contains("time-per-frame"), "{shell}");
    }
    f.ok("completions man -o pages/man1");
    for (page, word) in [("render", "render\\-walk"), ("render-image", "denoise"), ("render-cache-merge", "merge")] {
        let text =
            std::fs::read_to_string(f.path(&format!("pages/man1/{page}.1"))).unwrap_or_else(|e| panic!("{page}: {e}"));
        assert!(text.contains(word) && text.starts_with(".ie"), "{page}: {text:.300}");
    }
    f.bad("completions man", "--output");
    f.bad("completions bash -o pages", "--output is for man");
    f.bad("completions csh", "csh");
}

/// Lamps near the end of the range of single precision, whose sum is beyond it: what is lost is counted and said.
#[test]
fn what_is_not_finite_is_counted() {
    let lamp = r#"<shape type="sphere"><point name="center" x="0" y="0" z="9"/>
        <emitter type="area"><rgb name="radiance" value="3e38"/></emitter></shape></scene>"#;
    let folder = Folder::with(&SCENE.replace("</scene>", lamp).replace("value=\"0.5\"", "value=\"3e38\""), &[]);
    for method in ["path", "irradiance"] {
        let run = format!("image scene.xml -o a.exr --spp 4 --method {method} --stats s.json");
        let (_, output) = folder.ok(&run);
        let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("s.json")).unwrap()).unwrap();
        assert!(stats["not_finite"].as_u64() > Some(0), "{stats}");
        assert!(output.contains("paths were not finite"), "{output}");
        assert!(pixels(&folder.path("a.exr")).pixels.iter().flatten().all(|x| x.is_finite()));
    }
    let folder = Folder::with(SCENE, &[]);
    assert!(!folder.ok("image scene.xml -o a.exr --spp 4").1.contains("not finite"));
}

#[test]
fn layers_add_up() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml -o a.exr --spp 4");
    let image = exr::prelude::read_all_flat_layers_from_file(f.path("a.exr")).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let get = |name: &str| {
        let channel = channels.iter().find(|c| c.name == *name).unwrap_or_else(|| panic!("{name}"));
        channel.sample_data.values_as_f32().collect::<Vec<_>>()
    };
    let whole = get("G");
    let layers =
        ["emission.G", "direct.diffuse.G", "direct.glossy.G", "indirect.diffuse.G", "indirect.glossy.G"].map(get);
    for (i, w) in whole.iter().enumerate() {
        // Layers have 11 bits.
        assert!((layers.iter().map(|l| l[i]).sum::<f32>() - w).abs() <= w.abs().max(1e-3) / 2048.0);
    }
    let (albedo, z, depth) = (get("albedo.G"), get("normal.Z"), get("depth.Z"));
    let centre = 8 * 24 + 12;
    assert!((albedo[centre] - 0.6).abs() < 1e-3 && z[centre] > 0.9 && (depth[centre] - 3.0).abs() < 0.1);
    assert!(depth[0].is_infinite() && albedo[0] == 0.0);
}

#[test]
fn views_parameters_and_budgets() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml -o whole.exr --spp 4");
    f.ok("image scene.xml -o part.exr --spp 4 --crop 10,6,5,4");
    let (whole, part) = (pixels(&f.path("whole.exr")), pixels(&f.path("part.exr")));
    assert_eq!((part.width, part.height), (5, 4));
    for (i, p) in part.pixels.iter().enumerate() {
        assert_eq!(*p, whole.pixels[(6 + i / 5) * 24 + 10 + i % 5]);
    }
    f.ok("image scene.xml -o wide.exr --spp 1 --width 48");
    assert_eq!(pixels(&f.path("wide.exr")).height, 32);
    f.ok("image scene.xml -o dark.exr --spp 4 -D gray=0.2");
    assert!(pixels(&f.path("dark.exr")).pixels[8 * 24 + 12][0] < 0.11);
    f.ok("image scene.xml -o depth.exr --spp 4 --max-depth 1");
    assert_eq!(pixels(&f.path("depth.exr")).pixels[8 * 24 + 12], [0.0; 3]);
    f.ok("image scene.xml -o indirect.exr --spp 4 --indirect-only");
    assert_eq!(pixels(&f.path("indirect.exr")).pixels[8 * 24 + 12], [0.0; 3]); // a convex body has no indirect light
    let start = std::time::Instant::now();
    f.ok("image scene.xml -o timed.exr --time 0.5 --stats s.json");
    assert!(start.elapsed().as_secs_f64() < 3.0);
    let spp = |f: &Folder| {
        let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(f.path("s.json")).unwrap()).unwrap();
        stats["spp"].as_u64().unwrap()
    };
    assert!(spp(&f) > 16);
    f.ok("image scene.xml -o coarse.exr --error 0.5 --stats s.json");
    let coarse = spp(&f);
    f.ok("image scene.xml -o fine.exr --error 0.005 --stats s.json");
    assert!(spp(&f) > coarse);
}

#[test]
fn compares() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml -o a.exr --spp 4 --seed 1");
    f.ok("image scene.xml -o b.exr --spp 4 -D gray=0.5");
    let json: serde_json::Value =
        serde_json::from_str(&f.ok("compare a.exr b.exr --json --false-color c.png").0).unwrap();
    for key in ["rmse", "rel_mse", "bias", "max", "flip"] {
        assert!(json[key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert_eq!(pixels(&f.path("c.png")).width, 24);
    assert_eq!(f.run("compare a.exr b.exr --fail-above 1e-6").0, 1);
    assert_eq!(f.run("compare a.exr b.exr --fail-above 1").0, 0);
    let same: serde_json::Value = serde_json::from_str(&f.ok("compare a.exr a.exr --json").0).unwrap();
    assert_eq!((&same["rmse"], &same["flip"]), (&0.0.into(), &0.0.into()));
}

/// Two references of independent noise tell the error of a picture apart from their own.
#[test]
fn a_second_reference_takes_the_noise_off() {
    let f = Folder::with(SCENE, &[]);
    for (name, seed) in [("a", 1), ("b", 2), ("c", 3)] {
        f.ok(&format!("image scene.xml -o {name}.exr --spp 4 --seed {seed}"));
    }
    let figure = |options: &str, key: &str| {
        let (out, _) = f.ok(&format!("compare a.exr b.exr {options} --json"));
        serde_json::from_str::<serde_json::Value>(&out).unwrap()[key].as_f64().unwrap()
    };
    let (one, two) = (figure("", "rel_mse"), figure("--second c.exr", "rel_mse"));
    assert!(two > 0.0 && (two - 0.5 * one).abs() < 0.2 * one, "{one} {two}");
    assert!(figure("", "trimmed") < one);
    assert!(f.ok("compare a.exr b.exr --second c.exr --false-color d.png").0.contains("trimmed"));
    f.bad("compare a.exr b.exr --second c.exr --z-test", "--z-test");
    f.bad("compare a.exr b.exr --second none.exr", "none.exr");
    f.ok("image scene.xml -o small.exr --spp 1 --width 12");
    f.bad("compare a.exr b.exr --second small.exr", "12×8");
}

/// Frames that differ from their references by the same error do not flicker, others do.
#[test]
fn compares_frames() {
    let f = Folder::with(SCENE, &[]);
    for frame in 1..=3 {
        f.ok(&format!("image scene.xml -o r.000{frame}.exr --spp 16"));
        f.ok(&format!("image scene.xml -o still.{frame}.exr --spp 16 -D gray=0.5"));
        f.ok(&format!("image scene.xml -o noisy.{frame}.exr --spp 1 --seed {frame}"));
    }
    let report = |files: &str| {
        let (out, _) = f.ok(&format!("compare {files} r.####.exr --frames 1-3 --json"));
        serde_json::from_str::<serde_json::Value>(&out).unwrap()
    };
    let (still, noisy) = (report("still.#.exr"), report("noisy.#.exr"));
    assert_eq!(still["flicker"], 0.0);
    assert!(noisy["flicker"].as_f64() > Some(1e-4), "{noisy}");
    assert!(still["frames"][0]["flicker"].is_null() && still["frames"][1]["flicker"] == 0.0);
    assert_eq!(still["frames"][2]["rel_mse"], still["mean"]["rel_mse"]);
    let (out, _) = f.ok("compare noisy.#.exr r.####.exr --second still.#.exr --frames 3,1");
    assert!(out.lines().count() == 4 && out.lines().nth(1).unwrap().trim_start().starts_with("1 "), "{out}");
    assert_eq!(f.run("compare still.#.exr r.####.exr --frames 1-3 --fail-above 1e-6").0, 1);
    f.ok("compare still.#.exr r.####.exr --frames 1-3 --strip s.png");
    let strip = pixels(&f.path("s.png"));
    assert_eq!((strip.width, strip.height), (3, 2 * 16 + 4));
    // A darker sphere above, the reference below.
    assert!(strip.pixels[8 * 3][0] < strip.pixels[28 * 3][0] && strip.pixels[8 * 3] == strip.pixels[8 * 3 + 2]);
    f.bad("compare still.1.exr r.0001.exr --strip s.png", "--frames");
    f.bad("compare still.#.exr r.####.exr --frames 1-4", "still.4.exr");
    f.bad("compare still.1.exr r.####.exr --frames 1", "still.1.exr: the name of the file needs ####");
    f.bad("compare still.#.exr r.####.exr --frames 1,1", "frame 1 is there twice");
    f.bad("compare still.#.exr r.####.exr --frames 0-99999999", "--frames");
}

#[test]
fn the_z_test_tells_noise_from_a_difference() {
    let f = Folder::with(SCENE, &[]);
    f.ok("image scene.xml -o a.exr --spp 256 --seed 1");
    f.ok("image scene.xml -o b.exr --spp 512 --seed 2");
    f.ok("image scene.xml -o lighter.exr --spp 512 --seed 2 -D gray=0.65");
    let (out, _) = f.ok("compare a.exr b.exr --z-test --json");
    let z: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(z["z_test"]["pixels"]["count"], 24 * 16);
    assert!(z["z_test"]["pixels"]["deviation"].as_f64().unwrap() > 0.1, "{out}");
    let (code, out, _) = f.run("compare a.exr lighter.exr --z-test");
    assert!(code == 1 && out.contains("FAILED"), "{out}");
    f.ok("image scene.xml -o few.exr --spp 4");
    f.bad("compare few.exr a.exr --z-test", "no variance layer");
    f.ok("image scene.xml -o view.png --spp 4");
    f.bad("compare view.png a.exr --z-test", "no variance layer");
}

#[test]
fn mistakes_are_named() {
    let f = Folder::with(SCENE, &[]);
    f.bad("image missing.xml -o a.exr", "missing.xml");
    f.bad("image scene.xml -o a.gif", "must end in .exr, .png, .jpg, .jpeg or .webp");
    f.bad("image scene.xml -o nowhere/a.exr --spp 1", "nowhere/a.exr");
    f.bad("image scene.xml -o a.exr --spp 0", "--spp");
    f.bad("image scene.xml -o a.exr --spp 1 --time 1", "--time");
    f.bad("image scene.xml -o a.exr --time nan", "--time");
    f.bad("image scene.xml -o a.exr --error=-1", "--error");
    f.bad("image scene.xml -o a.exr --spp 1 --crop 20,0,10,10", "crop");
    f.bad("image scene.xml -o a.exr --spp 1 --crop 1,2", "--crop");
    f.bad("image scene.xml -o a.exr --spp 1 --width 99999999", "--width");
    f.bad("image scene.xml -o a.exr --spp 1 -D gray", "NAME=VALUE");
    f.bad("image scene.xml -o a.exr --method photons", "--method");
    f.bad("compare a.exr b.exr", "a.exr");
    std::fs::write(f.path("broken.exr"), b"not a picture").unwrap();
    f.bad("compare broken.exr broken.exr", "broken.exr");
    f.ok("image scene.xml -o a.exr --spp 1");
    f.ok("image scene.xml -o small.exr --spp 1 --width 12");
    f.bad("compare a.exr small.exr", "24×16");
    f.bad("compare a.exr a.exr --fail-above x", "--fail-above");
    f.bad("compare a.exr a.exr --false-color c.exr", ".png");
    f.bad("compare a.txt a.txt", "a.txt: No such file or directory (os error 2)\n");
    f.bad("compare scene.xml scene.xml", "scene.xml: not an OpenEXR, Radiance HDR, PNG, JPEG or WebP image");
}

const GLOSSY: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/></film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <shape type="sphere"><bsdf type="phong"><float name="exponent" value="30"/></bsdf></shape>
</scene>"#;

/// A missing table is fitted and kept; the second run has no more to fit; both pictures appear, and so do the figures.
#[test]
fn cached_pictures_fit_what_they_need() {
    let folder = Folder::with(SCENE, &[]);
    // An exponent that no family holds.
    std::fs::write(folder.path("glossy.xml"), GLOSSY.replace(r#"value="30""#, r#"value="0.5""#)).unwrap();
    let run = "image glossy.xml --method eas --spp 2 --tau 0.1 --tables made -o a.exr -o a.png --stats s.json";
    let (code, _, err) = folder.run(run);
    assert!(code == 0 && err.contains("fitted phong") && err.contains("EAS records"), "{err}");
    assert_eq!(std::fs::read_dir(folder.path("made")).unwrap().count(), 1);
    let (_, _, again) = folder.run(run);
    assert!(!again.contains("fitted"), "{again}");
    assert!(folder.path("a.png").exists());
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("s.json")).unwrap()).unwrap();
    assert_eq!(stats["method"], "eas");
    assert!(stats["records"].as_u64() > Some(0) && stats["eas_mean"].as_f64() > Some(1.0), "{stats}");
    assert!(stats["bytes_per_record"].as_f64() < Some(16_000.0) && stats["seconds"]["fill"].as_f64() > Some(0.0));
}

/// What a family holds takes no time and leaves no file.
#[test]
fn families_need_no_fit() {
    let folder = Folder::with(SCENE, &[]);
    std::fs::write(folder.path("glossy.xml"), GLOSSY).unwrap();
    let (code, _, err) =
        folder.run("image glossy.xml --method eas --spp 2 --tau 0.1 --tables made -o a.exr --stats s.json");
    assert!(code == 0 && !err.contains("fitted") && err.contains("EAS records"), "{err}");
    assert!(!folder.path("made").exists());
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("s.json")).unwrap()).unwrap();
    assert_eq!(stats["seconds"]["fit"], 0.0, "{stats}");
}

/// Harmonics need no table; the figures tell their order and size.
#[test]
fn harmonics_draw_without_tables() {
    let folder = Folder::with(SCENE, &[]);
    std::fs::write(folder.path("glossy.xml"), GLOSSY).unwrap();
    let run = "image glossy.xml --method sh --spp 2 --tau 0.1 -o a.exr --stats s.json";
    let (code, _, err) = folder.run(&format!("{run} --order 6 --gradients none --show-records r.png"));
    assert!(code == 0 && err.contains("harmonics of order 6") && err.contains("harmonic records"), "{err}");
    assert!(!folder.path("tables").exists() && folder.path("r.png").exists());
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("s.json")).unwrap()).unwrap();
    assert_eq!((&stats["method"], &stats["order_mean"]), (&"sh".into(), &6.0.into()));
    let bytes = stats["bytes_per_record"].as_f64().unwrap();
    assert!((36.0 * 12.0..36.0 * 12.0 + 128.0).contains(&bytes), "{bytes}");
    folder.ok(&format!("{run} --basis spherical --cache x.cache"));
    folder.ok(&format!("{run} --basis spherical --cache x.cache"));
    folder.bad(&format!("{run} --cache x.cache"), "x.cache");
    folder.bad("image glossy.xml --method sh --order 30 -o a.png", "--order");
    folder.bad("image glossy.xml --method sh --order 0 -o a.png", "--order");
    folder.bad("image glossy.xml --method eas --order 10 -o a.png", "--order needs --method sh");
    folder.bad("image glossy.xml --gradients none -o a.png", "--gradients needs --method sh");
    folder.bad("image glossy.xml --method auto --basis spherical -o a.png", "--basis needs --method sh");
}

#[test]
fn what_caches_cannot_do_is_refused() {
    let folder = Folder::with(SCENE, &[]);
    std::fs::write(folder.path("glossy.xml"), GLOSSY).unwrap();
    std::fs::create_dir(folder.path("bad")).unwrap();
    std::fs::write(folder.path("bad/x.tbl"), "no table").unwrap();
    std::fs::write(folder.path("x.cache"), "no cache").unwrap();
    folder.bad("image glossy.xml --method eas --error 0.1 -o a.png", "--error");
    folder.bad("image glossy.xml --method eas --tau 0 -o a.png", "--tau");
    folder.bad("image glossy.xml --method eas --tables bad -o a.png", "x.tbl");
    folder.bad("image glossy.xml --method eas --tables made --cache x.cache -o a.png", "x.cache");
    folder.bad("image glossy.xml --method eas -o a.gif", ".png");
}

/// A run that is killed leaves either no cache file, the one that was there, or a whole new one, and the next run goes on.
#[test]
fn killed_runs_leave_whole_cache_files() {
    let folder = Folder::with(SCENE, &[]);
    let command = "image scene.xml --method irradiance --tau 0.2 --spp 1 --cache box.cache -o out.exr";
    folder.ok(command);
    let good = std::fs::read(folder.path("box.cache")).unwrap();
    let binary = assert_cmd::cargo::cargo_bin("render");
    for milliseconds in [0, 5, 10, 20, 40, 80] {
        let mut run = std::process::Command::new(&binary)
            .current_dir(folder.folder.path())
            .args(command.split_whitespace())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        run.kill().unwrap();
        run.wait().unwrap();
        assert!(std::fs::read(folder.path("box.cache")).unwrap() == good, "killed after {milliseconds} ms");
        folder.ok(command);
        // A first run has nothing to fall back to.
        std::fs::remove_file(folder.path("box.cache")).unwrap();
        folder.ok(command);
    }
}
