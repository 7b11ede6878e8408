//! What the packages say of themselves and of those that they need: licences, compilers, what a registry asks for.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Licences that ask no more than to be named. Those of an expression that are joined by `AND` must all be in the list, of those
/// joined by `OR` one.
const LICENCES: [&str; 12] = [
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "Unicode-3.0",
    "Zlib",
];

/// What a registry takes, its folder, and how many bytes of files there may be: families are most of the first, code of the others.
const PUBLISHED: [(&str, &str, u64); 4] = [
    ("brdf-tables", "../brdf-tables", 2_500_000),
    ("burnish-fitter", "../fitter", 1_000_000),
    ("burnish-kit", "../fitter/kit", 100_000),
    ("burnish-render", "../render", 3_000_000),
];

/// What `cargo` says.
fn cargo(args: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO")).args(args).current_dir(Path::new(env!("CARGO_MANIFEST_DIR"))).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// `cargo metadata` of the workspace as it is locked.
fn metadata() -> Value {
    serde_json::from_slice(&cargo(&["metadata", "--format-version", "1", "--locked", "--all-features"])).unwrap()
}

fn packages(metadata: &Value) -> &[Value] {
    metadata["packages"].as_array().unwrap()
}

fn text<'a>(package: &'a Value, key: &str) -> &'a str {
    package[key].as_str().unwrap_or_default()
}

/// Whether an expression of SPDX, without brackets within brackets, is satisfied by the list. `/` is `OR` of old manifests.
fn is_permissive(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ");
    if let Some((before, rest)) = expression.split_once('(') {
        let (inside, after) = rest.split_once(')').unwrap_or((rest, ""));
        // A bracket that is satisfied is as good as a licence of the list.
        let word = if is_permissive(inside) { "MIT" } else { "none" };
        return is_permissive(&format!("{before}{word}{after}"));
    }
    let known = |licence: &str| LICENCES.contains(&licence.split_whitespace().collect::<Vec<_>>().join(" ").as_str());
    expression.split(" OR ").any(|choice| choice.split(" AND ").all(known))
}

#[test]
fn licences_are_permissive() {
    let metadata = metadata();
    let bad: Vec<String> = packages(&metadata)
        .iter()
        .filter(|p| !is_permissive(text(p, "license")))
        .map(|p| format!("{} {}: {:?}", text(p, "name"), text(p, "version"), text(p, "license")))
        .collect();
    assert!(bad.is_empty(), "licences that are not in the list: {bad:#?}");
    assert!(packages(&metadata).len() > 100);
    for good in
        ["MIT", "MIT/Apache-2.0", "GPL-3.0 OR Zlib", "(MIT OR GPL-2.0) AND Unicode-3.0", "MIT AND (BSD-3-Clause OR X)"]
    {
        assert!(is_permissive(good), "{good}");
    }
    for bad in ["", "GPL-3.0", "MIT AND MPL-2.0", "(GPL-2.0 OR LGPL-2.1) AND MIT", "MITX"] {
        assert!(!is_permissive(bad), "{bad}");
    }
}

/// Major, minor and patch.
fn version(text: &str) -> [u64; 3] {
    let mut parts = text.split('.').map(|part| part.parse().expect("a number"));
    core::array::from_fn(|_| parts.next().unwrap_or(0))
}

/// No dependency asks for a younger compiler than we do; what the standard library had later is refused by clippy, which reads
/// `rust-version`.
#[test]
fn dependencies_keep_to_our_compiler() {
    let metadata = metadata();
    let ours = packages(&metadata).iter().find(|p| text(p, "name") == "brdf-tables").unwrap();
    let ours = version(text(ours, "rust_version"));
    let asked = |p: &&Value| !text(p, "rust_version").is_empty() && version(text(p, "rust_version")) > ours;
    let bad: Vec<_> = packages(&metadata).iter().filter(asked).map(|p| text(p, "name")).collect();
    assert!(bad.is_empty(), "dependencies that want a younger compiler than {ours:?}: {bad:?}");
    assert!(version("1.89") > version("1.88.9") && version("2.0.0") > version("1.99"));
}

/// What is published says what it is, and names versions of its own kind, so that it can be published.
#[test]
fn published_packages_are_described() {
    let metadata = metadata();
    let members: Vec<&str> =
        metadata["workspace_members"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    let mut found = Vec::new();
    for package in packages(&metadata).iter().filter(|p| members.contains(&text(p, "id"))) {
        let (name, private) = (text(package, "name"), package["publish"].as_array().is_some_and(Vec::is_empty));
        if private {
            continue;
        }
        found.push(name);
        for key in ["description", "license", "readme", "rust_version"] {
            assert!(!text(package, key).is_empty(), "{name} says no {key}");
        }
        for key in ["categories", "keywords"] {
            assert!(package[key].as_array().is_some_and(|list| (1..=5).contains(&list.len())), "{name}: {key}");
        }
        for dependency in package["dependencies"].as_array().unwrap() {
            let pinned = text(dependency, "req") != "*";
            assert!(pinned || text(dependency, "kind") == "dev", "{name}: {} has no version", text(dependency, "name"));
        }
    }
    found.sort_unstable();
    assert_eq!(found, PUBLISHED.map(|(name, ..)| name));
}

/// What code includes, tests and comments aside: they may read what only the repository has.
fn included(text: &str) -> Vec<&str> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let targets = lines.flat_map(|line| line.split("include_").skip(1)).map(|rest| rest.split('"').nth(1));
    targets.flatten().collect()
}

/// What is in a package: code, licences and its page, what the code includes, and nothing that only tests and documents need.
#[test]
fn packages_hold_what_they_need() {
    for (name, folder, most) in PUBLISHED {
        let list = String::from_utf8(cargo(&["package", "--list", "--allow-dirty", "--offline", "-p", name])).unwrap();
        let files: Vec<&str> = list.lines().collect();
        for needed in ["Cargo.toml", "README.md", "LICENSE-APACHE", "LICENSE-MIT", "src/lib.rs"] {
            assert!(files.contains(&needed), "{name} lacks {needed}");
        }
        for part in ["tests/", "doc/", "benches/", "fuzz/", "python/", "farm/"] {
            assert!(!files.iter().any(|file| file.starts_with(part)), "{name} holds {part}");
        }
        // Those that cargo makes are not in the folder.
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let bytes: u64 = files.iter().filter_map(|file| std::fs::metadata(here.join(file)).ok()).map(|m| m.len()).sum();
        println!("{name}: {} files, {bytes} bytes", files.len());
        assert!(bytes < most, "{name}: {bytes} bytes");
        for file in files.iter().filter(|file| file.starts_with("src/") && file.ends_with(".rs")) {
            let text = std::fs::read_to_string(here.join(file)).unwrap();
            for target in included(&text) {
                let from = here.join(Path::new(file).parent().unwrap().join(target));
                let path = from.canonicalize().unwrap_or_else(|e| panic!("{name}: {}: {e}", from.display()));
                let inside = path.strip_prefix(here.canonicalize().unwrap()).map(Path::to_path_buf);
                let inside = inside.unwrap_or_else(|_| panic!("{name}: {file} includes {target}"));
                assert!(files.iter().any(|file| Path::new(file) == inside), "{name} lacks {}", inside.display());
            }
        }
    }
}
