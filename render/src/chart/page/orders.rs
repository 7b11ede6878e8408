//! Fig. 2 of radiance-caching-2005: the order that each outgoing direction of a BRDF takes, and what it loses.

use super::html::picture;
use crate::chart::Results;
use crate::chart::method::{self, Size};
use anyhow::Result;
use brdf_tables::brdf::Specular;
use fitter::recipe;
use glam::Vec3A;
use kit::figure::{DrawError, INK, PALE, PALETTE, failed, px, stroke, svg, text};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use render::image::{Image, write_png, write_whole};
use render::metric::color;
use render::record::harmonics::{Basis, HarmonicBrdf, MAX_ORDER, OrderChoice};
use std::fmt::Write;
use std::path::Path;

/// The published BRDFs, and one that the published order of 10 does not hold.
const BRDFS: [(&str, &str); 3] = [
    ("phong-15", "phong:exponent=15"),
    ("ward-0.6-0.25", "ward:alpha_x=0.6,alpha_y=0.25"),
    ("phong-100", "phong:exponent=100"),
];

/// Largest error of a direction: the root of the share of the squared norm that is lost.
const ERROR: f32 = 0.05;

/// Pixels of a disk.
const SIZE: u32 = 128;

/// What is outside of the disk, and directions that are not cached.
const OUTSIDE: [f32; 3] = [1.0; 3];
const TRACED: [f32; 3] = [0.6; 3];

/// The section, where harmonics chose their orders.
///
/// # Errors
/// A drawing that fails, a file that cannot be written.
pub fn section(results: &Results, folder: &Path) -> Result<Option<String>> {
    let adaptive = |name: &str| method::find(name).is_some_and(|m| m.size == Some(Size::Order));
    if results.plan.stability || !results.rows.iter().any(|r| adaptive(&r.method)) {
        return Ok(None);
    }
    let mut text = format!(
        "<h2 id=\"orders\">Orders of harmonics</h2>\n<p>As radiance-caching-2005, Fig. 2: the least order of hemispherical \
         harmonics that represents f<sub>r</sub> cosθ to {:.0} %, for outgoing directions on a parabolic map. Disks: the error \
         (0 to {:.0} %; grey where no order up to {MAX_ORDER} holds it and paths are traced). Curves: the order along the \
         horizontal diameter. The paper ends at order 10: there the Ward model is not cached for some directions, as here \
         beyond the dashed line.</p>\n<div class=\"pictures\">\n",
        100.0 * ERROR,
        100.0 * ERROR
    );
    for (name, text_of) in BRDFS {
        let Some(specular) = recipe::material(text_of)?.specular else { continue };
        let brdf = HarmonicBrdf::new(specular, Basis::Hemispherical, OrderChoice::Error(ERROR * ERROR));
        let disk = folder.join(format!("order-{name}.png"));
        write_png(&disk, &errors(&brdf))?;
        let curve = orders(&brdf, &specular)?;
        write_whole(&folder.join(format!("order-{name}.svg")), curve.as_bytes())?;
        let picture = picture(&std::fs::read(&disk)?, &format!("errors of {name}"));
        let _ = writeln!(text, "<figure>{picture}{}<figcaption>{text_of}</figcaption></figure>", curve.trim());
    }
    Ok(Some(text + "</div>\n"))
}

/// The direction of a point of the map, inside of the unit disk.
fn direction(x: f32, y: f32) -> Option<Vec3A> {
    let r2 = x * x + y * y;
    (r2 < 1.0).then(|| Vec3A::new(2.0 * x, 2.0 * y, 1.0 - r2) / (1.0 + r2))
}

/// The disk of errors.
fn errors(brdf: &HarmonicBrdf) -> Image {
    let place = |i: u32| 2.0 * (i as f32 + 0.5) / SIZE as f32 - 1.0;
    let pixel = |i: u32| match direction(place(i % SIZE), -place(i / SIZE)).map(|wo| brdf.representation(wo)) {
        None => OUTSIDE,
        Some(None) => TRACED,
        Some(Some((_, lost))) => color(lost.max(0.0).sqrt() / ERROR).map(|c| c.powf(2.2)),
    };
    Image { width: SIZE, height: SIZE, pixels: (0..SIZE * SIZE).map(pixel).collect() }
}

/// The order along the diameter; gaps where paths are traced.
fn orders(brdf: &HarmonicBrdf, specular: &Specular) -> Result<String, DrawError> {
    const STEPS: i32 = 256;
    let at = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 1.0;
    let order = |i: i32| {
        let x = at(i);
        let found = direction(x as f32, 0.0).and_then(|wo| brdf.representation(wo));
        found.map(|(order, _)| (x, order as f64))
    };
    let points: Vec<_> = (0..STEPS).map(order).collect();
    let color = PALETTE[if specular.is_isotropic() { 0 } else { 1 }];
    svg((300.0, 200.0), |canvas| {
        let mut plot = ChartBuilder::on(canvas)
            .margin(px(8.0))
            .x_label_area_size(px(30.0))
            .y_label_area_size(px(38.0))
            .build_cartesian_2d(-1.0..1.0, 0.0..MAX_ORDER as f64 + 1.0)
            .map_err(failed)?;
        plot.configure_mesh()
            .x_desc("place on the diameter")
            .y_desc("order")
            .axis_desc_style(text(10.0, &INK, HPos::Center))
            .x_label_style(text(9.0, &INK, HPos::Center))
            .y_label_style(text(9.0, &INK, HPos::Right))
            .bold_line_style(stroke(PALE, 0.7))
            .light_line_style(TRANSPARENT)
            .x_labels(5)
            .y_labels(6)
            .axis_style(stroke(INK, 0.8))
            .draw()
            .map_err(failed)?;
        let limit = DashedLineSeries::new([(-1.0, 10.0), (1.0, 10.0)], px(5.0), px(4.0), stroke(INK, 0.8));
        plot.draw_series(limit).map_err(failed)?;
        for run in points.split(Option::is_none).filter(|run| !run.is_empty()) {
            plot.draw_series(LineSeries::new(run.iter().flatten().copied(), stroke(color, 1.6))).map_err(failed)?;
        }
        Ok(())
    })
}
