//! The example that uses the cache without our scenes runs, and is short.

use std::path::Path;

#[allow(dead_code)]
#[path = "../../examples/cache_library.rs"]
mod example;

#[test]
fn the_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(root.join("examples/cache_library.rs")).expect("the example is there");
    assert!(source.lines().count() < 60);
    let table = root.join("../tables/phong-100.tbl");
    let text = example::run(&table.to_string_lossy()).expect("the table is shipped");
    assert!(text.starts_with("9 records") && !text.contains("NaN"), "{text}");
    assert!(example::run("absent.tbl").is_err());
}
