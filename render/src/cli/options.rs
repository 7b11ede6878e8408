//! Which options a method can use: any other is refused, not ignored.

use super::image::Args;
use super::method::Method;
use anyhow::{Result, bail};

/// An option that not every method can use.
struct Rule {
    option: &'static str,
    given: fn(&Args) -> bool,
    methods: &'static [Method],
    /// Why the others cannot.
    why: &'static str,
}

/// Methods that keep records.
const CACHED: &[Method] = &[Method::Auto, Method::Eas, Method::Sh, Method::Irradiance];
const NO_RECORDS: &str = "path tracing keeps no records";
/// Methods that keep equivalent area lights.
const EAS: &[Method] = &[Method::Auto, Method::Eas];
const NO_EAS: &str = "the others keep no equivalent area lights";
const SH: &[Method] = &[Method::Sh];
const NO_HARMONICS: &str = "the others keep no harmonics";

const RULES: &[Rule] = &[
    Rule { option: "--tau", given: |a| a.tau.is_some(), methods: CACHED, why: NO_RECORDS },
    Rule { option: "--cache", given: |a| a.cache.is_some(), methods: CACHED, why: NO_RECORDS },
    Rule { option: "--radius", given: |a| a.radius.is_some(), methods: CACHED, why: NO_RECORDS },
    Rule { option: "--adaptive", given: |a| a.adaptive.is_some(), methods: CACHED, why: NO_RECORDS },
    Rule { option: "--show-records", given: |a| a.show_records.is_some(), methods: CACHED, why: NO_RECORDS },
    Rule { option: "--eas", given: |a| a.eas.is_some(), methods: EAS, why: NO_EAS },
    Rule { option: "--sources", given: |a| a.sources.is_some(), methods: EAS, why: NO_EAS },
    Rule {
        option: "--tables",
        given: |a| a.tables.is_some(),
        methods: EAS,
        why: "the others look nothing up in tables",
    },
    Rule { option: "--order", given: |a| a.order.is_some(), methods: SH, why: NO_HARMONICS },
    Rule { option: "--gradients", given: |a| a.gradients.is_some(), methods: SH, why: NO_HARMONICS },
    Rule { option: "--basis", given: |a| a.basis.is_some(), methods: SH, why: NO_HARMONICS },
    Rule {
        option: "--error",
        given: |a| a.error.is_some(),
        methods: &[Method::Path],
        why: "a cached picture does not know its error",
    },
];

/// Refuses options that the method cannot use, naming the methods that can.
///
/// # Errors
/// The first such option.
pub(super) fn check(args: &Args) -> Result<()> {
    for Rule { option, given, methods, why } in RULES {
        if given(args) && !methods.contains(&args.method) {
            bail!("{option} needs --method {}: {why}", listed(methods));
        }
    }
    Ok(())
}

/// `a, b or c`.
fn listed(methods: &[Method]) -> String {
    let names: Vec<_> = methods.iter().map(|m| m.name()).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    }
}
