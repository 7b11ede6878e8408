//! Line charts as SVG within a page.

use std::fmt::Write;

/// Size of a chart, CSS pixels, and its margins: left, right, top, bottom.
const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 280.0;
const MARGINS: [f64; 4] = [58.0, 12.0, 12.0, 40.0];

/// Colours that stay apart for most eyes (Okabe and Ito 2008): of the data, then of models by their rank.
pub const COLORS: [&str; 8] = ["#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#785e3c"];

/// One line of a chart.
pub struct Line {
    /// Colour.
    pub color: &'static str,
    /// Points; those that are not positive are left out of a logarithmic chart.
    pub points: Vec<(f64, f64)>,
}

/// Axes of a chart.
pub struct Axes {
    /// What stands below.
    pub x: &'static str,
    /// What stands beside.
    pub y: &'static str,
    /// Whether y is logarithmic.
    pub logarithmic: bool,
    /// A level to mark.
    pub mark: Option<f64>,
}

/// The chart.
pub fn chart(axes: &Axes, lines: &[Line]) -> String {
    let shown = |y: f64| if axes.logarithmic { y.max(1e-300).log10() } else { y };
    let points =
        || lines.iter().flat_map(|l| &l.points).filter(|p| p.1.is_finite() && (!axes.logarithmic || p.1 > 0.0));
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    let (x0, x1) = range(&mut points().map(|p| p.0));
    let (mut y0, mut y1) = range(&mut points().map(|p| shown(p.1)));
    if !(x1 > x0 && y1 >= y0) {
        return String::new();
    }
    if axes.logarithmic {
        // Six decades below the top say enough.
        (y0, y1) = (y0.max(y1 - 6.0).floor(), y1.ceil().max(y0.floor() + 1.0));
    } else {
        (y0, y1) = (0.0f64.min(y0), (1.05 * y1).max(axes.mark.unwrap_or(0.0)).max(1e-12));
    }
    let [left, right, top, bottom] = MARGINS;
    let px = |x: f64| left + (x - x0) / (x1 - x0) * (WIDTH - left - right);
    let py = |y: f64| top + (y1 - y) / (y1 - y0) * (HEIGHT - top - bottom);
    let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" role=\"img\">");
    let mut grid = |x: [f64; 2], y: [f64; 2], class: &str| {
        let _ = write!(svg, "<path class=\"{class}\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>", x[0], y[0], x[1], y[1]);
    };
    let step = |span: f64| {
        let raw = span / 5.0;
        let power = 10f64.powf(raw.log10().floor());
        power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= raw).unwrap_or(10.0)
    };
    let ticks = |from: f64, to: f64, step: f64| {
        let first = (from / step).ceil() as i64;
        (first..=(to / step).floor() as i64).map(move |i| i as f64 * step)
    };
    let x_step = if x1 - x0 > 60.0 { if x1 - x0 > 100.0 { 30.0 } else { 15.0 } } else { step(x1 - x0) };
    let y_step = if axes.logarithmic { 1.0 } else { step(y1 - y0) };
    ticks(x0, x1, x_step).for_each(|x| grid([px(x), px(x)], [top, HEIGHT - bottom], "grid"));
    ticks(y0, y1, y_step).for_each(|y| grid([left, WIDTH - right], [py(y), py(y)], "grid"));
    if let Some(mark) = axes.mark {
        grid([left, WIDTH - right], [py(shown(mark)), py(shown(mark))], "mark");
    }
    for x in ticks(x0, x1, x_step) {
        let _ =
            write!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" class=\"x\">{}</text>", px(x), HEIGHT - bottom + 15.0, tidy(x));
    }
    for y in ticks(y0, y1, y_step) {
        let label = if axes.logarithmic { format!("1e{y}") } else { tidy(y) };
        let _ = write!(svg, "<text x=\"{:.1}\" y=\"{:.1}\" class=\"y\">{label}</text>", left - 6.0, py(y) + 4.0);
    }
    for line in lines {
        let mut path = String::new();
        for (x, y) in &line.points {
            if y.is_finite() && (!axes.logarithmic || *y > 0.0) {
                let y = py(shown(*y)).clamp(top, HEIGHT - bottom);
                let _ = write!(path, "{}{:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' }, px(*x));
            }
        }
        let _ = write!(svg, "<path class=\"line\" stroke=\"{}\" d=\"{path}\"/>", line.color);
    }
    let (mx, my) = (0.5 * (left + WIDTH - right), 0.5 * (top + HEIGHT - bottom));
    let _ = write!(svg, "<text x=\"{mx:.1}\" y=\"{:.1}\" class=\"x\">{}</text>", HEIGHT - 6.0, axes.x);
    let _ = write!(svg, "<text transform=\"translate(13 {my:.1}) rotate(-90)\" class=\"x\">{}</text></svg>", axes.y);
    svg
}

/// A number without trailing zeros.
fn tidy(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
