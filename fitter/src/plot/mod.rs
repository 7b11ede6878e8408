//! Polar cuts of the mean BRDF in the plane of incidence, exact against table, as in Figure 4 of the 2015 paper.

mod panel;

use brdf_tables::cap::Cap;
use brdf_tables::errors::Errors;
use brdf_tables::quadrature::mean_brdf;
use brdf_tables::table::Table;
use core::f64::consts::FRAC_PI_2;
use fitter::check::errors_of;
use glam::DVec3;
use kit::figure::{INK, at, failed, svg, text};
use kit::text::shortened;
use panel::{HEIGHT, WIDTH};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Directions of a curve.
const DIRECTIONS: usize = 1441;
/// Zenith angle where the curves end, half a degree above the horizon: some models grow without bound there.
const HIGHEST: f64 = FRAC_PI_2 - 0.0087;
/// Relative tolerance of the exact curve: invisible.
const TOLERANCE: f64 = 1e-5;
/// Space above the panels for the legend, px.
const LEGEND: f64 = 44.0;
/// Space above a row for its title, px.
const TITLE: f64 = 30.0;

/// The specular mean BRDF of one cap in its plane of incidence.
pub struct Cut {
    cap: Cap,
    caption: String,
    /// Signed zenith angle of wo (positive on the mirror side, radian), exact and tabulated F (sr⁻¹).
    samples: Vec<(f64, f64, f64)>,
    errors: Errors,
}

impl Cut {
    /// Cuts through the table and the truth; `None` for a diffuse material.
    pub fn new(table: &Table, cap: Cap, caption: String) -> Option<Self> {
        let (mean, specular) = (table.mean()?, table.specular()?);
        let (sin_p, cos_p) = cap.phi().sin_cos();
        let sample = |i: usize| {
            let t = (2.0 * i as f64 / (DIRECTIONS - 1) as f64 - 1.0) * HIGHEST;
            let (s, c) = t.sin_cos();
            let wo = DVec3::new(-s * cos_p, -s * sin_p, c);
            (t, mean_brdf(specular, &cap, wo, TOLERANCE, 0.0), mean.value(&cap, wo))
        };
        let samples = (0..DIRECTIONS).map(sample).collect();
        Some(Self { cap, caption, samples, errors: errors_of(mean, specular, &cap) })
    }
}

/// The figure: one row per table, one panel per solid angle.
pub fn figure(rows: &[(String, Vec<Cut>)]) -> anyhow::Result<String> {
    let columns = rows.iter().map(|row| row.1.len()).max().unwrap_or(1);
    let size = (WIDTH * columns as f64, LEGEND + rows.len() as f64 * (TITLE + HEIGHT) + 10.0);
    svg(size, |canvas| {
        panel::legend(canvas, size.0)?;
        for (i, (title, cuts)) in rows.iter().enumerate() {
            let top = LEGEND + i as f64 * (TITLE + HEIGHT);
            let title = shortened(title, (size.0 / 7.2) as usize);
            let style = text(14.0, &INK, HPos::Center);
            canvas.draw(&Text::new(title, at(0.5 * size.0, top + 0.5 * TITLE), style)).map_err(failed)?;
            let left = 0.5 * (size.0 - WIDTH * cuts.len() as f64);
            for (j, cut) in cuts.iter().enumerate() {
                panel::draw(canvas, (left + WIDTH * j as f64, top + TITLE), cut)?;
            }
        }
        Ok(())
    })
}
