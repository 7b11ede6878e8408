//! The figure of a chart: a row per material, error against time on the left, against bytes on the right.

use super::{Chart, Curve, Point, axes};
use kit::figure::{Canvas, INK, PALE, PALETTE, at, failed, px, stroke, svg, text};
use kit::text::shortened;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Size of a panel, px.
const PANEL: (f64, f64) = (640.0, 440.0);
/// Space right of the panels for the legend, px.
const LEGEND: f64 = 170.0;
/// Space above a row for its title, px.
const TITLE: f64 = 36.0;
/// Errors below this are drawn here: the reference itself is about as good.
const FLOOR: f64 = 1e-6;
/// Height of a point's label, px.
const LABEL: f64 = 9.5;

/// Draws all charts.
pub fn figure(charts: &[Chart]) -> anyhow::Result<String> {
    let mut names: Vec<&str> = Vec::new();
    for curve in charts.iter().flat_map(|chart| &chart.curves) {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }
    let color = |curve: &Curve| color(&names, curve);
    let size = (2.0 * PANEL.0 + LEGEND, charts.len() as f64 * (PANEL.1 + TITLE) + 8.0);
    svg(size, |canvas| {
        for (i, chart) in charts.iter().enumerate() {
            let top = i as f64 * (PANEL.1 + TITLE);
            let title =
                Text::new(shortened(&chart.material, 150), at(PANEL.0, top + 22.0), text(14.5, &INK, HPos::Center));
            canvas.draw(&title).map_err(failed)?;
            let area = |left: f64| canvas.clone().shrink(at(left, top + TITLE), (px(PANEL.0), px(PANEL.1)));
            let time = |point: &Point| Some(point.nanoseconds);
            let bytes = |point: &Point| point.bytes.map(|bytes| bytes as f64);
            panel(
                &area(0.0),
                chart,
                &color,
                &time,
                axes::time,
                "time per evaluation: batched, one thread, preparation included",
            )?;
            panel(&area(PANEL.0), chart, &color, &bytes, axes::bytes, "size of the representation")?;
            legend(canvas, (2.0 * PANEL.0, top + TITLE), &chart.curves, &color)?;
        }
        Ok(())
    })
}

/// A colour per method, the same in every row: by the order in which the methods first appear.
fn color(names: &[&str], curve: &Curve) -> RGBColor {
    let index = names.iter().position(|name| *name == curve.name).unwrap_or(0);
    PALETTE[index % PALETTE.len()]
}

