//! The `fitter` binary, as scripts see it: a contract.

/// Charts: figure and CSV.
mod chart;
/// `check` and `info`: verdicts, exit codes, JSON keys.
mod check;
/// What is refused, and how: one line, exit code 2.
mod errors;
/// `fit`: the same bytes for any number of threads, files that are whole or absent.
mod fit;
/// `plot`: figures that can be parsed.
mod plot;
/// `query` and `integrate`: rows in, rows out.
mod rows;

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

/// A glossy and a diffuse part.
const MATERIAL: &str = "phong:exponent=40,ks=0.5,kd=[0.3, 0.2, 0.1]";

/// The binary, at most two minutes of it.
fn fitter<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fitter"));
    command.args(arguments).timeout(std::time::Duration::from_secs(120));
    command
}

/// What the binary printed when it did its work.
fn output<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> String {
    String::from_utf8(fitter(arguments).assert().success().get_output().stdout.clone()).unwrap()
}

/// Asserts exit code 2 and one line on standard error that starts with `fitter: ` and holds all `parts`.
fn refused(command: &mut Command, parts: &[&str]) {
    let error = String::from_utf8(command.assert().code(2).get_output().stderr.clone()).unwrap();
    assert!(error.starts_with("fitter: ") && error.ends_with('\n') && error.lines().count() == 1, "{error:?}");
    for part in parts {
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

/// A folder for one test.
fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).display().to_string()
}

/// Names of the files of a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A table of [`MATERIAL`], fitted once for all tests.
fn table() -> String {
    static TABLE: OnceLock<PathBuf> = OnceLock::new();
    let path = TABLE.get_or_init(|| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli.tbl");
        fitter(["fit", MATERIAL, "-o", path.to_str().unwrap()]).assert().success();
        path
    });
    path.display().to_string()
}
