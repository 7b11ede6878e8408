//! Walks as others script against them: the same bytes however frames are drawn, one line for every mistake.

mod support;

use assert_cmd::cargo::CommandCargoExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
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
    f.ok(&format!("walk {file} --path camera:0@2 -o ##.exr --width 16 --spp 64"));
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
