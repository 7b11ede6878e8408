//! Which options a method can use: any other is refused, not ignored.

use super::image::Args;
use super::method::Method;
#[cfg(feature = "gpu")]
use anyhow::Context;
use anyhow::{Result, bail};
use clap::ValueEnum;
use render::integrator::cached::GlossyKind;
#[cfg(feature = "gpu")]
use render::integrator::cached::Interpolation;
use render::integrator::cached::kinds::{Eas, Harmonics};
#[cfg(feature = "gpu")]
use render::record::eas::Estimator;

/// An option that not every method can use.
struct Rule {
    option: &'static str,
    given: fn(&Args) -> bool,
    can: fn(Method) -> bool,
    /// Why the others cannot.
    why: &'static str,
}

const NO_RECORDS: &str = "path tracing keeps no records";
const NO_EAS: &str = "the others keep no equivalent area lights";
const NO_HARMONICS: &str = "the others keep no harmonics";

/// Methods that keep records.
fn cached(method: Method) -> bool {
    method != Method::Path
}

/// Methods that keep equivalent area lights.
fn eas(method: Method) -> bool {
    method == Method::Auto || method.is_kind(Eas::NAME)
}

fn harmonics(method: Method) -> bool {
    method.is_kind(Harmonics::NAME)
}

/// Methods that look anything up in tables.
fn tabled(method: Method) -> bool {
    method.allowed(1.0).is_some_and(|allowed| allowed.needs_tables())
}

const RULES: &[Rule] = &[
    Rule { option: "--tau", given: |a| a.tau.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--cache", given: |a| a.cache.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--radius", given: |a| a.radius.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--adaptive", given: |a| a.adaptive.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--interpolation", given: |a| a.interpolation.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--show-records", given: |a| a.show_records.is_some(), can: cached, why: NO_RECORDS },
    Rule { option: "--eas", given: |a| a.eas.is_some(), can: eas, why: NO_EAS },
    Rule { option: "--sources", given: |a| a.sources.is_some(), can: eas, why: NO_EAS },
    Rule {
        option: "--tables",
        given: |a| a.tables.is_some(),
        can: tabled,
        why: "the others look nothing up in tables",
    },
    Rule { option: "--order", given: |a| a.order.is_some(), can: harmonics, why: NO_HARMONICS },
    Rule { option: "--gradients", given: |a| a.gradients.is_some(), can: harmonics, why: NO_HARMONICS },
    Rule { option: "--basis", given: |a| a.basis.is_some(), can: harmonics, why: NO_HARMONICS },
    Rule {
        option: "--error",
        given: |a| a.error.is_some(),
        can: |method| method == Method::Path,
        why: "a cached picture does not know its error",
    },
];

/// Refuses options that the method cannot use, naming the methods that can.
///
/// # Errors
/// The first such option.
pub(super) fn check(args: &Args) -> Result<()> {
    for Rule { option, given, can, why } in RULES {
        if given(args) && !can(args.method) {
            bail!("{option} needs --method {}: {why}", listed(*can));
        }
    }
    check_card(args)
}

/// Refuses the graphics card where there is none, or no code for what is to be summed.
#[cfg(feature = "gpu")]
fn check_card(args: &Args) -> Result<()> {
    if args.interpolation == Some(Interpolation::Gpu) {
        if args.eas == Some(Estimator::Paper) {
            bail!("--interpolation gpu needs --eas improved: the card has no code for the other");
        }
        render::gpu::shared().context("--interpolation gpu")?;
    }
    Ok(())
}

/// Nothing to refuse: the choice is not there.
#[cfg(not(feature = "gpu"))]
fn check_card(_: &Args) -> Result<()> {
    Ok(())
}

/// Whether an option was given that asks for records.
pub(super) fn for_records(args: &Args) -> bool {
    RULES.iter().any(|rule| (rule.given)(args) && !(rule.can)(Method::Path))
}

/// `a, b or c`.
fn listed(can: fn(Method) -> bool) -> String {
    let names: Vec<_> = Method::value_variants().iter().filter(|m| can(**m)).map(|m| m.name()).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    }
}
