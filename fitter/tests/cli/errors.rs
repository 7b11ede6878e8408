use super::{MATERIAL, fitter, folder, path, refused, table};

#[test]
fn usage() {
    for (arguments, parts) in [
        (&["melt"][..], &["melt"][..]),
        (&["fit"], &["MATERIAL"]),
        (&["fit", MATERIAL, "--speed", "9"], &["--speed"]),
        (&["fit", MATERIAL, "--solver", "magic"], &["magic", "ga-lm"]),
        (&["fit", MATERIAL, "--lobes", "0"], &["--lobes", "1..=16"]),
        (&["fit", MATERIAL, "--lobes", "17"], &["--lobes", "1..=16"]),
        (&["fit", MATERIAL, "--tolerance", "nan"], &["--tolerance"]),
        (&["fit", MATERIAL, "--tolerance", "0"], &["--tolerance"]),
        (&["fit", MATERIAL, "--threads", "0"], &["--threads"]),
        (&["fit", MATERIAL, "--seed", "-1"], &["--seed"]),
        (&["check", "x.tbl", "--points", "0"], &["--points"]),
        (&["plot", "-o", "x.svg"], &["FILES"]),
        (&["plot", "x.tbl", "-o", "x.svg", "--omega", "7"], &["--omega", "7 sr"]),
        (&["integrate", MATERIAL, "--samples", "0"], &["--samples"]),
    ] {
        refused(&mut fitter(arguments), parts);
    }
    fitter([""; 0]).assert().code(2);
    fitter(["--help"]).assert().success();
    fitter(["--version"]).assert().success();
}

/// A flag that would change nothing is an error.
#[test]
fn flags_without_a_use() {
    for (arguments, part) in [
        (&["--representation", "zonal", "--solver", "lm"][..], "--solver has no use with representation zonal"),
        (&["--representation", "cubature", "--lobes", "2"], "--lobes has no use with representation cubature"),
        (&["--representation", "auto", "--solver", "ga"], "--solver has no use with representation auto"),
        (&["--preset", "paper", "--representation", "lobes"], "cannot be used with"),
        (&["--preset", "paper", "--lobes", "auto"], "--lobes auto has no use"),
        (&["--preset", "default", "--solver", "ga"], "--solver has no use with representation auto"),
    ] {
        refused(fitter(["fit", MATERIAL]).args(arguments), &[part]);
    }
    refused(&mut fitter(["fit", "lambert:reflectance=0.5", "--solver", "lm"]), &["diffuse"]);
    refused(&mut fitter(["plot", &table(), "-o", "x.svg", "--phi-deg", "3"]), &["--phi-deg has no use"]);
}

#[test]
fn materials() {
    let folder = folder();
    let recipe = path(&folder, "bad.toml");
    std::fs::write(&recipe, "model = \"phong\"\nexponent = 40\nshine = 2\n").unwrap();
    let directory = folder.path().to_str().unwrap();
    for (material, parts) in [
        ("phnog:exponent=3", &["phnog", "phong"][..]),
        ("phong", &["exponent", "nor is there a file"]),
        ("phong:exponent=nan", &["exponent"]),
        ("phong:exponent=1e300", &["exponent", "outside"]),
        ("phong:exponent=40,ks=0.8,kd=0.8", &["albedo"]),
        ("nosuch.toml", &["nosuch.toml"]),
        (&recipe, &["bad.toml:3", "shine"]),
    ] {
        refused(&mut fitter(["fit", material, "-o", &path(&folder, "x.tbl")]), parts);
        refused(&mut fitter(["integrate", material]), parts);
    }
    refused(&mut fitter(["fit", directory]), &[]);
    refused(&mut fitter(["fit", "ward:alpha_x=0.1,alpha_y=0.5", "--preset", "paper"]), &["azimuth"]);
    refused(&mut fitter(["fit", MATERIAL, "--representation", "zonal", "--tolerance", "1e-9"]), &["tolerance"]);
}

#[test]
fn outputs_are_refused_before_the_work() {
    let folder = folder();
    let directory = folder.path().to_str().unwrap();
    refused(&mut fitter(["fit", MATERIAL, "-o", directory]), &["directory", directory]);
    refused(&mut fitter(["fit", MATERIAL, "-o", &path(&folder, "no/x.tbl")]), &["no directory"]);
    refused(&mut fitter(["plot", &table(), "-o", &path(&folder, "no/x.svg")]), &["no directory"]);
    refused(&mut fitter(["chart", MATERIAL, "-o", &path(&folder, "x.csv")]), &["x.csv"]);
}

#[test]
fn tables() {
    let folder = folder();
    let good = std::fs::read(table()).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 4;
    let mut newer = good.clone();
    newer[8] = 99;
    let bad = path(&folder, "bad.tbl");
    for (bytes, part) in [
        (&b""[..], "not a table"),
        (b"#!/bin/sh\nexit\n", "not a table"),
        (&good[..good.len() / 2], "bad.tbl"),
        (&good[..14], "needs"),
        (&flipped, "checksum"),
        (&newer, "version 99"),
    ] {
        std::fs::write(&bad, bytes).unwrap();
        for command in ["info", "check", "query"] {
            refused(fitter([command, &bad]).write_stdin(""), &["bad.tbl", part]);
        }
    }
    for command in ["info", "check", "query"] {
        refused(&mut fitter([command, &path(&folder, "missing.tbl")]), &["missing.tbl", "No such file"]);
        refused(&mut fitter([command, folder.path().to_str().unwrap()]), &["not a regular file"]);
    }
}

/// A shader has no grid, and a grid binds nothing.
#[test]
fn export_refuses_options_of_another_format() {
    for (arguments, part) in [
        (&["--to", "wgsl", "-o", "x.wgsl", "--theta", "5"][..], "--theta has no use with --to wgsl"),
        (&["--to", "json", "-o", "x.json", "--binding", "1"], "--binding needs --to wgsl"),
    ] {
        refused(fitter(["export", "x.tbl"]).args(arguments), &[part]);
    }
}
