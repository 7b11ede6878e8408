//! Figures over the frames of a walk, as SVG.

use super::frame::{Frame, Measured};
use std::fmt::Write;

/// Size of a figure and its margins, px.
const SIZE: [f64; 2] = [600.0, 340.0];
const LEFT: f64 = 76.0;
const TOP: f64 = 34.0;
const RIGHT: f64 = 16.0;
const BOTTOM: f64 = 44.0;

/// What a figure shows.
pub(super) struct Figure {
    /// Name of its file.
    pub name: &'static str,
    pub title: &'static str,
    /// Whether its axis is logarithmic.
    logarithmic: bool,
    of: fn(&Frame) -> Option<f64>,
}

/// All figures.
pub(super) const FIGURES: [Figure; 3] = [
    Figure { name: "error", title: "rel_mse", logarithmic: true, of: |f| Some(f.figures.rel_mse) },
    Figure { name: "bias", title: "bias, %", logarithmic: false, of: |f| Some(100.0 * f.figures.bias) },
    Figure { name: "flicker", title: "flicker", logarithmic: true, of: |f| f.flicker },
];

impl Figure {
    /// The curves of methods over the frames. What a logarithm has no place for is left out: with two references an error below
    /// their noise may come out negative.
    pub fn draw(&self, methods: &[&Measured]) -> String {
        let shown = |f: &Frame| {
            (self.of)(f).filter(|y| !self.logarithmic || *y > 0.0).map(|y| (f64::from(f.number), self.level(y)))
        };
        let all: Vec<(f64, f64)> = methods.iter().flat_map(|m| m.frames.iter().filter_map(shown)).collect();
        let (x_low, x_high) = bounds(all.iter().map(|p| p.0), 0.5);
        let (y_low, y_high) = bounds(all.iter().map(|p| p.1), if self.logarithmic { 0.15 } else { 0.1 });
        let x_at = |x: f64| LEFT + (x - x_low) / (x_high - x_low) * (SIZE[0] - LEFT - RIGHT);
        let y_at = |y: f64| SIZE[1] - BOTTOM - (y - y_low) / (y_high - y_low) * (SIZE[1] - TOP - BOTTOM);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" \
             fill=\"#282c34\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            SIZE[0], SIZE[1]
        );
        let (left, right, bottom) = (LEFT, SIZE[0] - RIGHT, SIZE[1] - BOTTOM);
        for (at, label) in self.ticks(y_low, y_high) {
            let y = y_at(at);
            // Writing to a string does not fail.
            let _ = writeln!(
                svg,
                "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#d6dae0\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                left - 6.0,
                y + 4.0
            );
        }
        for x in steps(x_low, x_high) {
            let at = x_at(x);
            let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{x}</text>", bottom + 16.0);
        }
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">frame</text>\
             <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            0.5 * (left + right),
            SIZE[1] - 8.0,
            0.5 * (TOP + bottom),
            self.title
        );
        for (i, m) in methods.iter().enumerate() {
            let color = m.method.color;
            let x = left + 128.0 * i as f64;
            let _ = writeln!(
                svg,
                "<circle cx=\"{x}\" cy=\"14\" r=\"4\" fill=\"{color}\"/><text x=\"{}\" y=\"18\">{}</text>",
                x + 9.0,
                m.method.name
            );
            let mut last: Option<u32> = None;
            let mut path = String::new();
            for (frame, (x, y)) in m.frames.iter().filter_map(|f| Some((f.number, shown(f)?))) {
                let (x, y) = (x_at(x), y_at(y));
                let follows = last.is_some_and(|last| last + 1 == frame);
                let _ = write!(path, "{}{x:.1} {y:.1}", if follows { 'L' } else { 'M' });
                let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\" fill=\"{color}\"/>");
                last = Some(frame);
            }
            let _ = writeln!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.6\"/>");
        }
        svg + "</svg>\n"
    }

    fn level(&self, y: f64) -> f64 {
        if self.logarithmic { y.log10() } else { y }
    }

    /// Where the vertical axis has lines, and what they are called.
    fn ticks(&self, low: f64, high: f64) -> Vec<(f64, String)> {
        if !self.logarithmic {
            return steps(low, high)
                .map(|y| (y, format!("{:.4}", y).trim_end_matches('0').trim_end_matches('.').to_owned()))
                .collect();
        }
        let powers = low.floor() as i32..=high.ceil() as i32;
        let all = powers.flat_map(|p| [1.0, 2.0, 5.0].map(|d: f64| d * 10f64.powi(p)));
        all.map(|y| (y.log10(), format!("{y:.8}")))
            .filter(|(at, _)| (low..=high).contains(at))
            .map(|(at, label)| (at, label.trim_end_matches('0').trim_end_matches('.').to_owned()))
            .collect()
    }
}

/// The range of values with a margin, of some size at least.
fn bounds(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
    let margin = margin.max(0.05 * (high - low));
    (low - margin, high + margin)
}

/// About six round numbers within a range.
fn steps(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let raw = (high - low) / 6.0;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|d| d * power).find(|s| *s >= raw).unwrap_or(raw);
    let first = (low / step).ceil() as i64;
    (first..first + 12).map(move |k| k as f64 * step).take_while(move |x| *x <= high)
}
