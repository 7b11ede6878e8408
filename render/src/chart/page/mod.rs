//! The page a person reads: one HTML file that needs no other.

mod crops;
pub(crate) mod html;
mod orders;
mod reach;
mod sentences;
mod stability;
mod table1;

use super::figures::{figures, is_budget, methods};
use super::machine::machine;
use super::method;
use super::plot::plain;
use super::row::Row;
use super::subject::Subject;
use super::{Results, cell};
use anyhow::{Context, Result};
use crops::Shown;
use html::{escape, picture, table};
use render::image::{write_png, write_whole};
use sentences::sentences;
use std::fmt::Write;
use std::path::Path;

/// Writes the figures and the page.
///
/// # Errors
/// A drawing that fails, a file that cannot be read or written.
pub fn write(results: &Results) -> Result<()> {
    let plan = results.plan;
    let folder = plan.output.join("figures");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let mut body = header(results);
    if plan.stability {
        body += &stability::section(results);
    }
    for subject in &results.subjects {
        body += &scene(results, subject, &folder)?;
    }
    if let Some(section) = table1::section(results) {
        body += &section;
    }
    if let Some(section) = orders::section(results, &folder)? {
        body += &section;
    }
    body += &runs(results);
    body += MEASURES;
    let title = if plan.stability { "Burnish: where methods fail" } else { "Burnish: speed against accuracy" };
    write_whole(&plan.output.join("index.html"), html::page(title, &body).as_bytes())?;
    Ok(())
}

/// What was run, and on what.
fn header(results: &Results) -> String {
    let plan = results.plan;
    let used = results.subjects.iter().flat_map(|s| results.of(s));
    let mut text = format!(
        "<dl><dt>machine</dt><dd>{}; {} threads</dd>\n<dt>command</dt><dd><code>{}</code></dd>\n<dt>seed</dt><dd>{}</dd>\n\
         <dt>version</dt><dd>render {}</dd></dl>\n<h2>Methods</h2>\n<dl>\n",
        escape(&machine()),
        rayon::current_num_threads(),
        escape(&plan.command),
        plan.seed,
        env!("CARGO_PKG_VERSION"),
    );
    for name in methods(used) {
        let about = method::find(name).map_or("a peer, measured by its script", |m| m.about);
        let _ = writeln!(text, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(about));
    }
    text + "</dl>\n"
}

/// A scene: words, figures, pictures.
fn scene(results: &Results, subject: &Subject, folder: &Path) -> Result<String> {
    let rows: Vec<&Row> = results.of(subject).collect();
    let film = subject.world.scene.camera.film.window();
    let noise = match subject.reference_noise {
        Some(n) => format!("; the rel_mse of its own noise is {} and part of every error here", plain(&n)),
        None => "; its own noise is not known".into(),
    };
    let name = escape(&subject.name);
    let mut text = format!(
        "<h2 id=\"{name}\">{name}</h2>\n<p>{}×{} pixels{}. Reference: {}{noise}.</p>\n",
        film.width,
        film.height,
        if results.plan.indirect_only { ", light that is scattered twice or more" } else { "" },
        escape(&subject.reference_about)
    );
    if !results.plan.stability {
        let sentences = sentences(&rows);
        if !sentences.is_empty() {
            let items: String = sentences.iter().map(|s| format!("<li>{s}</li>\n")).collect();
            let _ = write!(text, "<h3>Which method wins, and by how much</h3>\n<ul>\n{items}</ul>\n");
        }
        text += "<div class=\"figures\">\n";
        for figure in figures(subject, rows.iter().copied())? {
            write_whole(&folder.join(format!("{}-{}.svg", subject.name, figure.name)), figure.svg.as_bytes())?;
            let caption = escape(figure.caption);
            let _ = writeln!(text, "<figure>{}<figcaption>{caption}</figcaption></figure>", figure.svg.trim());
        }
        text += "</div>\n";
    }
    Ok(text + &pictures(results, subject, &rows)?)
}

