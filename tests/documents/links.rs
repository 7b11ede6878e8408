//! Links between pages, their headings, and paths in back quotes.

use super::{PAGES, page, paths, root};
use std::path::Path;

/// Targets of links and pictures: what stands in the round brackets.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
}

/// A heading as GitHub names it in links.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Headings outside of code.
fn anchors(text: &str) -> Vec<String> {
    let prose = text.split("```").step_by(2).flat_map(str::lines);
    prose.filter(|line| line.starts_with('#')).map(|line| anchor(line.trim_start_matches('#').trim())).collect()
}

#[test]
fn links_lead_somewhere() {
    let (mut found, mut broken) = (0, Vec::new());
    for name in PAGES {
        let text = page(name);
        let folder = root().join(Path::new(name).parent().unwrap());
        for target in targets(&text).filter(|t| !t.starts_with("http")) {
            found += 1;
            let (path, heading) = target.split_once('#').map_or((target, None), |(path, h)| (path, Some(h)));
            let file = if path.is_empty() { root().join(name) } else { folder.join(path) };
            let leads = match heading {
                _ if !file.exists() => false,
                Some(heading) => anchors(&std::fs::read_to_string(&file).unwrap()).iter().any(|a| a == heading),
                None => true,
            };
            if !leads {
                broken.push(format!("{name}: {target}"));
            }
        }
    }
    assert!(broken.is_empty(), "links that lead nowhere: {broken:#?}");
    assert!(found > 80, "only {found} links were found: are the pages still written this way?");
    assert_eq!(anchor("Methods, and which to use when"), "methods-and-which-to-use-when");
}

#[test]
fn paths_in_manuals_exist() {
    let mut missing = Vec::new();
    for name in PAGES {
        let folder = Path::new(name).parent().unwrap();
        let places =
            [Path::new(""), folder, Path::new("brdf-tables/src"), Path::new("fitter/src"), Path::new("render/src")];
        let text = page(name);
        // Fences of code would turn the quotes about.
        let prose: String = text.split("```").step_by(2).collect();
        for path in paths(&prose) {
            if !places.iter().any(|place| root().join(place).join(path).exists()) {
                missing.push(format!("{name}: {path}"));
            }
        }
    }
    assert!(missing.is_empty(), "paths that are not there: {missing:#?}");
}
