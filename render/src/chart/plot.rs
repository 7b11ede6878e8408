//! Curves over two logarithmic axes, as SVG.

use core::ops::Range;
use kit::figure::{Canvas, DrawError, INK, PALE, at, failed, px, stroke, svg, text};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Size of a figure, px.
const SIZE: (f64, f64) = (600.0, 400.0);
/// Length of a dash and of the gap after it, px.
const DASH: (f64, f64) = (5.0, 4.0);
/// Height of a line of the legend, px.
const LINE: f64 = 20.0;

/// One method.
pub struct Series {
    /// Name of the curve in the legend.
    pub name: String,
    /// Colour of its line and markers.
    pub color: RGBColor,
    /// In the order in which the line joins them; both coordinates > 0.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are one sweep, which a line joins.
    pub joined: bool,
    /// Whether that line is dashed.
    pub dashed: bool,
}

/// What the axes say.
pub struct Axes {
    /// Title of the horizontal axis.
    pub x: &'static str,
    /// Title of the vertical axis.
    pub y: &'static str,
    /// A level that no point can be told from, with its name.
    pub floor: Option<(f64, &'static str)>,
}

/// A number as short as its first three digits.
pub fn plain(x: &f64) -> String {
    let unit = 10f64.powf((x.abs().max(1e-30)).log10().floor() - 2.0);
    let decimals = (-unit.log10().round()).clamp(0.0, 12.0) as usize;
    let text = format!("{:.decimals$}", (x / unit).round() * unit);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Where an axis has lines: 1, 2 and 5 times powers of ten, over short axes 3 and 7 times too, over long ones only powers.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let digits: &[f64] = match (range.end / range.start).log10() {
        decades if decades < 1.3 => &[1.0, 2.0, 3.0, 5.0, 7.0],
        decades if decades < 3.5 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let powers = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let all = powers.flat_map(|p| digits.iter().map(move |d| d * 10f64.powi(p)));
    all.filter(|x| range.contains(x)).collect()
}

/// The values with a margin, over half a decade at least.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0f64), |(low, high), x| (low.min(x), high.max(x)));
    let (low, high) = if low > high { (1.0, 1.0) } else { (low / 1.25, 1.25 * high) };
    let more = (3.0 * low / high).max(1.0).sqrt();
    low / more..high * more
}

/// Draws the curves.
///
/// # Errors
/// A drawing that fails.
pub fn plot(axes: &Axes, series: &[Series]) -> Result<String, DrawError> {
    let all = || series.iter().flat_map(|s| &s.points);
    let ordinates = all().map(|p| p.1).chain(axes.floor.map(|f| f.0));
    let (x_range, y_range) = (range(all().map(|p| p.0)), range(ordinates));
    let places = places(series);
    let legend = places.last().map_or(0.0, |p| p.1 + 0.5 * LINE) + 4.0;
    svg((SIZE.0, SIZE.1 + legend), |canvas| {
        for (s, place) in series.iter().zip(&places) {
            entry(canvas, s, *place)?;
        }
        let area = canvas.clone().shrink(at(0.0, legend), (px(SIZE.0), px(SIZE.1)));
        let mut plot = ChartBuilder::on(&area)
            .margin(px(8.0))
            .margin_right(px(20.0))
            .x_label_area_size(px(44.0))
            .y_label_area_size(px(76.0))
            .build_cartesian_2d(x_range.clone().log_scale(), y_range.clone().log_scale())
            .map_err(failed)?;
        plot.configure_mesh()
            .disable_mesh()
            .x_desc(axes.x)
            .y_desc(axes.y)
            .axis_desc_style(text(12.0, &INK, HPos::Center))
            .x_labels(0)
            .y_labels(0)
            .axis_style(stroke(INK, 1.0))
            .draw()
            .map_err(failed)?;
        // plotters draws lines and labels of a power of ten several times: ours are drawn once.
        let corner = area.get_base_pixel();
        let (x_ticks, y_ticks) = (ticks(&x_range), ticks(&y_range));
        let lines = (x_ticks.iter().map(|x| [(*x, y_range.start), (*x, y_range.end)]))
            .chain(y_ticks.iter().map(|y| [(x_range.start, *y), (x_range.end, *y)]));
        plot.draw_series(lines.map(|l| PathElement::new(l, stroke(PALE, 0.8)))).map_err(failed)?;
        let labels = (x_ticks.iter().map(|x| (*x, (*x, y_range.start), (0.0, 13.0), HPos::Center)))
            .chain(y_ticks.iter().map(|y| (*y, (x_range.start, *y), (-7.0, 0.0), HPos::Right)));
        for (value, place, (right, down), side) in labels {
            let (x, y) = plot.backend_coord(&place);
            let place = (x - corner.0 + px(right), y - corner.1 + px(down));
            area.draw(&Text::new(plain(&value), place, text(11.0, &INK, side))).map_err(failed)?;
        }
        if let Some((y, name)) = axes.floor {
            let line = [x_range.start, x_range.end].map(|x| (x, y));
            let (dash, gap) = (px(DASH.0) as u32, px(DASH.1) as u32);
            plot.draw_series(DashedLineSeries::new(line, dash, gap, stroke(INK.mix(0.5), 1.2))).map_err(failed)?;
            let (left, height) = plot.backend_coord(&(x_range.start, y));
            let place = (left - corner.0 + px(6.0), height - corner.1 - px(8.0));
            area.draw(&Text::new(name, place, text(10.5, &INK, HPos::Left))).map_err(failed)?;
        }
        for s in series {
            if s.joined && s.dashed {
                let (dash, gap) = (px(DASH.0) as u32, px(DASH.1) as u32);
                let points = s.points.iter().copied();
                plot.draw_series(DashedLineSeries::new(points, dash, gap, stroke(s.color, 1.8))).map_err(failed)?;
            } else if s.joined {
                plot.draw_series(LineSeries::new(s.points.iter().copied(), stroke(s.color, 1.8))).map_err(failed)?;
            }
            plot.draw_series(s.points.iter().map(|p| Circle::new(*p, px(3.4), s.color.filled()))).map_err(failed)?;
        }
        Ok(())
    })
}

/// Left ends of the legend's entries, which run on in lines above the figure.
fn places(series: &[Series]) -> Vec<(f64, f64)> {
    let (mut x, mut y) = (84.0, 14.0);
    let mut places = Vec::new();
    for s in series {
        let width = 48.0 + 6.8 * s.name.chars().count() as f64;
        if x + width > SIZE.0 && x > 84.0 {
            (x, y) = (84.0, y + LINE);
        }
        places.push((x, y));
        x += width;
    }
    places
}

/// A line of the legend.
fn entry(canvas: &Canvas, s: &Series, (x, y): (f64, f64)) -> Result<(), DrawError> {
    // A dashed line has a gap on both sides of its marker.
    let parts: &[(f64, f64)] = if s.dashed { &[(0.0, 5.0), (17.0, 22.0)] } else { &[(0.0, 22.0)] };
    for (from, to) in parts.iter().filter(|_| s.joined) {
        canvas.draw(&PathElement::new(vec![at(x + from, y), at(x + to, y)], stroke(s.color, 1.8))).map_err(failed)?;
    }
    canvas.draw(&Circle::new(at(x + 11.0, y), px(3.4), s.color.filled())).map_err(failed)?;
    canvas.draw(&Text::new(s.name.as_str(), at(x + 29.0, y), text(12.0, &INK, HPos::Left))).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let plain = [0.5, 1.0, 0.00012, 123456.0, 0.0299999, 1000.0].map(|x| plain(&x));
        assert_eq!(plain, ["0.5", "1", "0.00012", "123000", "0.03", "1000"]);
    }

    #[test]
    fn axes_reach_over_all_and_have_few_lines() {
        let narrow = range([2.0, 2.1].into_iter());
        assert!(narrow.contains(&2.0) && narrow.contains(&2.1) && narrow.end / narrow.start > 2.9, "{narrow:?}");
        assert!(range([].into_iter()).contains(&1.0));
        assert_eq!(ticks(&(0.9..11.0)), [1.0, 2.0, 3.0, 5.0, 7.0, 10.0]);
        assert_eq!(ticks(&(0.9..60.0)), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]);
        assert_eq!(ticks(&(0.9..11_000.0)).len(), 5);
    }

    #[test]
    fn a_figure_holds_every_curve() {
        let series = |name: &str| Series {
            name: name.into(),
            color: INK,
            points: vec![(1.0, 0.1), (10.0, 0.01)],
            joined: true,
            dashed: name == "two",
        };
        let axes = Axes { x: "seconds", y: "error", floor: Some((0.001, "noise")) };
        let svg = plot(&axes, &[series("one"), series("two")]).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
        for word in ["one", "two", "seconds", "error", "noise"] {
            assert!(svg.contains(word), "{word}");
        }
    }
}
