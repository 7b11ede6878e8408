//! One polar panel: radius is F, angle is the zenith angle of wo, light comes from the left.

use super::Cut;
use brdf_tables::errors::Errors;
use core::f64::consts::FRAC_PI_2;
use kit::figure::{Canvas, INK, PALE, PALETTE, at, failed, px, stroke, text};
use kit::text::{multiple, percent};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Size of a panel, px.
pub const WIDTH: f64 = 460.0;
/// As [`WIDTH`].
pub const HEIGHT: f64 = 322.0;
/// Radius of the largest ring, px.
const RADIUS: f64 = 190.0;

const EXACT: RGBColor = PALETTE[0];
const TABLE: RGBColor = RGBColor(0, 110, 70);
const CAP: RGBColor = PALETTE[4];

/// Centre of the half disc of a panel whose corner is at `left`, `top`, and polar coordinates about it.
struct Polar {
    x: f64,
    y: f64,
}

impl Polar {
    fn at(&self, angle: f64, radius: f64) -> (i32, i32) {
        at(self.x + radius * angle.sin(), self.y - radius * angle.cos())
    }

    fn arc(&self, from: f64, to: f64, radius: f64) -> Vec<(i32, i32)> {
        (0..=90).map(|i| self.at(from + (to - from) * f64::from(i) / 90.0, radius)).collect()
    }
}

/// Draws a cut with its upper left corner at a place of the canvas.
pub fn draw(canvas: &Canvas, (left, top): (f64, f64), cut: &Cut) -> anyhow::Result<()> {
    let polar = Polar { x: left + 0.5 * WIDTH, y: top + 24.0 + RADIUS };
    let line =
        |points: Vec<(i32, i32)>, style: ShapeStyle| canvas.draw(&PathElement::new(points, style)).map_err(failed);
    let label = |words: String, place: (i32, i32), size: f64| {
        canvas.draw(&Text::new(words, place, text(size, &INK, HPos::Center))).map_err(failed)
    };

    // The cap, on the side the light comes from, and the mirror direction of its axis.
    let (theta, sigma) = (cut.cap.theta(), cut.cap.half_angle());
    let mut wedge = polar.arc(-(theta + sigma).min(FRAC_PI_2), (sigma - theta).min(FRAC_PI_2), RADIUS);
    wedge.push(polar.at(0.0, 0.0));
    canvas.draw(&Polygon::new(wedge, CAP.mix(0.25).filled())).map_err(failed)?;
    line(vec![polar.at(-theta, RADIUS), polar.at(-theta, 0.0)], stroke(CAP, 1.4))?;
    line(vec![polar.at(theta, RADIUS), polar.at(theta, 0.0)], stroke(CAP.mix(0.6), 1.0))?;
    let tip = |side: f64| polar.at(-theta + side, 12.0 / side.cos());
    canvas.draw(&Polygon::new(vec![polar.at(0.0, 0.0), tip(0.35), tip(-0.35)], CAP.filled())).map_err(failed)?;

    // Rings at round values of F, spokes every 30°.
    let peak = cut.samples.iter().fold(f64::MIN_POSITIVE, |m, s| m.max(s.1).max(s.2));
    let step = round_step(peak / 3.5);
    let unit = RADIUS / (1.1 * peak);
    for ring in 1..=(1.1 * peak / step) as u32 {
        let value = f64::from(ring) * step;
        line(polar.arc(-FRAC_PI_2, FRAC_PI_2, unit * value), stroke(PALE, 0.8))?;
        for side in [-1.0, 1.0] {
            label(multiple(value, step), at(polar.x + side * unit * value, polar.y + 11.0), 10.5)?;
        }
    }
    label("F, sr⁻¹".into(), at(polar.x, polar.y + 11.0), 10.5)?;
    for degrees in [-60i32, -30, 0, 30, 60] {
        let angle = f64::from(degrees).to_radians();
        line(vec![polar.at(angle, 0.0), polar.at(angle, RADIUS)], stroke(PALE, 0.8))?;
        label(format!("{}°", degrees.abs()), polar.at(angle, RADIUS + 12.0), 10.5)?;
    }
    line(vec![polar.at(-FRAC_PI_2, RADIUS + 8.0), polar.at(FRAC_PI_2, RADIUS + 8.0)], stroke(INK, 1.2))?;

    // The truth as a broad band, the table as a fine line upon it.
    let curve = |of: fn(&(f64, f64, f64)) -> f64| cut.samples.iter().map(|s| polar.at(s.0, unit * of(s))).collect();
    line(curve(|s| s.1), stroke(EXACT.mix(0.45), 5.0))?;
    line(curve(|s| s.2), stroke(TABLE, 1.4))?;

    // What is shown, and how good it is.
    label(cut.caption.clone(), at(polar.x, polar.y + 36.0), 13.0)?;
    let errors: Vec<_> = Errors::NAMES
        .iter()
        .zip(cut.errors.to_array())
        .map(|(n, e)| format!("{n} {} %", percent(f64::from(e))))
        .collect();
    label(errors[..3].join(" · "), at(polar.x, polar.y + 58.0), 12.0)?;
    Ok(label(errors[3..].join(" · "), at(polar.x, polar.y + 76.0), 12.0)?)
}

/// What the colours mean, across a figure of `width` px.
pub fn legend(canvas: &Canvas, width: f64) -> anyhow::Result<()> {
    let entries: [(&str, ShapeStyle); 4] = [
        ("exact quadrature", stroke(EXACT.mix(0.45), 5.0)),
        ("table", stroke(TABLE, 1.4)),
        ("cap, light arrives", CAP.mix(0.35).filled()),
        ("mirror direction", stroke(CAP.mix(0.6), 1.0)),
    ];
    let widths = [156.0, 84.0, 156.0, 140.0];
    let mut x = 0.5 * (width - widths.iter().sum::<f64>());
    for ((name, style), advance) in entries.into_iter().zip(widths) {
        let (a, b) = (at(x, 24.0), at(x + 26.0, 24.0));
        if style.filled {
            canvas.draw(&Rectangle::new([(a.0, a.1 - px(6.0)), (b.0, b.1 + px(6.0))], style)).map_err(failed)?;
        } else {
            canvas.draw(&PathElement::new(vec![a, b], style)).map_err(failed)?;
        }
        canvas.draw(&Text::new(name, at(x + 33.0, 24.0), text(12.5, &INK, HPos::Left))).map_err(failed)?;
        x += advance;
    }
    Ok(())
}

/// 1, 2 or 5 times a power of ten, at least `x`.
fn round_step(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= x * (1.0 - 1e-9)).unwrap_or(x)
}
