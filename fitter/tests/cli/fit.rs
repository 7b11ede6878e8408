use super::{MATERIAL, fitter, folder, names, output, path, table};
use brdf_tables::table::Table;
use std::process::Command;
use std::time::Duration;

/// Bytes depend on the material, the options and the seed; not on the threads, the name of the file or the spelling.
#[test]
fn same_seed_same_bytes() {
    let folder = folder();
    let fit = |name: &str, flags: &[&str]| {
        let file = path(&folder, name);
        fitter(["fit", MATERIAL, "-o", &file, "--tolerance", "0.05"]).args(flags).assert().success();
        std::fs::read(file).unwrap()
    };
    let one = fit("a.tbl", &["--threads", "1", "--seed", "7"]);
    assert!(one == fit("b.tbl", &["--threads", "2", "--seed=7"]));
    assert!(one != fit("c.tbl", &["--threads", "2", "--seed", "8"]));
    let lobes = ["--solver", "lm", "--lobes", "1", "--threads"];
    let lobes = ["1", "2"].map(|threads| fit("d.tbl", &[&lobes[..], &[threads]].concat()));
    assert!(lobes[0] == lobes[1]);
}

#[test]
fn reports_what_was_made() {
    let folder = folder();
    let file = path(&folder, "x.tbl");
    let text = output(["fit", MATERIAL, "-o", &file, "--tolerance", "0.05"]);
    let bytes = format!("{} bytes", std::fs::metadata(&file).unwrap().len());
    for part in [&file, "zonal", &bytes, " s\n", "median", "p95", "worst", "off nodes", "rmse_lobe", "albedo"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    assert_eq!(names(folder.path()), ["x.tbl"]);
}

#[test]
fn the_output_is_named_after_the_material() {
    let folder = folder();
    std::fs::write(folder.path().join("dull.toml"), "model = \"lambert\"\nreflectance = 0.25\n").unwrap();
    fitter(["fit", "lambert:reflectance=0.5"]).current_dir(folder.path()).assert().success();
    fitter(["fit", "dull.toml"]).current_dir(folder.path()).assert().success();
    assert_eq!(names(folder.path()), ["dull.tbl", "dull.toml", "lambert-reflectance-0.5.tbl"]);
}

/// A fit that is killed leaves what was there before it, and nothing else.
#[test]
fn a_killed_fit_leaves_no_broken_file() {
    let folder = folder();
    let (old, new) = (path(&folder, "old.tbl"), path(&folder, "new.tbl"));
    std::fs::copy(table(), &old).unwrap();
    for file in [&old, &new] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_fitter"))
            .args(["fit", "ward:alpha_x=0.1,alpha_y=0.5", "--solver", "nelder-mead", "-o", file])
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(150));
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success(), "it was killed before it could finish");
    }
    assert_eq!(names(folder.path()), ["old.tbl"]);
    assert_eq!(Table::load(&old).unwrap(), Table::load(table()).unwrap());
}
