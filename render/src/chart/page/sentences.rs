//! Which method wins where, and by how much, in words.

use super::html::escape;
use super::reach::{Reach, reach};
use crate::chart::figures::{Runs, is_budget, methods};
use crate::chart::plot::plain;
use crate::chart::row::Row;

/// Ratios nearer to 1 than this are called level: two runs of one method differ as much.
const LEVEL: f64 = 1.1;

/// Sentences on the rows of a scene, as HTML.
pub fn sentences(rows: &[&Row]) -> Vec<String> {
    at_equal_time(rows).into_iter().chain(time_of_equal_error(rows)).chain(memory(rows)).collect()
}

/// One sentence per time budget.
fn at_equal_time(rows: &[&Row]) -> Vec<String> {
    let mut budgets: Vec<&str> = Vec::new();
    rows.iter().filter(|r| is_budget(r)).for_each(|r| {
        if !budgets.contains(&r.setting.as_str()) {
            budgets.push(&r.setting);
        }
    });
    let seconds = |s: &str| s.trim_start_matches("time=").parse::<f64>().unwrap_or(f64::INFINITY);
    budgets.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    budgets
        .into_iter()
        .filter_map(|budget| {
            let mut at: Vec<_> = rows.iter().filter(|r| r.setting == budget).collect();
            at.sort_by(|a, b| a.rel_mse.total_cmp(&b.rel_mse));
            let (best, next) = (at.first()?, at.get(1)?);
            let mut text = format!(
                "At {} s <b>{}</b> has the least error, rel_mse {}",
                escape(budget.trim_start_matches("time=")),
                escape(&best.method),
                plain(&best.rel_mse)
            );
            let over = |other: &Row| times(other.rel_mse / best.rel_mse);
            text += &format!("; the next, {}, has {}", escape(&next.method), over(next));
            if let Some(path) = at.iter().find(|r| r.method == "path" && r.method != next.method && r != &best) {
                text += &format!("; path tracing has {}", over(path));
            }
            Some(text + ".")
        })
        .collect()
}

/// "2.5 times it", or that it is level.
fn times(ratio: f64) -> String {
    if ratio < LEVEL {
        return "as much, within the scatter of a run".into();
    }
    format!("{} times as much", if ratio >= 10.0 { format!("{ratio:.0}") } else { format!("{ratio:.1}") })
}

/// Seconds and errors of a method's runs with a time budget.
fn over_time(rows: &[&Row], method: &str) -> Vec<(f64, f64)> {
    Runs::Budgets.of(rows.iter().copied(), method).iter().map(|r| (r.seconds, r.rel_mse)).collect()
}

/// How long the others take to path tracing's error after its longest run.
fn time_of_equal_error(rows: &[&Row]) -> Option<String> {
    let path = over_time(rows, "path");
    let (slowest, level) = path.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut parts = Vec::new();
    for method in methods(rows.iter().copied()).into_iter().filter(|m| *m != "path") {
        let mut curve = over_time(rows, method);
        if curve.is_empty() {
            // A peer's runs have settings of their own.
            curve = rows.iter().filter(|r| r.method == method).map(|r| (r.seconds, r.rel_mse)).collect();
        }
        let name = escape(method);
        parts.push(match reach(&curve, level) {
            Reach::Within(x) => {
                format!("{name} no more than {} s ({:.1} times faster or better)", plain(&x), slowest / x)
            }
            Reach::At(x) if x <= slowest => format!("{name} {} s ({:.1} times faster)", plain(&x), slowest / x),
            Reach::At(x) => format!("{name} {} s ({:.1} times slower)", plain(&x), x / slowest),
            Reach::Never => format!("{name} never in its runs"),
        });
    }
    if parts.is_empty() {
        return None;
    }
    let (level, slowest) = (plain(&level), plain(&slowest));
    Some(format!("To the error of path tracing after {slowest} s ({level}) come: {}.", parts.join(", ")))
}

/// What a record takes at the least error that all of the methods with records reach.
fn memory(rows: &[&Row]) -> Option<String> {
    let curves: Vec<_> = methods(rows.iter().copied())
        .into_iter()
        .map(|m| {
            let own = Runs::Sizes.of(rows.iter().copied(), m);
            (m, own.iter().map(|r| (r.bytes_per_record, r.rel_mse)).filter(|p| p.0 > 0.0).collect::<Vec<_>>())
        })
        .filter(|(_, c)| !c.is_empty())
        .collect();
    let least = |c: &[(f64, f64)]| c.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let level = curves.iter().map(|(_, c)| least(c)).fold(0.0, f64::max);
    if curves.len() < 2 {
        return None;
    }
    let parts: Vec<_> = curves
        .iter()
        .filter_map(|(m, c)| match reach(c, level) {
            Reach::Within(x) => Some(format!("{} at most {:.0}", escape(m), x)),
            Reach::At(x) => Some(format!("{} {:.0}", escape(m), x)),
            Reach::Never => None,
        })
        .collect();
    Some(format!("Bytes of a glossy record where all come to rel_mse {}: {}.", plain(&level), parts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, setting: &str, seconds: f64, rel_mse: f64, bytes_per_record: f64) -> Row {
        Row { method: method.into(), setting: setting.into(), seconds, rel_mse, bytes_per_record, ..Row::default() }
    }

    #[test]
    fn winners_and_ratios_come_from_the_rows() {
        let rows = [
            row("path", "time=1", 1.0, 0.04, 0.0),
            row("path", "time=2", 2.0, 0.02, 0.0),
            row("eas", "time=1", 1.0, 0.002, 1000.0),
            row("eas", "time=2", 2.0, 0.02, 1000.0),
            row("eas", "tau=0.1", 0.5, 0.01, 500.0),
            row("eas-paper", "tau=0.1", 0.5, 0.02, 900.0),
            row("eas-paper", "tau=0.02", 0.5, 0.005, 3600.0),
        ];
        let text = sentences(&rows.iter().collect::<Vec<_>>());
        assert_eq!(text.len(), 4, "{text:?}");
        assert_eq!(
            text[0],
            "At 1 s <b>eas</b> has the least error, rel_mse 0.002; the next, path, has 20 times as much."
        );
        assert!(text[1].contains("path, has as much") || text[1].contains("eas, has as much"), "{}", text[1]);
        assert!(text[2].contains("eas no more than 1 s (2.0 times faster or better)"), "{}", text[2]);
        assert!(text[3].contains("eas at most 500") && text[3].contains("eas-paper 1800"), "{}", text[3]);
    }
}
