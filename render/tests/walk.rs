//! Walks as others script against them: the same bytes however frames are drawn, one line for every mistake.

mod support;

use assert_cmd::cargo::CommandCargoExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use support::Folder;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const HEADER: &str = "frame,eye_x,eye_y,eye_z,look_x,look_y,look_z,up_x,up_y,up_z,fov\n";
/// Six frames in front of the Cornell box.
const PATH: &str = "1,2.78,2.73,-8,2.78,2.73,0,0,1,0,39\n6,1.6,2.4,-5,2.78,2.4,2.8,0,1,0,45\n";
const FRAMES: u32 = 6;

/// A folder with a path, and the arguments of a small and coarse walk of the glossy box.
fn folder() -> (Folder, String) {
    let f = Folder::with("", &[]);
    std::fs::write(f.path("path.csv"), format!("{HEADER}{PATH}")).unwrap();
    let scene = format!("{ROOT}/tests/scenes/cornell-glossy.xml");
    let walk =
        format!("walk {scene} --path path.csv --method auto --tables {ROOT}/tables --width 24 --tau 0.3 --spp 2");
    (f, walk)
}

fn bytes(folder: &Path, frames: impl IntoIterator<Item = u32>) -> Vec<Vec<u8>> {
    let read = |frame| {
        let path = folder.join(format!("{frame:04}.exr"));
        std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    };
    frames.into_iter().map(read).collect()
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// Threads, the order of frames, processes beside each other, a kill in between, a cache file or none: nothing changes a byte.
#[test]
fn frames_have_the_same_bytes_however_they_are_drawn() {
    let (f, walk) = folder();
    f.ok(&format!("{walk} -o a/####.exr --threads 1"));
    let expected = bytes(&f.path("a"), 1..=FRAMES);
    assert!(expected.windows(2).all(|pair| pair[0] != pair[1]));
    let same = |name: &str| assert!(bytes(&f.path(name), 1..=FRAMES) == expected, "{name}");

    f.ok(&format!("{walk} --fill-only --cache box.cache -o a/####.exr --threads 2"));
    let cache = std::fs::read(f.path("box.cache")).unwrap();
    let draw = format!("{walk} --frames-only --cache box.cache");
    f.ok(&format!("{draw} -o reverse/####.exr --frames 6,5,4,3,2,1 --threads 2"));
    same("reverse");
    for frame in 1..=FRAMES {
        f.ok(&format!("{draw} -o single/####.exr --frames {frame}"));
    }
    same("single");
    std::thread::scope(|scope| {
        for frames in ["1-3", "3-6"] {
            let run = format!("{draw} -o two/####.exr --frames {frames}");
            let f = &f;
            scope.spawn(move || f.ok(&run));
        }
    });
    same("two");
    assert!(std::fs::read(f.path("box.cache")).unwrap() == cache, "frames changed the cache");

    // Killed at one moment and another, it goes on.
    for milliseconds in [30, 100, 200, 400] {
        let mut command = Command::cargo_bin("render").unwrap();
        let run = format!("{draw} -o killed/####.exr --skip-existing");
        command.current_dir(f.path("")).args(run.split_whitespace()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(milliseconds));
        let _ = child.kill();
        child.wait().unwrap();
    }
    f.ok(&format!("{draw} -o killed/####.exr --skip-existing"));
    same("killed");
    let left = f
        .path("killed")
        .read_dir()
        .unwrap()
        .filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|x| x == "exr"));
    assert_eq!(left.count(), FRAMES as usize);
}

/// The arguments of a fill of 24 frames, the bytes of the cache that it leaves when nothing stops it, and how long it
/// takes.
fn long_fill() -> (Folder, String, Vec<u8>, Duration) {
    let (f, walk) = folder();
    std::fs::write(f.path("path.csv"), format!("{HEADER}{}", PATH.replace("\n6,", "\n24,"))).unwrap();
    let fill = format!("{walk} --fill-only --progress openjd -o x/####.exr --threads 1");
    let filling = Instant::now();
    f.ok(&format!("{fill} --cache whole.cache"));
    let took = filling.elapsed();
    let whole = std::fs::read(f.path("whole.cache")).unwrap();
    (f, fill, whole, took)
}

