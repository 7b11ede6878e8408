//! Where methods fail: a verdict on every method and scene.

use super::html::{escape, table};
use crate::chart::Results;
use crate::chart::figures::methods;
use crate::chart::method;
use crate::chart::plot::plain;
use crate::chart::row::Row;
use std::fmt::Write;

/// Errors of 4×4 blocks above these are fair, and failures.
const FAIR: f64 = 0.005;
const FAILS: f64 = 0.02;
/// A pixel whose relative error is larger is a spot.
const SPOT: f64 = 3.0;
/// Larger shares of blocks that light leaks into, or of pixels with negative light, are failures.
const LEAKS: f64 = 0.005;
const RINGING: f64 = 0.001;
/// Block errors below this are not ranked: noise decides.
const RANKED: f64 = 0.001;

/// What is wrong with a run; empty for nothing.
fn faults(row: &Row) -> Vec<&'static str> {
    let all = [
        (row.blocks > FAILS, "error"),
        (row.worst > SPOT, "spots"),
        (row.leaks > LEAKS, "leaks"),
        (row.negative > RINGING, "ringing"),
    ];
    all.into_iter().filter(|f| f.0).map(|f| f.1).collect()
}

/// Class and words.
fn verdict(row: &Row) -> (&'static str, String) {
    match &faults(row)[..] {
        [] if row.blocks <= FAIR => ("good", "good".into()),
        [] => ("fair", "fair".into()),
        faults => ("fails", format!("fails: {}", faults.join(", "))),
    }
}

/// The section.
pub fn section(results: &Results) -> String {
    let mut lines = Vec::new();
    let mut counts: Vec<(String, [usize; 3], usize)> = Vec::new();
    let (mut ours_worst, mut named) = (Vec::new(), None);
    for subject in &results.subjects {
        let rows: Vec<&Row> = results.of(subject).collect();
        let worst = rows.iter().max_by(|a, b| a.blocks.total_cmp(&b.blocks)).filter(|r| r.blocks >= RANKED);
        for (i, name) in methods(rows.iter().copied()).into_iter().enumerate() {
            for row in rows.iter().filter(|r| r.method == name) {
                let (class, words) = verdict(row);
                // Methods that do the same in a scene share the place.
                let is_worst = worst.is_some_and(|w| w.blocks == row.blocks);
                let ours = method::find(name).is_some_and(|m| m.ours);
                if is_worst && ours && named.replace(&subject.name) != Some(&subject.name) {
                    ours_worst.push(format!("{} ({name}, {})", subject.name, plain(&row.blocks)));
                }
                let known = counts.iter().position(|c| c.0 == name).unwrap_or_else(|| {
                    counts.push((name.to_owned(), [0; 3], 0));
                    counts.len() - 1
                });
                counts[known].1[["good", "fair", "fails"].iter().position(|c| *c == class).unwrap_or(2)] += 1;
                counts[known].2 += usize::from(is_worst);
                let mark = match (is_worst, ours) {
                    (true, true) => "<span class=\"worst\">worst, and ours</span>",
                    (true, false) => "worst",
                    _ => "",
                };
                lines.push(vec![
                    if i == 0 { format!("<b>{}</b>", escape(&subject.name)) } else { String::new() },
                    escape(&row.method),
                    plain(&row.blocks),
                    plain(&row.rel_mse),
                    plain(&row.worst),
                    format!("{:.2} %", 100.0 * row.leaks),
                    format!("{:.2} %", 100.0 * row.negative),
                    format!("{:.2}", row.seconds),
                    format!("<span class=\"{class}\">{words}</span>"),
                    mark.into(),
                ]);
            }
        }
    }
    let mut summary = String::new();
    for (name, [good, fair, fails], worst) in &counts {
        let _ = writeln!(
            summary,
            "<li><b>{}</b>: {good} good, {fair} fair, {fails} failed; the worst of all in {worst}.</li>",
            escape(name)
        );
    }
    let ours = match &ours_worst[..] {
        [] => "Ours is the worst in none of the scenes.".to_owned(),
        scenes => format!("Ours is the worst in: {}.", escape(&scenes.join(", "))),
    };
    let head = [
        "scene",
        "method",
        "block error",
        "rel_mse",
        "worst pixel",
        "leaks",
        "ringing",
        "seconds",
        "verdict",
        "largest block error",
    ];
    format!(
        "<h2 id=\"stability\">Stability</h2>\n<p>Each scene is one situation in which caches tend to fail. Block error is the \
         rel_mse of 4×4 blocks: what is left when the noise of single pixels is averaged out. A run is good up to {FAIR}, fair up to \
         {FAILS}, and fails above; it fails too with a pixel whose relative error is over {SPOT} (a spot), with light in over {} % \
         of the blocks where the reference is dark (below {} % of its mean), or with negative radiance in over {} % of the \
         pixels (ringing). The worst of a scene is named where its block error is at least {RANKED}.</p>\n<ul>\n{summary}</ul>\n\
         <p>{ours}</p>\n{}",
        plain(&(100.0 * LEAKS)),
        plain(&(100.0 * render::metric::defects::DARK)),
        plain(&(100.0 * RINGING)),
        table(&head, &lines)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_makes_a_run_fail() {
        let row = Row { blocks: 0.001, worst: 0.5, ..Row::default() };
        assert_eq!(verdict(&row).0, "good");
        assert_eq!(verdict(&Row { blocks: 0.01, ..row.clone() }).0, "fair");
        for (bad, word) in [
            (Row { blocks: 0.03, ..row.clone() }, "error"),
            (Row { worst: 4.0, ..row.clone() }, "spots"),
            (Row { leaks: 0.01, ..row.clone() }, "leaks"),
            (Row { negative: 0.01, ..row.clone() }, "ringing"),
        ] {
            assert_eq!(verdict(&bad), ("fails", format!("fails: {word}")));
        }
    }
}
