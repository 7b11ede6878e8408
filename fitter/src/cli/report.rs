//! What a person or a script reads: the five errors as a table or as JSON.

use brdf_tables::errors::{Errors, Summary};
use kit::text::percent;
use serde_json::{Value, json};
use std::fmt::Write;

/// The five errors of several sets of caps as a table of percentages.
pub fn errors_table(sets: &[(&str, &Summary)]) -> String {
    let mut text = format!("{:<23}", "errors, percent");
    for name in Errors::NAMES {
        let _ = write!(text, "{name:>11}");
    }
    text.push('\n');
    for (name, summary) in sets.iter().filter(|(_, summary)| summary.caps > 0) {
        for (at, (row, errors)) in rows(summary).into_iter().enumerate() {
            let name = match at {
                0 => (*name).to_string(),
                1 => format!("  {} caps", summary.caps),
                _ => String::new(),
            };
            let _ = write!(text, "{name:<16}{row:<7}");
            for error in errors.to_array() {
                let _ = write!(text, "{:>11}", percent(f64::from(error)));
            }
            text.push('\n');
        }
    }
    text
}

/// A summary as JSON: `caps`, and the five errors under `median`, `p95` and `worst`, as fractions.
pub fn summary_json(summary: &Summary) -> Value {
    let mut object = json!({ "caps": summary.caps });
    for (row, errors) in rows(summary) {
        object[row] = errors_json(&errors);
    }
    object
}

/// The five errors by name.
pub fn errors_json(errors: &Errors) -> Value {
    Errors::NAMES.iter().zip(errors.to_array()).map(|(name, error)| (name.to_string(), json!(error))).collect()
}

fn rows(summary: &Summary) -> [(&'static str, Errors); 3] {
    [("median", summary.median), ("p95", summary.p95), ("worst", summary.worst)]
}