/// A process of `render`, whose output is read later.
fn start(f: &Folder, args: &str) -> std::process::Child {
    let mut command = Command::cargo_bin("render").unwrap();
    command.current_dir(f.path("")).args(args.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// Killed at random moments a fill leaves a whole file or none, goes on from it, and ends with the same bytes. `BURNISH_KILLS=100`
/// kills a hundred times.
#[test]
fn a_fill_that_is_killed_goes_on() {
    let kills: u32 = std::env::var("BURNISH_KILLS").map_or(12, |n| n.parse().expect("a number of kills"));
    let (f, fill, whole, took) = long_fill();
    let fill = format!("{fill} --cache killed.cache");
    let (mut random, mut killed, mut ended, mut resumed) = (1u64, 0, 0, 0);
    for _ in 0..100 * kills {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut child = start(&f, &fill);
        std::thread::sleep(took.mul_f64((random >> 33) as f64 / f64::from(1u32 << 31)));
        let _ = child.kill();
        if child.wait_with_output().unwrap().status.success() {
            assert!(std::fs::read(f.path("killed.cache")).unwrap() == whole, "after {killed} kills");
            std::fs::remove_file(f.path("killed.cache")).unwrap();
            ended += 1;
            continue;
        }
        killed += 1;
        if f.path("killed.cache").exists() {
            f.ok("cache info killed.cache");
            resumed += 1;
        }
        if killed == kills {
            break;
        }
    }
    assert_eq!(killed, kills);
    f.ok(&fill);
    assert!(std::fs::read(f.path("killed.cache")).unwrap() == whole);
    println!("{killed} kills, {resumed} with something kept, {ended} fills ended between them");
}

/// Two processes that fill one cache at once leave what one leaves.
#[test]
fn two_fills_at_once_do_no_harm() {
    let (f, fill, whole, _) = long_fill();
    let fill = format!("{fill} --cache two.cache");
    let children = [start(&f, &fill), start(&f, &fill)];
    for child in children {
        assert!(child.wait_with_output().unwrap().status.success());
    }
    assert!(std::fs::read(f.path("two.cache")).unwrap() == whole);
    assert!(!f.path("two.cache.lock").exists());
}

/// What is there is left only if it is whole and of these settings.
#[test]
fn frames_that_are_there_are_looked_at() {
    let (f, walk) = folder();
    let walk = format!("{walk} -o a/####.exr -o a/####.png --stats s.json --skip-existing");
    let drawn = |options: &str| {
        f.ok(&format!("{walk} {options}"));
        let stats = json(&f.path("s.json"));
        (stats["frames"].as_u64().unwrap(), stats["skipped"].as_u64().unwrap())
    };
    assert_eq!(drawn(""), (6, 0));
    let expected = bytes(&f.path("a"), 1..=FRAMES);
    assert_eq!(drawn(""), (0, 6));
    std::fs::write(f.path("a/0002.exr"), &expected[1][..expected[1].len() / 2]).unwrap();
    std::fs::write(f.path("a/0003.exr"), &expected[3]).unwrap();
    std::fs::remove_file(f.path("a/0004.png")).unwrap();
    assert_eq!(drawn(""), (3, 3));
    assert!(bytes(&f.path("a"), 1..=FRAMES) == expected);
    assert_eq!(drawn("--seed 1 --frames 1,2"), (2, 0));
    assert_eq!(drawn("--seed 1 --frames 1-3"), (1, 2));
    assert_eq!(drawn("--seed 1 --exposure 1 --frames 1"), (1, 0));
}

/// Parts of a walk that were filled apart become one cache, in any order, and only of one scene and quality.
#[test]
fn parts_of_a_cache_merge() {
    let (f, walk) = folder();
    for (name, frames, more) in [("a", "1-3", ""), ("b", "4-6", ""), ("other", "4-6", "-D max_depth=3")] {
        f.ok(&format!("{walk} --fill-only --frames {frames} --cache {name}.cache -o x/####.exr {more}"));
    }
    f.ok("cache merge a.cache b.cache -o ab.cache");
    f.ok("cache merge b.cache a.cache -o ba.cache");
    assert!(std::fs::read(f.path("ab.cache")).unwrap() == std::fs::read(f.path("ba.cache")).unwrap());
    let info = |name: &str| -> serde_json::Value {
        serde_json::from_str(&f.ok(&format!("cache info {name} --json")).0).unwrap()
    };
    let count = |name: &str| info(name)["irradiance"].as_u64().unwrap();
    assert_eq!(count("ab.cache"), count("a.cache") + count("b.cache"));
    assert_eq!(info("ab.cache")["walk"]["filled"], serde_json::json!([[0, 5]]));
    assert!(f.ok("cache info ab.cache").0.contains("filled: 1 to 6"));
    f.ok("cache merge ab.cache a.cache -o again.cache");
    assert_eq!(count("again.cache"), count("ab.cache"));
    f.bad(&format!("{walk} --frames-only --cache a.cache -o x/####.exr"), "a part of the path only");
    f.ok(&format!("{walk} --frames-only --cache ab.cache -o x/####.exr --frames 2"));
    f.bad("cache merge a.cache other.cache -o c.cache", "another scene");
    f.bad("cache merge a.cache path.csv -o c.cache", "path.csv: not a cache file");
    f.bad("cache merge a.cache b.cache -o a.cache", "is read by this command");
    f.bad("cache info none.cache", "none.cache");
    assert!(!f.path("c.cache").exists());
}

/// What a cache holds is light that arrives at surfaces: what only the eye or the screen sees may change, all that light meets on its
/// way may not, and is named.
#[test]
fn a_cache_is_kept_where_its_light_is_the_same() {
    let (f, walk) = folder();
    let scene = |glass: &str, lamp: &str| {
        format!(
            "<scene version=\"3.0.0\">
            <default name=\"max_depth\" value=\"5\"/>
            <integrator type=\"path\"><integer name=\"max_depth\" value=\"$max_depth\"/></integrator>
            <sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"24\"/>
            <integer name=\"height\" value=\"24\"/></film></sensor>
            <shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/></transform>
            <bsdf type=\"twosided\"><bsdf type=\"phong\"><rgb name=\"diffuse_reflectance\" value=\"0.2\"/>
            <rgb name=\"specular_reflectance\" value=\"{glass}\"/><float name=\"exponent\" value=\"40\"/></bsdf></bsdf></shape>
            <shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"3\" z=\"2\"/><float name=\"radius\" value=\"0.5\"/>
            <emitter type=\"area\"><rgb name=\"radiance\" value=\"{lamp}\"/></emitter></shape>
            <shape type=\"cube\"><transform name=\"to_world\"><translate x=\"1\" z=\"1\"/></transform></shape></scene>"
        )
    };
    let write = |glass: &str, lamp: &str| std::fs::write(f.path("scene.xml"), scene(glass, lamp)).unwrap();
    let (_, options) = walk.split_once(" --path").unwrap();
    let path =
        "frame,eye_x,eye_y,eye_z,look_x,look_y,look_z,up_x,up_y,up_z\n1,0,0,6,0,0,0,0,1,0\n3,1,0,6,0,0,0,0,1,0\n";
    std::fs::write(f.path("path.csv"), path).unwrap();
    let walk = format!("walk scene.xml --path{options}");
    write("0.6", "9");
    f.ok(&format!("{walk} --fill-only --cache c.cache -o a/####.exr"));
    let draw = format!("{walk} --frames-only --cache c.cache -o a/####.png");
    for kept in ["", "--exposure 1", "--view agx", "--seed 5", "--denoise off", "--frames 2", "--threads 1"] {
        f.ok(&format!("{draw} {kept}"));
    }
    f.ok(&format!("{draw} --spp 3").replace(" --spp 2", ""));
    for (refused, what) in [
        ("-D max_depth=4", "another scene"),
        ("--indirect-only", "another part of the light"),
        ("--eas paper", "another estimator"),
        ("--radius distance", "another spacing"),
    ] {
        f.bad(&format!("{draw} {refused}"), what);
    }
    f.bad(&draw.replace("--width 24", "--width 16"), "not filled for this path and film");
    f.bad(
        &draw.replace("--method auto", "--method sh").replace(&format!(" --tables {ROOT}/tables"), ""),
        "another method",
    );
    write("0.5", "9");
    f.bad(&draw, "another set of materials");
    write("0.6", "8");
    f.bad(&draw, "another scene");
    write("0.6", "9");
    f.ok(&draw);
}

/// A video is made where ffmpeg is, else the command is said; frames must be there as PNG, and follow each other.
#[test]
fn videos_are_made_or_told_of() {
    let (f, walk) = folder();
    let (_, said) = f.ok(&format!("{walk} -o v/##.png --frames 2-4 --video v.mp4"));
    assert!(
        f.path("v.mp4").exists()
            || said.contains("ffmpeg -y -loglevel error -framerate 24 -start_number 2 -i v/%02d.png"),
        "{said}"
    );
    f.bad(&format!("{walk} -o v/##.exr --video v.mp4"), "-o out/####.png");
    f.bad(&format!("{walk} -o v/##.png --video v.gif"), "v.gif");
    f.bad(&format!("{walk} -o v/##.png --frames 1,3 --video v.mp4"), "follow each other");
}

/// The chart of a walk: frames of four methods, a table, a line for every frame, and a page that needs no other file.
#[test]
fn walks_are_charted() {
    let (f, walk) = folder();
    let scene = walk.split(' ').nth(1).unwrap();
    let chart = format!(
        "walk-chart {scene} --path path.csv --frames 2,3 --time-per-frame 0.3 --reference-spp 4 -o chart --tables {ROOT}/tables"
    );
    let (table, _) = f.ok(&format!("{chart} -- --width 24"));
    for method in ["caches", "caches + denoiser", "path + denoiser", "path"] {
        assert!(table.contains(method), "{table}");
    }
    let lines = std::fs::read_to_string(f.path("chart/walk.csv")).unwrap();
    assert_eq!(lines.lines().count(), 1 + 4 * 2, "{lines}");
    let page = std::fs::read_to_string(f.path("chart/index.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("data:image/png;base64,") && !page.contains("src=\"pictures"));
    assert!(f.path("chart/error-0.3.svg").exists() && f.path("chart/flicker-0.3.svg").exists());
    f.bad(&format!("{chart} -- --spp 3"), "--spp is set by the chart");
    f.bad(&format!("{chart} -- --no-such"), "after --");
    f.bad(&chart.replace("2,3", "9"), "frame 9 is outside");
}

/// What a budget of time chose is in the cache, and frames are drawn with it.
#[test]
fn a_budget_of_time_is_written_into_the_cache() {
    let (f, walk) = folder();
    let walk = walk.replace(" --tau 0.3 --spp 2", "");
    f.ok(&format!("{walk} --cache t.cache --time-per-frame 0.4 -o a/####.exr --stats s.json"));
    let stats = json(&f.path("s.json"));
    let seconds = &stats["seconds"];
    let spent: f64 = ["fill", "shade", "write"].iter().map(|key| seconds[key].as_f64().unwrap()).sum();
    println!("{spent:.2} s for {FRAMES} frames of 0.4 s; {stats}");
    // Other tests run beside this one.
    assert!(spent < 6.0 * 0.4 * f64::from(FRAMES), "{stats}");
    f.ok(&format!("{walk} --cache t.cache --frames-only -o b/####.exr --stats r.json"));
    let again = json(&f.path("r.json"));
    assert_eq!((&again["spp"], &again["tau"]), (&stats["spp"], &stats["tau"]));
    assert!(bytes(&f.path("a"), 1..=FRAMES) == bytes(&f.path("b"), 1..=FRAMES));
}

#[test]
fn path_tracing_walks_too() {
    let (f, walk) = folder();
    let walk = walk.replace("--method auto", "--method path").replace(" --tau 0.3", "");
    let walk = walk.replace(&format!(" --tables {ROOT}/tables"), "");
    f.ok(&format!("{walk} -o a/####.exr --threads 1"));
    f.ok(&format!("{walk} -o b/####.exr --frames 6,1-5"));
    assert!(bytes(&f.path("a"), 1..=FRAMES) == bytes(&f.path("b"), 1..=FRAMES));
    f.ok(&format!("{walk} -o small/####.png --frames 1 --preview"));
    assert_eq!(render::image::read(&f.path("small/0001.png")).unwrap().width, 6);
    f.bad(&format!("{walk} -o b/####.exr --cache x.cache"), "--cache needs --method");
}

/// An animated camera of glTF stands at every frame where a picture of that moment has it.
#[test]
fn cameras_of_gltf_walk() {
    let f = Folder::with("", &[]);
    let file = format!("{ROOT}/tests/inputs/valid/gltf-animation/camera.gltf");
    f.ok(&format!("walk {file} --path camera:0@2 -o ##.exr --width 16 --spp 64 --denoise off"));
    assert!(f.path("02.exr").exists() && !f.path("03.exr").exists());
    for (frame, time) in [(0, 0.0), (1, 0.5), (2, 1.0)] {
        f.ok(&format!("image {file} -o still.exr --width 16 --spp 64 --time-of-animation {time}"));
        assert_eq!(f.run(&format!("compare 0{frame}.exr still.exr --fail-above 0.002")).0, 0, "{frame}");
    }
    f.bad(&format!("walk {file} --path camera:nobody@2 -o ##.exr"), "nobody");
    f.bad(&format!("walk {file} --path camera:0@2 --camera 0 -o ##.exr"), "both name a camera");
    let still = format!("{ROOT}/tests/inputs/valid/gltf-animation/linear.gltf");
    f.bad(&format!("walk {still} --path camera:0@2 -o ##.exr"), "nothing moves the camera");
}

#[test]
fn mistakes_are_one_line() {
    let (f, walk) = folder();
    let walk = format!("{walk} -o a/####.exr");
    let path = |text: String| std::fs::write(f.path("bad.csv"), text).unwrap();
    let bad = walk.replace("path.csv", "bad.csv");
    for (rows, said) in [
        ("1,nan,0,0,0,0,1,0,1,0,30", "bad.csv: line 2: eye_x"),
        ("1,0,0,0,0,0,1,0,1,0,30\n1,0,0,0,0,0,1,0,1,0,30", "bad.csv: line 3: frame 1 is there twice"),
        ("1,0,0,0,0,0,0,0,1,0,30", "bad.csv: frame 1: the camera looks nowhere"),
        ("0,0,0,0,0,0,1,0,1,0,30\n4000000000,0,0,0,0,0,1,0,1,0,30", "bad.csv: more than"),
        ("", "bad.csv: there is no row"),
    ] {
        path(format!("{HEADER}{rows}\n"));
        let said_all = f.bad(&bad, said);
        assert_eq!(said_all.lines().filter(|line| !line.contains("warning")).count(), 1, "{said_all}");
    }
    path("frame,eye_x\n1,2\n".into());
    f.bad(&bad, "eye_y,eye_z");
    f.bad(&walk.replace("path.csv", "none.csv"), "none.csv");
    f.bad(&walk.replace("path.csv", "camera:x"), "camera:NAME@FPS");
    f.bad(&walk.replace("path.csv", "camera:x@24"), "only glTF");
    f.bad(&format!("{walk} --frames 5-9"), "frame 7 is outside of the path path.csv, which has 1 to 6");
    f.bad(&format!("{walk} --frames 0-4000000000"), "--frames");
    f.bad(&format!("{walk} --time 3"), "--time");
    f.bad(&format!("{walk} --frames-only"), "--cache");
    f.bad(&format!("{walk} --frames-only --cache none.cache"), "none.cache");
    f.bad(&format!("{walk} --frames-only --cache path.csv"), "path.csv: not a cache file");
    f.bad(&format!("{walk} --time-per-frame 1"), "--time-per-frame");
    f.bad(&walk.replace("####", "frame"), "frame.exr: the name of the file needs ####");
    f.bad(&walk.replace(".exr", ".jpg"), "must end in .exr or .png");
    f.bad(&format!("{walk} --show-records r.png"), "--show-records");
}
