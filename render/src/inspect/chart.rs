//! Figures as SVG: the cut on the disk (Figs. 5–6) and error against #EAS (Fig. 7).

use super::{Compressed, Measured};
use crate::image::to_srgb;
use crate::scene::Rgb;
use glam::Vec2;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Plotters rounds to whole units of its canvas, so that one is this much finer than the figure.
const SCALE: u32 = 8;

/// Colours of the curves (Okabe and Ito 2008).
const PAPER: RGBColor = RGBColor(213, 94, 0);
const IMPROVED: RGBColor = RGBColor(0, 114, 178);
const GUIDED: RGBColor = RGBColor(0, 158, 115);

/// A drawing failed: what plotters says.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw: {0}")]
pub struct DrawError(String);

fn failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> DrawError {
    DrawError(error.to_string())
}

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// An SVG of a size in CSS pixels on white.
fn svg(size: (u32, u32), draw: impl FnOnce(&Canvas) -> Result<(), DrawError>) -> Result<String, DrawError> {
    let mut svg = String::new();
    let (width, height) = (size.0 * SCALE, size.1 * SCALE);
    {
        let canvas = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        canvas.fill(&WHITE).map_err(failed)?;
        draw(&canvas)?;
        canvas.present().map_err(failed)?;
    }
    let (fine, shown) =
        (format!("width=\"{width}\" height=\"{height}\""), format!("width=\"{}\" height=\"{}\"", size.0, size.1));
    Ok(svg.replacen(&fine, &shown, 1))
}

fn stroke(color: impl Color, width: f64) -> ShapeStyle {
    ShapeStyle { color: color.to_rgba(), filled: false, stroke_width: (width * f64::from(SCALE)).round() as u32 }
}

/// The cells of the cut, filled with their mean radiance times `exposure`; thin lines divide them as the comparison level
/// two below does, dots mark the centroids.
///
/// # Errors
/// A drawing that fails.
pub fn cut_svg(made: &Compressed, exposure: f32) -> Result<String, DrawError> {
    const SIZE: u32 = 640;
    let at = |p: Vec2| {
        let middle = 0.5 * (SIZE * SCALE) as f32;
        let q = middle + 0.97 * middle * Vec2::new(p.x, -p.y);
        (q.x.round() as i32, q.y.round() as i32)
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
            .draw(&Circle::new(
                at(Vec2::ZERO),
                (0.485 * (SIZE * SCALE) as f32) as i32,
                RGBColor(128, 128, 128).filled(),
            ))
            .map_err(failed)?;
        for &i in &made.cut.nodes {
            let radiance: Rgb = nodes[i].irradiance / nodes[i].cell.projected_solid_angle().max(f32::MIN_POSITIVE);
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
            let dot =
                Circle::new(at(Vec2::new(d.x, d.y)), (1.3 * f64::from(SCALE)) as i32, RGBColor(40, 140, 255).filled());
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
    let px = |x: u32| x * SCALE;
    let font = |size: u32| ("Helvetica, Arial, sans-serif", px(size)).into_font().color(&BLACK);
    svg((640, 440), |canvas| {
        let mut plot = ChartBuilder::on(canvas)
            .margin(px(12))
            .x_label_area_size(px(44))
            .y_label_area_size(px(64))
            .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())
            .map_err(failed)?;
        plot.configure_mesh()
            .x_desc("EAS in the record (40 bytes each)")
            .y_desc("RMSE / mean of the reflected radiance")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{}", (y * 1e6).round() / 1e6))
            .axis_desc_style(font(14))
            .label_style(font(12))
            .bold_line_style(stroke(RGBColor(214, 218, 224), 0.8))
            .light_line_style(stroke(RGBColor(214, 218, 224), 0.4))
            .axis_style(stroke(BLACK, 1.0))
            .draw()
            .map_err(failed)?;
        for (name, curve, color) in [("--eas paper", paper, PAPER), ("--eas improved", improved, IMPROVED)] {
            plot.draw_series(LineSeries::new(curve.iter().map(point), stroke(color, 1.8)))
                .map_err(failed)?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + px(20) as i32, y)], stroke(color, 1.8)));
            plot.draw_series(curve.iter().map(|m| Circle::new(point(m), px(3) as i32, color.filled())))
                .map_err(failed)?;
        }
        plot.draw_series([TriangleMarker::new(point(&guided), px(6) as i32, GUIDED.filled())])
            .map_err(failed)?
            .label("improved, guided by the views (against its own samples)")
            .legend(|(x, y)| TriangleMarker::new((x + px(10) as i32, y), px(5) as i32, GUIDED.filled()));
        plot.configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .legend_area_size(px(26))
            .margin(px(8))
            .label_font(font(12))
            .background_style(WHITE.mix(0.85))
            .draw()
            .map_err(failed)
    })
}
