//! Warnings of a scene, few enough to be read.

use std::collections::HashMap;

/// Lines shown of each kind.
const SHOWN: usize = 3;

/// Keeps the first lines of each kind, and says after the last of them how many more there are. Lines are of one kind if they
/// differ in numbers only (places, counts, numbered names).
pub fn condense(warnings: Vec<String>) -> Vec<String> {
    let kinds: Vec<String> = warnings.iter().map(|w| kind(w)).collect();
    let mut counts: HashMap<&str, usize> = HashMap::new();
    kinds.iter().for_each(|k| *counts.entry(k).or_default() += 1);
    let mut seen: HashMap<&str, usize> = HashMap::new();
    let mut condensed = Vec::new();
    for (warning, kind) in warnings.into_iter().zip(&kinds) {
        let (seen, count) = (seen.entry(kind).or_default(), counts[kind.as_str()]);
        *seen += 1;
        if *seen < SHOWN || count <= SHOWN {
            condensed.push(warning);
        } else if *seen == SHOWN {
            condensed.push(format!("{warning} (and {} more of this kind)", count - SHOWN));
        }
    }
    condensed
}

/// The line with every number replaced.
fn kind(warning: &str) -> String {
    let mut out = String::with_capacity(warning.len());
    for c in warning.chars() {
        match c {
            '0'..='9' if out.ends_with('0') => {}
            '0'..='9' => out.push('0'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_a_kind_are_shown_and_the_others_counted() {
        let line = |i: usize| format!("scene.xml:{i}:1: <shape type=\"obj\">: {} triangles", 7 * i);
        let few: Vec<_> = (1..=3).map(line).collect();
        assert_eq!(condense(few.clone()), few);
        let mut many: Vec<_> = (8..=60).map(line).collect();
        many.insert(10, "another".into());
        let shown = [line(8), line(9), format!("{} (and 50 more of this kind)", line(10)), "another".into()];
        assert_eq!(condense(many), shown);
    }
}
