//! Table 1 of eas-2015 on our scenes: harmonics ("RC") against EAS, at equal error and at equal memory.

use super::html::{escape, table};
use crate::chart::Results;
use crate::chart::figures::is_budget;
use crate::chart::plot::plain;
use crate::chart::row::Row;
use crate::chart::subject::Subject;
use std::fmt::Write;

/// Names of the methods of harmonics, and of ours.
const HARMONICS: [&str; 2] = ["sh", "sh-29"];
const EAS: [&str; 1] = ["eas"];

const HEAD: [&str; 8] =
    ["scene", "method", "glossy records", "KB per record", "order / EAS", "total MB", "time", "RMSE"];

/// Errors up to this ratio are equal.
const EQUAL: f64 = 1.02;

/// The published numbers.
const PAPER: [[&str; 8]; 10] = [
    ["Matpreview, n = 40", "RC", "2740", "14.4", "20", "39.4", "20 min", "0.03"],
    ["", "EAS", "2585", "7.4", "189", "19.1", "12 min", "0.03"],
    ["Matpreview, n = 100", "RC", "3103", "30.3", "29", "94", "30 min", "0.06"],
    ["", "EAS", "2348", "15.6", "399", "36.6", "16 min", "0.06"],
    ["Dragon", "RC", "20000", "14.4", "20", "288", "2.5 h", "0.06"],
    ["", "EAS", "16800", "7.5", "192", "126", "2 h", "0.06"],
    ["Campervan", "RC", "21654", "30.3", "29", "658", "4.5 h", "0.27"],
    ["", "EAS", "24316", "1.9", "50", "168", "3 h", "0.1"],
    ["Kitchen", "RC", "6638", "30.3", "29", "194", "3.5 h", "0.05"],
    ["", "EAS", "3841", "19.5", "500", "79.3", "2 h", "0.03"],
];

/// The section, where there are rows of harmonics.
pub fn section(results: &Results) -> Option<String> {
    let mut ours = Vec::new();
    let mut sentences = String::new();
    for subject in &results.subjects {
        if let Some((rows, sentence)) = of_scene(subject, &results.of(subject).collect::<Vec<_>>()) {
            ours.extend(rows);
            let _ = writeln!(sentences, "<li>{sentence}</li>");
        }
    }
    if ours.is_empty() {
        return None;
    }
    let paper: Vec<Vec<String>> = PAPER.iter().map(|r| r.iter().map(|c| escape(c)).collect()).collect();
    Some(format!(
        "<h2 id=\"table1\">Table 1: harmonics (RC) against EAS</h2>\n<p>As eas-2015, Table 1, without the runs with a time \
         budget. RC is the run of harmonics that takes the least memory for the least error they reach. Beside it the \
         fastest EAS run whose RMSE is no larger; then the EAS run of least error, and the best run of harmonics that \
         takes no more memory in all than that. Errors within 2 % \
         of each other count as equal: the noise of direct light is in all of them.</p>\n<ul>\n{sentences}</ul>\n{}<p>As \
         published, on another machine, larger pictures and the \
         published scenes:</p>\n<div class=\"paper\">{}</div>\n",
        table(&HEAD, &ours),
        table(&HEAD, &paper)
    ))
}

/// Lines and sentence of a scene.
fn of_scene(subject: &Subject, rows: &[&Row]) -> Option<(Vec<Vec<String>>, String)> {
    let of = |methods: &'static [&str]| {
        rows.iter().filter(|r| !is_budget(r) && methods.contains(&r.method.as_str()) && r.glossy_records > 0)
    };
    let least = of(&HARMONICS).map(|r| r.rmse).min_by(f64::total_cmp)?;
    let rc = of(&HARMONICS).filter(|r| r.rmse <= EQUAL * least).min_by_key(|r| r.bytes)?;
    let equal_error = of(&EAS).filter(|r| r.rmse <= EQUAL * rc.rmse).min_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let best = of(&EAS).min_by(|a, b| a.rmse.total_cmp(&b.rmse))?;
    let equal_memory = of(&HARMONICS).filter(|r| r.bytes <= best.bytes).min_by(|a, b| a.rmse.total_cmp(&b.rmse));
    let line = |scene: &str, method: &str, r: &Row| {
        let numbers = [r.bytes_per_record / 1e3, r.size, r.bytes as f64 / 1e6];
        let [kb, size, mb] = numbers.map(|x| plain(&x));
        let time = format!("{:.2} s", r.seconds);
        vec![escape(scene), method.into(), r.glossy_records.to_string(), kb, size, mb, time, plain(&r.rmse)]
    };
    let mut lines = vec![line(&subject.name, "RC", rc)];
    let mut parts = Vec::new();
    match equal_error {
        Some(r) => {
            lines.push(line("", "EAS, equal error", r));
            parts.push(format!(
                "at equal error EAS take {} of the bytes per record (paper: 0.5) and {} of the time (paper: 0.53 to 0.8)",
                plain(&(r.bytes_per_record / rc.bytes_per_record)),
                plain(&(r.seconds / rc.seconds))
            ));
        }
        None => parts.push("no EAS run comes down to the error of the harmonics".into()),
    }
    match equal_memory {
        Some(r) => {
            lines.push(line("", "EAS, least error", best));
            lines.push(line("", "RC, equal memory", r));
            parts.push(format!(
                "in the memory of the best EAS run their RMSE is {} of that of the best harmonics",
                plain(&(best.rmse / r.rmse.max(f64::MIN_POSITIVE)))
            ));
        }
        None => parts.push("no run of harmonics fits into the memory of the best EAS run".into()),
    }
    Some((lines, format!("{}: {}.", escape(&subject.name), parts.join("; "))))
}