/// One pair of axes with all curves that have an abscissa.
fn panel(
    area: &DrawingArea<SVGBackend, Shift>,
    chart: &Chart,
    color: &dyn Fn(&Curve) -> RGBColor,
    abscissa: &dyn Fn(&Point) -> Option<f64>,
    format: fn(&f64) -> String,
    name: &str,
) -> anyhow::Result<()> {
    let points = || chart.curves.iter().flat_map(|curve| &curve.points);
    let ordinates = |point: &Point| [point.errors.p95, point.errors.median].map(|e| f64::from(e.rmse_lobe).max(FLOOR));
    let mut plot = ChartBuilder::on(area)
        .margin(px(8.0))
        .x_label_area_size(px(44.0))
        .y_label_area_size(px(92.0))
        .build_cartesian_2d(
            axes::range(points().filter_map(abscissa)).log_scale(),
            axes::range(points().flat_map(ordinates)).log_scale(),
        )
        .map_err(failed)?;
    plot.configure_mesh()
        .x_desc(name)
        .y_desc("rmse_lobe: marker 95th percentile, stem to the median")
        .axis_desc_style(text(12.0, &INK, HPos::Center))
        .x_label_style(text(11.0, &INK, HPos::Center))
        .y_label_style(text(11.0, &INK, HPos::Right))
        .x_label_formatter(&format)
        .y_label_formatter(&|y| format!("{}{}", if *y <= FLOOR { "≤ " } else { "" }, axes::percentage(y)))
        .bold_line_style(stroke(PALE, 1.0))
        .light_line_style(stroke(PALE.mix(0.4), 0.6))
        .axis_style(stroke(INK, 1.0))
        .set_all_tick_mark_size(px(4.0))
        .draw()
        .map_err(failed)?;

    let mut labels = Labels::default();
    let mut texts = Vec::new();
    for curve in &chart.curves {
        let color = color(curve);
        let shown: Vec<_> = curve.points.iter().filter_map(|p| Some((abscissa(p)?, ordinates(p), &p.label))).collect();
        let line = shown.iter().map(|(x, [p95, _], _)| (*x, *p95));
        plot.draw_series(LineSeries::new(line, stroke(color, 1.6))).map_err(failed)?;
        for (x, [p95, median], label) in shown {
            let stem = PathElement::new(vec![(x, p95), (x, median)], stroke(color.mix(0.55), 1.0));
            plot.draw_series([stem]).map_err(failed)?;
            plot.draw_series([Circle::new((x, p95), px(3.2), color.filled())]).map_err(failed)?;
            let place = plot.backend_coord(&(x, p95));
            labels.block(place);
            texts.push((place, label, color));
        }
    }
    // Labels last, each where it covers no marker and no other label.
    let corner = area.get_base_pixel();
    for (place, label, color) in texts {
        if let Some((x, y)) = labels.place(place, label.chars().count()) {
            let style = text(LABEL, &color, HPos::Left);
            area.draw(&Text::new(label.as_str(), (x - corner.0, y - corner.1), style)).map_err(failed)?;
        }
    }
    Ok(())
}

/// Rectangles taken by markers and labels, canvas units.
#[derive(Default)]
struct Labels(Vec<[i32; 4]>);

impl Labels {
    /// Takes the place of a marker.
    fn block(&mut self, (x, y): (i32, i32)) {
        let r = px(3.2);
        self.0.push([x - r, y - r, x + r, y + r]);
    }

    /// The left end of a label's middle line near a marker, if there is room.
    fn place(&mut self, (x, y): (i32, i32), characters: usize) -> Option<(i32, i32)> {
        let (width, half, gap) = (px(0.56 * LABEL * characters as f64), px(0.5 * LABEL), px(5.0));
        let candidates = [
            (x + gap, y - half),
            (x + gap, y + half),
            (x + gap, y),
            (x - gap - width, y - half),
            (x - gap - width, y + half),
            (x - width / 2, y - gap - half),
            (x - width / 2, y + gap + half),
            (x - gap - width, y),
        ];
        let rectangle = |(x, y): (i32, i32)| [x, y - half, x + width, y + half];
        let free = |r: &[i32; 4]| self.0.iter().all(|o| r[2] <= o[0] || o[2] <= r[0] || r[3] <= o[1] || o[3] <= r[1]);
        let found = candidates.into_iter().find(|c| free(&rectangle(*c)))?;
        self.0.push(rectangle(found));
        Some(found)
    }
}

/// The names of the curves, one below the other.
fn legend(
    canvas: &Canvas,
    (left, top): (f64, f64),
    curves: &[Curve],
    color: &dyn Fn(&Curve) -> RGBColor,
) -> anyhow::Result<()> {
    for (i, curve) in curves.iter().enumerate() {
        let color = color(curve);
        let y = top + 24.0 + 22.0 * i as f64;
        let line = PathElement::new(vec![at(left + 8.0, y), at(left + 34.0, y)], stroke(color, 1.6));
        canvas.draw(&line).map_err(failed)?;
        canvas.draw(&Circle::new(at(left + 21.0, y), px(3.2), color.filled())).map_err(failed)?;
        canvas
            .draw(&Text::new(curve.name.as_str(), at(left + 42.0, y), text(12.0, &INK, HPos::Left)))
            .map_err(failed)?;
    }
    Ok(())
}
