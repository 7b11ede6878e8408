//! Figures as SVG: the cut on the disk (Figs. 5–6) and error against #EAS (Fig. 7).

use super::{Compressed, Measured};
use crate::image::to_srgb;
use crate::scene::Rgb;
use glam::Vec2;
use kit::figure::{DrawError, PALETTE, at, failed, px, stroke, svg, text};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Colours of the curves.
const PAPER: RGBColor = PALETTE[1];
const IMPROVED: RGBColor = PALETTE[0];
const GUIDED: RGBColor = PALETTE[2];

/// The cells of the cut, filled with their mean radiance times `exposure`; thin lines divide them as the comparison level
/// two below does, dots mark the centroids.
///
/// # Errors
/// A drawing that fails.
pub fn cut_svg(made: &Compressed, exposure: f32) -> Result<String, DrawError> {
    const SIZE: f64 = 640.0;
    let at = |p: Vec2| {
        let middle = 0.5 * SIZE;
        at(middle + 0.97 * middle * f64::from(p.x), middle - 0.97 * middle * f64::from(p.y))
    };
    let nodes = made.tree.nodes();
    let outline = |i: usize| nodes[i].cell.outline().into_iter().map(at).collect::<Vec<_>>();
    let closed = |mut points: Vec<(i32, i32)>| {
        points.push(points[0]);
        points
    };
    svg((SIZE, SIZE), |canvas| {
        // The base disk: cells without samples stay grey.
        canvas
            .draw(&Circle::new(at(Vec2::ZERO), px(0.485 * SIZE), RGBColor(128, 128, 128).filled()))
            .map_err(failed)?;
        for &i in &made.cut.nodes {
            // The samples of a small cell rarely cover exactly its solid angle: theirs counts.
            let cosine = nodes[i].cell.projected_solid_angle() / nodes[i].cell.solid_angle();
            let radiance: Rgb = nodes[i].irradiance / (cosine * nodes[i].solid_angle).max(f32::MIN_POSITIVE);
            let [r, g, b] = (radiance * exposure).to_array().map(|x| (255.0 * to_srgb(x) + 0.5) as u8);
            canvas.draw(&Polygon::new(outline(i), RGBColor(r, g, b).filled())).map_err(failed)?;
        }
        let pale = stroke(RGBColor(150, 150, 150), 0.25);
        for &i in &made.cut.nodes {
            let below = nodes[i].children().flat_map(|c| core::iter::once(c).chain(nodes[c].children()));
            for j in below {
                canvas.draw(&PathElement::new(closed(outline(j)), pale)).map_err(failed)?;
            }
        }
        for &i in &made.cut.nodes {
            canvas.draw(&PathElement::new(closed(outline(i)), stroke(RGBColor(230, 60, 40), 0.9))).map_err(failed)?;
        }
        for &i in &made.cut.nodes {
            let d = nodes[i].direction;
            let dot = Circle::new(at(Vec2::new(d.x, d.y)), px(1.3), RGBColor(40, 140, 255).filled());
            canvas.draw(&dot).map_err(failed)?;
        }
        Ok(())
    })
}

/// Error against #EAS, both axes logarithmic: both estimators over the same samples, and the guided record of a rendering
/// as a single point.
///
/// # Errors
/// A drawing that fails.
pub fn error_svg(paper: &[Measured], improved: &[Measured], guided: Measured) -> Result<String, DrawError> {
    // A log scale has no zero: an error of exactly 0 sits on the lower edge.
    const FLOOR: f64 = 1e-6;
    let point = |m: &Measured| (m.eas.max(1) as f64, f64::from(m.error).max(FLOOR));
    let all = || paper.iter().chain(improved).chain([&guided]).map(point);
    let range = |of: fn((f64, f64)) -> f64| {
        let (low, high) = all().map(of).fold((f64::INFINITY, 0f64), |(a, b), x| (a.min(x), b.max(x)));
        0.8 * low..1.25 * high
    };
    svg((640.0, 440.0), |canvas| {
        let mut plot = ChartBuilder::on(canvas)
            .margin(px(12.0))
            .x_label_area_size(px(44.0))
            .y_label_area_size(px(64.0))
            .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())
            .map_err(failed)?;
        plot.configure_mesh()
            .x_desc("EAS in the record (40 bytes each)")
            .y_desc("RMSE / mean of the reflected radiance")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{}", (y * 1e6).round() / 1e6))
            .axis_desc_style(text(11.5, &BLACK, HPos::Center))
            .x_label_style(text(10.0, &BLACK, HPos::Center))
            .y_label_style(text(10.0, &BLACK, HPos::Right))
            .bold_line_style(stroke(RGBColor(214, 218, 224), 0.8))
            .light_line_style(TRANSPARENT)
            .x_labels(8)
            .y_labels(8)
            .axis_style(stroke(BLACK, 1.0))
            .draw()
            .map_err(failed)?;
        for (name, curve, color) in [("--eas paper", paper, PAPER), ("--eas improved", improved, IMPROVED)] {
            plot.draw_series(LineSeries::new(curve.iter().map(point), stroke(color, 1.8)))
                .map_err(failed)?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + px(20.0), y)], stroke(color, 1.8)));
            plot.draw_series(curve.iter().map(|m| Circle::new(point(m), px(3.0), color.filled()))).map_err(failed)?;
        }
        plot.draw_series([TriangleMarker::new(point(&guided), px(6.0), GUIDED.filled())])
            .map_err(failed)?
            .label("improved, guided by the views (against its own samples)")
            .legend(|(x, y)| TriangleMarker::new((x + px(10.0), y), px(5.0), GUIDED.filled()));
        plot.configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .legend_area_size(px(26.0))
            .margin(px(8.0))
            .label_font(text(10.0, &BLACK, HPos::Left))
            .background_style(WHITE.mix(0.85))
            .draw()
            .map_err(failed)
    })
}