/// The pictures of all methods at about the same time, over their differences.
fn pictures(results: &Results, subject: &Subject, rows: &[&Row]) -> Result<String> {
    let plan = results.plan;
    let mut times = plan.times.clone();
    times.sort_by(f64::total_cmp);
    let budget = times.get(times.len() / 2).or(times.last());
    let mut text = match budget {
        Some(t) => format!("<h3>Pictures at about {t} s</h3>\n"),
        None => String::new(),
    };
    if budget.is_some() {
        text +=
            "<p>Below each picture its difference from the reference, as eas-2015 shows them in Figs. 10 and 11.</p>\n";
    }
    let reference = plan.output.join("pictures").join(format!("{}-{}-reference.png", subject.name, subject.digest));
    write_png(&reference, &subject.reference)?;
    let class = if plan.stability { "pictures small" } else { "pictures" };
    let read = |path: &Path| std::fs::read(path).with_context(|| path.display().to_string());
    let _ = write!(
        text,
        "<div class=\"{class}\">\n<figure>{}<figcaption>reference</figcaption></figure>\n",
        picture(&read(&reference)?, "reference")
    );
    let mut crops = Vec::new();
    for name in methods(rows.iter().copied()) {
        let own = || rows.iter().filter(|r| r.method == name);
        // A peer's runs have settings of their own.
        let budgeted = budget.is_some() && own().any(|r| is_budget(r));
        let own = own().filter(|r| !budgeted || is_budget(r));
        let distance = |r: &Row| budget.map_or(0.0, |t| (r.seconds / t).ln().abs());
        let Some(row) = own.min_by(|a, b| distance(a).total_cmp(&distance(b))) else { continue };
        let files = cell::pictures(plan, subject, row);
        // Peers leave rows without pictures.
        if !files.iter().all(|f| f.exists()) {
            continue;
        }
        let [shown, difference] = [read(&files[0])?, read(&files[1])?];
        let about = format!("{name}, {:.2} s, rel_mse {}", row.seconds, plain(&row.rel_mse));
        let _ = writeln!(
            text,
            "<figure>{}{}<figcaption>{}</figcaption></figure>",
            picture(&shown, &about),
            picture(&difference, &format!("difference of {about}")),
            escape(&about)
        );
        crops.push(Shown { about, png: shown });
    }
    text += "</div>\n";
    if !plan.stability {
        text += &crops::section(&read(&reference)?, &crops)?;
    }
    Ok(text)
}

/// All runs.
fn runs(results: &Results) -> String {
    let mut lines = Vec::new();
    for subject in &results.subjects {
        let mut rows: Vec<&Row> = results.of(subject).collect();
        let names = methods(rows.iter().copied());
        let place = |r: &&Row| names.iter().position(|n| *n == r.method);
        rows.sort_by(|a, b| (place(a), is_budget(b)).cmp(&(place(b), is_budget(a))));
        for r in rows {
            let seconds = [r.fill, r.shade, r.denoise, r.seconds].map(|s| format!("{s:.2}"));
            let errors =
                [Some(r.rmse), Some(r.rel_mse), Some(r.max), r.flip].map(|e| e.map_or("–".into(), |e| plain(&e)));
            let memory = [r.size, r.bytes_per_record, r.bytes as f64 / 1e3].map(|x| plain(&x));
            let mut line = vec![escape(&r.scene), escape(&r.method), escape(&r.setting), r.spp.to_string()];
            line.extend(seconds);
            line.push(r.records.to_string());
            line.extend(memory);
            line.extend(errors);
            line.push(format!("{:+.2} %", 100.0 * r.bias));
            line.push(format!("{:.2} %", 100.0 * r.negative));
            lines.push(line);
        }
    }
    let head = [
        "scene",
        "method",
        "setting",
        "spp",
        "fill s",
        "shade s",
        "denoise s",
        "total s",
        "records",
        "EAS / order",
        "bytes per record",
        "KB in all",
        "RMSE",
        "rel_mse",
        "max",
        "flip",
        "bias",
        "negative",
    ];
    format!("<h2 id=\"runs\">All runs</h2>\n{}", table(&head, &lines))
}

const MEASURES: &str = "<h2 id=\"measures\">How to read it</h2>
<ul>
<li>Seconds are those of filling the caches, drawing the picture and denoising it: not loading, not fitting of tables.</li>
<li>RMSE: over pixels and channels, linear RGB. rel_mse: mean of squared error / (reference² + 0.01). Bias: mean difference over
the mean of the reference. Max: largest difference of a channel. Flip: mean ꟻLIP error of the sRGB views.</li>
<li>Bytes per record and number of EAS are means over the glossy records; KB in all are those of all records, irradiance
included.</li>
<li>False colours: relative error of a pixel, the root of the channels' mean of squared error / (reference² + 0.01), from 0 to
100 %, green at 25 %.<div class=\"scale\"></div></li>
</ul>
";
