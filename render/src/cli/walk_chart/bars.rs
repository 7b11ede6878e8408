//! The figures of all methods in one table, each over those of path tracing with a denoiser.

use super::frame::Measured;
use super::runs::RIVAL;
use std::fmt::Write;

/// A method in a time, over the rival in the same time.
pub(super) struct Ratios {
    pub error: f64,
    pub flicker: Option<f64>,
}

/// Error and flicker of a method over those of the rival.
pub(super) fn ratios(all: &[Measured], of: &Measured) -> Option<Ratios> {
    let rival = all.iter().find(|m| m.seconds == of.seconds && m.method.name == RIVAL)?;
    let error = of.mean(|c| c.rel_mse) / rival.mean(|c| c.rel_mse);
    Some(Ratios { error, flicker: of.flicker.zip(rival.flicker).map(|(a, b)| a / b) })
}

/// For people.
pub(super) fn table(all: &[Measured]) -> String {
    let mut text = format!(
        "{:>8} {:>18} {:>7} {:>7} {:>5} {:>9} {:>9} {:>8} {:>9} {:>6} {:>8}\n",
        "seconds", "method", "spent", "tau", "spp", "rel_mse", "trimmed", "bias", "flicker", "error", "flicker"
    );
    for m in all {
        let or_none = |x: Option<f64>, digits: usize| x.map_or("-".into(), |x| format!("{x:.digits$}"));
        let ratios = ratios(all, m);
        let (error, flicker) = (ratios.as_ref().map(|r| r.error), ratios.as_ref().and_then(|r| r.flicker));
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{:>8} {:>18} {:>7.2} {:>7.4} {:>5} {:>9.6} {:>9.6} {:>+7.2}% {:>9} {:>6} {:>8}",
            m.seconds,
            m.method.name,
            m.spent,
            m.tau,
            m.spp,
            m.mean(|c| c.rel_mse),
            m.mean(|c| c.trimmed),
            100.0 * m.mean(|c| c.bias),
            or_none(m.flicker, 6),
            or_none(error, 2),
            or_none(flicker, 2)
        );
    }
    text + &format!("The last two columns are over those of {RIVAL} in the same time.\n")
}
