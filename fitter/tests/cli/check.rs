use super::{MATERIAL, fitter, folder, output, path, table};
use brdf_tables::family::{Family, Kin, families};
use brdf_tables::table::Table;
use serde_json::Value;

const ERRORS: [&str; 5] = ["albedo", "l1", "max", "rmse_hemi", "rmse_lobe"];

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort();
    keys
}

/// The five errors in each row of a summary.
fn is_summary(value: &Value) {
    assert_eq!(keys(value), ["caps", "median", "p95", "worst"]);
    for row in ["median", "p95", "worst"] {
        assert_eq!(keys(&value[row]), ERRORS);
    }
}

#[test]
fn json_keys_of_check() {
    let json: Value = serde_json::from_str(&output(["check", &table(), "--points", "8", "--json"])).unwrap();
    let expected = [
        "clipped",
        "file",
        "main",
        "material",
        "passed",
        "points",
        "promise",
        "representation",
        "seed",
        "wide",
        "worst",
    ];
    assert_eq!(keys(&json), expected);
    assert_eq!((json["passed"].as_bool(), json["main"]["caps"].as_u64()), (Some(true), Some(8)));
    for set in ["main", "clipped", "wide"] {
        is_summary(&json[set]);
    }
    assert_eq!(keys(&json["worst"]), ["errors", "omega", "phi_e", "theta_e"]);
    assert_eq!(keys(&json["promise"]), ["median", "p95", "worst"]);
}

/// A table that promises more than it holds fails its check with exit code 1, in words and in JSON.
#[test]
fn a_broken_promise_fails() {
    let folder = folder();
    let file = path(&folder, "boast.tbl");
    let mut table = Table::load(table()).unwrap();
    table.header.promise = [1e-9; 3];
    table.save(&file).unwrap();
    let text = fitter(["check", &file, "--points", "4"]).assert().code(1).get_output().stdout.clone();
    assert!(String::from_utf8(text).unwrap().contains("FAILED"));
    let json = fitter(["check", &file, "--points", "4", "--json"]).assert().code(1).get_output().stdout.clone();
    let json: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["passed"], false);
}

/// The same of a family: as it is shipped it passes, and with a promise that it cannot keep it fails.
#[test]
fn a_family_that_breaks_its_promise_fails() {
    let folder = folder();
    let file = path(&folder, "sheen.fam");
    let mut family = families().iter().find(|f| f.header.kin == Kin::Sheen).unwrap().clone();
    let write = |family: &Family| std::fs::write(&file, family.to_bytes().unwrap()).unwrap();
    write(&family);
    assert!(output(["check", &file, "--points", "2"]).contains("passed"));
    family.header.promise = [1e-9; 3];
    write(&family);
    let text = fitter(["check", &file, "--points", "2"]).assert().code(1).get_output().stdout.clone();
    assert!(String::from_utf8(text).unwrap().contains("FAILED"));
    let json = fitter(["check", &file, "--points", "2", "--json"]).assert().code(1).get_output().stdout.clone();
    let json: Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&json["passed"], json["promise"]["worst"].as_f64()), (&Value::Bool(false), Some(1e-9)));
}

#[test]
fn the_same_seed_draws_the_same_caps() {
    let check = |seed, threads| output(["check", &table(), "--points", "6", "--seed", seed, "--threads", threads]);
    assert_eq!(check("3", "1"), check("3", "2"));
    assert_ne!(check("3", "2"), check("4", "2"));
}

#[test]
fn info_says_what_is_in_the_file() {
    let json: Value = serde_json::from_str(&output(["info", &table(), "--json"])).unwrap();
    let expected = [
        "at_nodes",
        "bytes",
        "clipped",
        "command",
        "creator",
        "error_grid",
        "grid",
        "material",
        "notes",
        "off_nodes",
        "promise",
        "representation",
        "seed",
        "tolerance",
    ];
    assert_eq!(keys(&json), expected);
    for set in ["at_nodes", "off_nodes", "clipped"] {
        is_summary(&json[set]);
    }
    assert_eq!(json["bytes"].as_u64(), Some(std::fs::metadata(table()).unwrap().len()));
    assert_eq!(json["command"], format!("fitter fit '{MATERIAL}' --seed 1"));
    let text = output(["info", &table()]);
    assert!(text.contains("phong:exponent=40") && text.contains("rmse_lobe") && text.contains("zonal"), "{text}");
}

/// A diffuse material needs no fit, and every command still has an answer for its table.
#[test]
fn a_diffuse_table() {
    let folder = folder();
    let file = path(&folder, "chalk.tbl");
    output(["fit", "lambert:reflectance=0.5", "-o", &file]);
    assert!(output(["check", &file]).contains("passed"));
    let json: Value = serde_json::from_str(&output(["check", &file, "--json"])).unwrap();
    assert!(json["worst"].is_null());
    assert!(output(["info", &file]).contains("diffuse"));
}
