//! `render probe` and `--show-records`: files, figures, and one line for every mistake.

use assert_cmd::Command;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs `render` in the root of the project; returns exit code, output and errors.
fn run(args: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("render").unwrap().current_dir(root()).args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

fn probe(scene: &str, pixel: &str, folder: &Path, more: &[&str]) -> (i32, String, String) {
    let mut args = vec!["probe", scene, "--pixel", pixel, "--tables", "tables", "-o", folder.to_str().unwrap()];
    args.extend(more);
    run(&args)
}

const SCENE: &str = "tests/scenes/floor-n20.xml";

#[test]
fn a_probe_writes_pictures_and_both_curves() {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, err) = probe(SCENE, "15,57", folder.path(), &["--width", "64"]);
    assert_eq!(code, 0, "{err}");
    for key in ["position", "normal", "material", "samples", "eas", "bytes", "eps_g", "error", "guided"] {
        assert!(out.lines().any(|l| l.starts_with(key)), "{key}: {out}");
    }
    for (name, size) in
        [("hemisphere", 256), ("reflected-eas", 128), ("reflected-exact", 128), ("reflected-difference", 128)]
    {
        let image = render::image::read(&folder.path().join(format!("{name}.png"))).unwrap();
        assert_eq!((image.width, image.height), (size, size));
        let middle = image.pixels[(size * size / 2 + size / 2) as usize];
        assert!(image.pixels[0] == [1.0; 3] && middle != [1.0; 3], "{name}: {middle:?}");
    }
    for name in ["tree.svg", "error.svg"] {
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>") && !text.contains("NaN"), "{name}");
    }
    let text = std::fs::read_to_string(folder.path().join("error.csv")).unwrap();
    let mut lines = text.lines();
    let header = "max_eas,eas_paper,bytes_paper,error_paper,eas_improved,bytes_improved,error_improved";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(rows.iter().map(|r| r[0]).collect::<Vec<_>>(), [7.0, 15.0, 25.0, 50.0, 100.0, 200.0, 400.0]);
    for pair in rows.windows(2) {
        for column in [3, 6] {
            assert!(pair[1][column] < pair[0][column], "{text}");
        }
    }
    // Measured 0.0169 against 0.0195. Not a law: at some points of the floor near a wall the paper's record is the better.
    assert!(rows[4][6] < rows[4][3], "{text}");
    for row in &rows {
        assert!(row[1] <= row[0] && row[4] <= row[0], "{text}");
    }
    // The same seed gives the same bytes.
    let again = tempfile::tempdir().unwrap();
    assert_eq!(probe(SCENE, "15,57", again.path(), &["--width", "64"]).0, 0);
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name();
        assert_eq!(std::fs::read(entry.path()).unwrap(), std::fs::read(again.path().join(&name)).unwrap(), "{name:?}");
    }
}

#[test]
fn bad_pixels_are_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    for (pixel, mention) in [
        ("64,3", "outside the film"),
        ("4294967295,0", "outside the film"),
        ("32,2", "material `white`"),
        ("32,63", "shows no surface"),
        ("a,3", "expected X,Y"),
        ("-1,3", "expected X,Y"),
        ("3", "expected X,Y"),
    ] {
        let pixel = format!("--pixel={pixel}");
        let target = folder.path().join("none");
        let args = ["probe", SCENE, &pixel, "--width", "64", "--tables", "tables", "-o", target.to_str().unwrap()];
        let (code, _, err) = run(&args);
        assert_eq!(code, 2, "{pixel}: {err}");
        assert!(err.contains(mention) && !err.contains("panicked"), "{pixel}: {err}");
        assert!(!target.exists(), "{pixel}");
    }
    let (code, _, err) = probe(SCENE, "15,57", folder.path(), &["--width", "64", "--tau", "0"]);
    assert!(code == 2 && err.contains("--tau") && err.lines().count() == 1, "{err}");
}

#[test]
fn records_are_drawn_over_the_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (plain, shown) = (path("plain.png"), path("records.png"));
    let common = ["image", SCENE, "--width", "48", "--spp", "1", "--tables", "tables", "-o", &plain];
    let (code, _, err) = run(&[&common[..], &["--method", "eas", "--show-records", &shown]].concat());
    assert_eq!(code, 0, "{err}");
    let read = |name: &String| render::image::read(Path::new(name)).unwrap();
    let (plain, shown) = (read(&plain), read(&shown));
    assert_eq!((plain.width, plain.height), (shown.width, shown.height));
    // Dots of the two kinds that cover everything seen.
    let dots = |color: [usize; 3]| {
        let [high, a, b] = color;
        shown.pixels.iter().filter(|p| p[high] > 0.85 && p[a] < 0.2 && p[b] < 0.2).count()
    };
    assert!(dots([0, 1, 2]) >= 5 && dots([1, 0, 2]) >= 20, "{} {}", dots([0, 1, 2]), dots([1, 0, 2]));
    let (code, _, err) = run(&[&common[..], &["--method", "path", "--show-records", &shown_path(&folder)]].concat());
    assert!(code == 2 && err.contains("--show-records") && err.lines().count() == 1, "{err}");
}

fn shown_path(folder: &tempfile::TempDir) -> String {
    folder.path().join("never.png").to_str().unwrap().to_owned()
}
