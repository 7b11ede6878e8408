//! Drawing in SVG: sizes in CSS pixels, text styles, colours.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// plotters rounds to whole units of its canvas, so that one is this much finer than the figure.
pub const SCALE: f64 = 8.0;

/// Colour of text and axes.
pub const INK: RGBColor = RGBColor(40, 44, 52);
/// Colour of what should stay in the background.
pub const PALE: RGBColor = RGBColor(214, 218, 224);
/// Colours that stay apart for most eyes (Okabe & Ito 2008, and two greys, then darker and paler ones), in the order they
/// are handed out.
pub const PALETTE: [RGBColor; 14] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 60),
    RGBColor(150, 60, 160),
    RGBColor(90, 90, 90),
    RGBColor(160, 160, 160),
    RGBColor(0, 48, 96),
    RGBColor(160, 16, 40),
    RGBColor(128, 160, 0),
    RGBColor(244, 150, 180),
];

/// Part of a figure in canvas units.
pub type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Length in canvas units.
pub fn px(length: f64) -> i32 {
    (length * SCALE).round() as i32
}

/// Point in canvas units.
pub fn at(x: f64, y: f64) -> (i32, i32) {
    (px(x), px(y))
}

/// Stroke of a width in CSS pixels.
pub fn stroke(color: impl Color, width: f64) -> ShapeStyle {
    ShapeStyle { color: color.to_rgba(), filled: false, stroke_width: px(width) as u32 }
}

/// Text of a height in CSS pixels, anchored at a side of its line.
pub fn text<'a>(size: f64, color: &RGBColor, side: HPos) -> TextStyle<'a> {
    // plotters divides the size it is given by this.
    let size = 1.24 * size * SCALE;
    ("Helvetica, Arial, sans-serif", size).into_font().color(color).pos(Pos::new(side, VPos::Center))
}

/// A drawing failed: what plotters says.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw: {0}")]
pub struct DrawError(String);

/// An SVG of the given size in CSS pixels, painted white and drawn upon.
///
/// # Errors
/// Those of `draw`, and a canvas that cannot be drawn upon.
pub fn svg<E: From<DrawError>>(size: (f64, f64), draw: impl FnOnce(&Canvas) -> Result<(), E>) -> Result<String, E> {
    let mut svg = String::new();
    let (width, height) = (px(size.0) as u32, px(size.1) as u32);
    {
        let canvas = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        canvas.fill(&WHITE).map_err(failed)?;
        draw(&canvas)?;
        canvas.present().map_err(failed)?;
    }
    // Drawn on the fine canvas, shown at the size asked for.
    let (fine, shown) =
        (format!("width=\"{width}\" height=\"{height}\""), format!("width=\"{}\" height=\"{}\"", size.0, size.1));
    Ok(svg.replacen(&fine, &shown, 1))
}

/// What plotters reports, without its borrowed parts.
pub fn failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> DrawError {
    DrawError(error.to_string())
}
