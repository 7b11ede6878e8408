//! Curves over two logarithmic axes, as SVG.

use fitter::figure::{Canvas, DrawError, INK, PALE, at, axes, failed, px, stroke, svg, text};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Size of a figure, px.
const SIZE: (f64, f64) = (600.0, 400.0);
/// Height of a line of the legend, px.
const LINE: f64 = 20.0;

/// One method.
pub struct Series {
    /// In the legend.
    pub name: String,
    /// Of line and markers.
    pub color: RGBColor,
    /// In the order in which the line joins them; both coordinates > 0.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are one sweep, which a line joins.
    pub joined: bool,
}

/// What the axes say.
pub struct Axes {
    /// Below.
    pub x: &'static str,
    /// On the left.
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

/// The label of a tick: only 1, 2 and 5 times a power of ten have room for one.
fn tick(x: &f64) -> String {
    let digit = x / 10f64.powf(x.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].iter().any(|d| (digit - d).abs() < 1e-6);
    if round { plain(x) } else { String::new() }
}

/// Draws the curves.
///
/// # Errors
/// A drawing that fails.
pub fn plot(axes: &Axes, series: &[Series]) -> Result<String, DrawError> {
    let all = || series.iter().flat_map(|s| &s.points);
    let ordinates = all().map(|p| p.1).chain(axes.floor.map(|f| f.0));
    let (x_range, y_range) = (axes::range(all().map(|p| p.0)), axes::range(ordinates));
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
            .build_cartesian_2d(x_range.clone().log_scale(), y_range.log_scale())
            .map_err(failed)?;
        plot.configure_mesh()
            .x_desc(axes.x)
            .y_desc(axes.y)
            .axis_desc_style(text(12.0, &INK, HPos::Center))
            .x_label_style(text(11.0, &INK, HPos::Center))
            .y_label_style(text(11.0, &INK, HPos::Right))
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .bold_line_style(stroke(PALE, 1.0))
            .light_line_style(stroke(PALE.mix(0.4), 0.6))
            .axis_style(stroke(INK, 1.0))
            .set_all_tick_mark_size(px(4.0))
            .draw()
            .map_err(failed)?;
        if let Some((y, name)) = axes.floor {
            let grey = stroke(INK.mix(0.5), 1.2);
            plot.draw_series(DashedLineSeries::new(
                [x_range.start, x_range.end].map(|x| (x, y)),
                px(5.0) as u32,
                px(4.0) as u32,
                grey,
            ))
            .map_err(failed)?;
            let (left, line) = plot.backend_coord(&(x_range.start, y));
            let corner = area.get_base_pixel();
            let place = (left - corner.0 + px(6.0), line - corner.1 - px(8.0));
            area.draw(&Text::new(name, place, text(10.5, &INK, HPos::Left))).map_err(failed)?;
        }
        for s in series {
            if s.joined {
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
    if s.joined {
        canvas.draw(&PathElement::new(vec![at(x, y), at(x + 22.0, y)], stroke(s.color, 1.8))).map_err(failed)?;
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
        assert_eq!([0.02, 5000.0, 0.03, 1e-4].map(|x| tick(&x)), ["0.02", "5000", "", "0.0001"]);
    }

    #[test]
    fn a_figure_holds_every_curve() {
        let series =
            |name: &str| Series { name: name.into(), color: INK, points: vec![(1.0, 0.1), (10.0, 0.01)], joined: true };
        let axes = Axes { x: "seconds", y: "error", floor: Some((0.001, "noise")) };
        let svg = plot(&axes, &[series("one"), series("two")]).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
        for word in ["one", "two", "seconds", "error", "noise"] {
            assert!(svg.contains(word), "{word}");
        }
    }
}
