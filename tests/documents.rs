//! Documents of the repository: what they name exists, and what they tell a reader to type is understood.

mod commands;
mod links;

use std::path::{Path, PathBuf};

/// The pages that teach a user, and those of figures, from the root.
const PAGES: [&str; 13] = [
    "README.md",
    "CONTRIBUTING.md",
    "doc/cookbook.md",
    "doc/gallery.md",
    "brdf-tables/README.md",
    "brdf-tables/python/README.md",
    "fitter/README.md",
    "render/README.md",
    "render/farm/README.md",
    "tables/README.md",
    "brdf-tables/doc/measurements.md",
    "fitter/doc/measurements.md",
    "render/doc/measurements.md",
];

/// A page as text.
fn page(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Paths in back quotes: those with a slash and either an ending that files here have, or a slash at the end.
fn paths(text: &str) -> impl Iterator<Item = &str> {
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|q| {
        let ending = [".rs", ".md", ".py", ".xml", ".toml", "/"].iter().any(|e| q.ends_with(e));
        ending && q.contains('/') && !q.contains(char::is_whitespace) && !q.contains('*')
    })
}

/// Names in the page of architecture: a path from the root, or a part that the text or the row of the table has led to.
#[test]
fn architecture_names_what_exists() {
    let text = page("ARCHITECTURE.md");
    let places = [
        "",
        "brdf-tables/src",
        "fitter/src",
        "render/src",
        "render/src/scene",
        "tests",
        "render/src/integrator",
        "render/src/record",
    ];
    let (mut found, mut missing) = (0, Vec::new());
    for path in paths(&text) {
        found += 1;
        if !places.iter().any(|place| root().join(place).join(path).exists()) {
            missing.push(path);
        }
    }
    assert!(missing.is_empty(), "ARCHITECTURE.md names what is not there: {missing:?}");
    assert!(found > 50, "only {found} paths were found: is the page still written this way?");
    assert_eq!(paths("`a/b.rs` and `c d/` and `e.rs` and `f/`").collect::<Vec<_>>(), ["a/b.rs", "f/"]);
}
