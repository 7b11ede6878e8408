//! The example that uses the cache without our scenes runs, and is short.

use std::path::Path;
use std::process::Command;

#[test]
fn the_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(root.join("examples/cache_library.rs")).expect("the example is there");
    assert!(source.lines().count() < 60);
    // Cargo builds examples beside the tests.
    let test = std::env::current_exe().expect("the test has a path");
    let example = test.parent().and_then(Path::parent).expect("target folder").join("examples/cache_library");
    let out = Command::new(example).arg(root.join("../tables/phong-100.tbl")).output().expect("the example is built");
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(out.status.success() && text.starts_with("9 records"), "{text}{}", String::from_utf8_lossy(&out.stderr));
}
