//! Which materials are cached with EAS: those whose lobe a table holds, where asked for only those wide enough to pay.

use super::Eas;
use crate::record::Albedo;
use brdf_tables::brdf::Specular;
use brdf_tables::material::Material as Recipe;
use brdf_tables::table::Table;
use serde::Serialize;

/// A table with what follows from it.
#[derive(Clone, Debug)]
pub struct Lobe {
    /// What it is of.
    pub specular: Specular,
    /// Mean BRDF.
    pub table: Table,
    /// Directional albedo and support.
    pub albedo: Albedo,
    /// Width of the lobe, radian.
    pub width: f32,
}

/// A material held through a table; `traced` is the share of path tracing mixed in, so that there is no step between
/// materials that are cached and those too sharp to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Held {
    /// Index into [`Eas::lobes`].
    pub lobe: usize,
    /// 0 all cached … 1 all traced.
    pub traced: f32,
}

/// How sharp lobes may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sharpness {
    /// As sharp as tables go.
    #[default]
    Any,
    /// As sharp as it pays.
    Paying,
}

/// Lobes at least this wide (n ≤ 700) are cached; those narrower than [`TRACED_WIDTH`] (n ≥ 1000) are traced.
const CACHED_WIDTH: f32 = 0.0378;
const TRACED_WIDTH: f32 = 0.0316;

/// The share of path tracing of a lobe of this width, where EAS are used as they pay.
fn traced_share(width: f32) -> f32 {
    ((CACHED_WIDTH - width) / (CACHED_WIDTH - TRACED_WIDTH)).clamp(0.0, 1.0)
}

impl Eas {
    /// Finds the table of a specular part, unless its lobe is too sharp.
    pub(super) fn wanted<E>(
        &mut self,
        specular: Specular,
        table: &mut impl FnMut(&Recipe) -> Result<Table, E>,
    ) -> Result<(Option<Held>, String), E> {
        let width = specular.lobe_width() as f32;
        let traced = match self.sharpest {
            Sharpness::Any => 0.0,
            Sharpness::Paying => traced_share(width),
        };
        if traced >= 1.0 {
            return Ok((None, too_sharp(width)));
        }
        let lobe = match self.lobes.iter().position(|l| l.specular == specular) {
            Some(known) => known,
            None => {
                let table = table(&Recipe::specular(specular))?;
                let albedo = Albedo::new(&table);
                self.lobes.push(Lobe { specular, table, albedo, width });
                self.lobes.len() - 1
            }
        };
        let share = if traced > 0.0 { format!(", {:.0} % traced", 100.0 * traced) } else { String::new() };
        Ok((Some(Held { lobe, traced }), format!("cached (lobe {width:.3} rad{share})")))
    }
}

/// What [`Sharpness::Paying`] does with a specular part.
pub(super) fn outlook(specular: &Specular) -> String {
    let width = specular.lobe_width() as f32;
    match traced_share(width) {
        share if share >= 1.0 => too_sharp(width),
        share if share > 0.0 => format!("EAS records (lobe {width:.3} rad, {:.0} % traced)", 100.0 * share),
        _ => format!("EAS records (lobe {width:.3} rad)"),
    }
}

fn too_sharp(width: f32) -> String {
    format!("path traced (lobe {width:.3} rad is too sharp to cache)")
}
