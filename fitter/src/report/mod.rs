//! The page of `fitter report`: one file with its figures and pictures in it.

mod sphere;
mod svg;

use brdf_tables::errors::Errors;
use brdf_tables::material::Material;
use brdf_tables::measured::Source;
use fitter::explain::{Candidate, Symmetry, cut};
use fitter::measured::VIEWS;
use kit::text::percent;
use std::fmt::Write;
use svg::{Axes, COLORS, Line, chart};

/// Angles of the light in the cuts, degrees.
const CUTS: [f64; 3] = [15.0, 45.0, 70.0];
/// Candidates that have a picture.
const PICTURES: usize = 4;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;color:#282c34;max-width:1000px;margin:24px auto;padding:0 16px}\
h1{font-size:24px}h2{font-size:18px;margin:28px 0 8px}table{border-collapse:collapse;font-size:14px}\
th,td{padding:4px 10px;text-align:right;border-bottom:1px solid #d6dae0}th:first-child,td:first-child{text-align:left}\
td{white-space:nowrap}th:last-child{text-align:left}td.recipe{white-space:pre-line;text-align:left;font:12px ui-monospace,monospace}figure{display:inline-block;margin:0 12px 12px 0;vertical-align:top}\
figcaption{font-size:13px;max-width:460px}.grid{stroke:#e4e7eb}.mark{stroke:#a01028;stroke-dasharray:4 3}\
.line{fill:none;stroke-width:1.6}svg text{font-size:11px;fill:#282c34}.x{text-anchor:middle}.y{text-anchor:end}\
.key{display:inline-block;width:22px;height:3px;vertical-align:middle;margin-right:5px}.bad{color:#a01028;font-weight:600}\
li{margin:2px 0}";

/// What a page is made of.
pub struct Page<'a> {
    /// Name of the file.
    pub title: &'a str,
    /// Lines about the data.
    pub notes: &'a [String],
    /// The data as the file has them.
    pub data: &'a dyn Source,
    /// The data as they are kept, first, and models, the best first.
    pub candidates: &'a [Candidate],
    /// How symmetric the data are.
    pub symmetry: Symmetry,
}

/// The page.
///
/// # Errors
/// A picture cannot be encoded.
pub fn page(page: &Page) -> anyhow::Result<String> {
    let Page { title, notes, data, candidates, symmetry } = page;
    let title = escape(title);
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
        <title>{title}</title><style>{STYLE}</style><h1>{title}</h1>"
    );
    let _ = write!(html, "<p>{}</p><ul>", verdict(candidates));
    for note in notes.iter() {
        let class = if note.starts_with("ENERGY") { " class=\"bad\"" } else { "" };
        let _ = write!(html, "<li{class}>{}</li>", escape(note));
    }
    for (what, [median, p95]) in [("exchanged directions", symmetry.exchanged), ("mirror images", symmetry.mirrored)] {
        let class = if p95 > 0.05 { " class=\"bad\"" } else { "" };
        let verdict = if p95 > 0.05 { "; a table holds their mean" } else { "" };
        let _ = write!(
            html,
            "<li{class}>{what} differ by {} % in the median, {} % at the 95th percentile{verdict}</li>",
            percent(median),
            percent(p95)
        );
    }
    html.push_str("</ul><h2>Spheres</h2>");
    for candidate in candidates.iter().take(PICTURES) {
        let address = sphere::address(&sphere::sphere(&candidate.material))?;
        let _ = write!(
            html,
            "<figure><img src=\"{address}\" width=\"200\" height=\"200\" alt=\"sphere\"><figcaption>{}</figcaption></figure>",
            candidate.name
        );
    }
    html.push_str("<h2>Models</h2>");
    html.push_str(&models(candidates));
    html.push_str(
        "<h2>Errors of the mean BRDF</h2><p>Grey, over nine caps of three radii and three angles, against the data as \
        they are kept: median and 95th percentile, percent.</p>",
    );
    html.push_str(&five_errors(candidates));
    html.push_str(
        "<h2>Along the plane of incidence</h2><p>f_r in sr⁻¹, grey, for light at three angles; the mirror direction is \
        at the angle of the light. ",
    );
    html.push_str(&key(candidates));
    html.push_str("</p>");
    for degrees in CUTS {
        let mut lines = vec![Line { color: COLORS[0], points: cut(|wi, wo| data.rgb(wi, wo), degrees) }];
        for (candidate, color) in candidates.iter().skip(1).take(PICTURES - 1).zip(&COLORS[1..]) {
            let material: Material = candidate.material;
            lines.push(Line { color, points: cut(|wi, wo| Some(material.eval(wi, wo)), degrees) });
        }
        let axes = Axes { x: "angle of the view, degrees", y: "f_r, sr⁻¹", logarithmic: true, mark: None };
        let _ = write!(html, "<figure>{}<figcaption>light at {degrees}°</figcaption></figure>", chart(&axes, &lines));
    }
    html.push_str("<h2>By the angle of the view</h2>");
    let lines = |of: &dyn Fn(&Candidate, usize) -> f64| -> Vec<Line> {
        let line = |(candidate, color): (&Candidate, &&'static str)| Line {
            color,
            points: VIEWS.into_iter().enumerate().map(|(k, degrees)| (degrees, of(candidate, k))).collect(),
        };
        candidates.iter().zip(&COLORS).take(PICTURES).map(line).collect()
    };
    let axes = Axes { x: "angle of the view, degrees", y: "albedo", logarithmic: false, mark: Some(1.0) };
    let grey = |c: &Candidate, k: usize| c.albedo[k].iter().sum::<f64>() / 3.0;
    let _ = write!(
        html,
        "<figure>{}<figcaption>Energy: light reflected under a white sky; above the dashed line more than arrives.\
        </figcaption></figure>",
        chart(&axes, &lines(&grey))
    );
    let axes = Axes { x: "angle of the view, degrees", y: "relative error, percent", logarithmic: false, mark: None };
    let error = |c: &Candidate, k: usize| 100.0 * c.by_view[k];
    let _ = writeln!(
        html,
        "<figure>{}<figcaption>Root mean square of relative errors of f_r.</figcaption></figure></html>",
        chart(&axes, &lines(&error))
    );
    Ok(html)
}

fn verdict(candidates: &[Candidate]) -> String {
    let Some(best) = candidates.get(1) else { return String::new() };
    let how = match best.relative {
        x if x < 0.05 => "explains the data: its formula will do",
        x if x < 0.2 => "is near: good where highlights are not looked at closely",
        _ => "is the nearest, and far off: keep the data",
    };
    format!("<b>{}</b> {how} ({} % in the root mean square of relative errors).", best.name, percent(best.relative))
}

fn key(candidates: &[Candidate]) -> String {
    let entry = |(candidate, color): (&Candidate, &&str)| {
        format!("<span class=\"key\" style=\"background:{color}\"></span>{} &nbsp; ", candidate.name)
    };
    candidates.iter().zip(&COLORS).take(PICTURES).map(entry).collect()
}

fn models(candidates: &[Candidate]) -> String {
    let mut html = String::from("<table><tr><th>model<th>relative error, %<th>albedo at 0°<th>at 60°<th>recipe");
    for candidate in candidates {
        let shown = |k: usize| candidate.albedo[k].map(|x| format!("{x:.3}")).join(" ");
        let brightest = candidate.albedo.iter().flatten().fold(0.0f64, |m, x| m.max(*x));
        let class = if brightest > 1.005 { " class=\"bad\"" } else { "" };
        let _ = write!(
            html,
            "<tr><td>{}<td>{}<td{class}>{}<td{class}>{}<td class=\"recipe\">{}",
            candidate.name,
            percent(candidate.relative),
            shown(0),
            shown(4),
            escape(&recipe(&candidate.recipe))
        );
    }
    html + "</table>"
}

/// The recipe with as many digits as matter, that `fitter fit` takes. Lines of a file have no more.
fn recipe(full: &str) -> String {
    const ENDS: [char; 7] = [',', ':', '=', '[', ']', ' ', '\n'];
    if full.starts_with('#') {
        return full.into();
    }
    let mut text = String::new();
    for part in full.split_inclusive(ENDS) {
        let (number, end) = part.split_at(part.trim_end_matches(ENDS).len());
        match number.parse::<f64>() {
            Ok(x) if number.len() > 6 && number.contains('.') => {
                let _ = write!(text, "{}{end}", (x * 1e4).round() / 1e4);
            }
            _ => text.push_str(part),
        }
    }
    text
}

fn five_errors(candidates: &[Candidate]) -> String {
    let mut html = String::from("<table><tr><th>model");
    Errors::NAMES.iter().for_each(|name| {
        let _ = write!(html, "<th>{name}");
    });
    for candidate in candidates {
        let _ = write!(html, "<tr><td>{}", candidate.name);
        let (median, p95) = (candidate.errors.median.to_array(), candidate.errors.p95.to_array());
        for (median, p95) in median.into_iter().zip(p95) {
            let _ = write!(html, "<td>{} · {}", percent(f64::from(median)), percent(f64::from(p95)));
        }
    }
    html + "</table>"
}

/// Text of others within a page.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_the_page() {
        assert_eq!(escape("<a \"b\"&>"), "&lt;a &quot;b&quot;&amp;&gt;");
        let material = Material::lambert([1.0 / 3.0; 3]);
        assert_eq!(recipe(&material.recipe_text()), "lambert:reflectance=0.3333");
    }
}
