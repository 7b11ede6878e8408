//! The frames of a chart: references, and what each method draws in its time.

use super::frame::{Frame, Measured};
use super::{Args, WalkLine};
use crate::cli::walk;
use anyhow::{Context, Result, ensure};
use clap::Parser;
use render::image::{Image, read};
use render::metric::{Flicker, Truth};
use std::path::Path;

/// A way to draw frames.
#[derive(Debug)]
pub(super) struct Method {
    /// What it is called.
    pub name: &'static str,
    /// Its options of `render walk`.
    options: [&'static str; 4],
    /// Colour of its curves.
    pub color: &'static str,
}

impl Method {
    fn is_cached(&self) -> bool {
        self.options[1] != "path"
    }
}

/// The ways that are charted; the third is what the others are measured by.
pub(super) const METHODS: [Method; 4] = [
    Method { name: "caches", options: ["--method", "auto", "--denoise", "off"], color: "#e69f00" },
    Method { name: "caches + denoiser", options: ["--method", "auto", "--denoise", "auto"], color: "#d55e00" },
    Method { name: "path + denoiser", options: ["--method", "path", "--denoise", "auto"], color: "#0072b2" },
    Method { name: "path", options: ["--method", "path", "--denoise", "off"], color: "#56b4e9" },
];

/// Name of the rival.
pub(super) const RIVAL: &str = METHODS[2].name;

/// Seeds of the references: of no picture that is measured.
const SEEDS: [u32; 2] = [7001, 7002];

/// What a chart draws.
pub(super) struct Work<'a> {
    pub args: &'a Args,
    /// In order.
    pub frames: Vec<u32>,
}

impl Work<'_> {
    /// Two references of every frame; those that are there are not drawn again.
    pub fn references(&self) -> Result<[Vec<Image>; 2]> {
        let spp = self.args.reference_spp.to_string();
        let [first, second] = SEEDS.map(|seed| {
            let folder = self.args.output.join(format!("reference-{seed}"));
            eprintln!("render: references, seed {seed}");
            let options =
                ["--method", "path", "--denoise", "off", "--spp", &spp, "--seed", &seed.to_string(), "--skip-existing"]
                    .map(String::from);
            self.draw(&folder, &options)?;
            self.read(&folder)
        });
        Ok([first?, second?])
    }

    /// Draws frames in one way in this time each, and compares them.
    pub fn measure(&self, method: &'static Method, seconds: f64, references: &[Vec<Image>; 2]) -> Result<Measured> {
        eprintln!("render: {} in {seconds} s a frame", method.name);
        let folder = self.args.output.join(format!("{}-{seconds}", method.name.replace(" + ", "-")));
        let stats = folder.join("stats.json");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let time = seconds.to_string();
        let mut options: Vec<String> = method.options.map(String::from).to_vec();
        options.extend(["--time-per-frame", &time, "--stats"].map(String::from));
        options.push(path(&stats)?);
        if let Some(tables) = self.args.tables.as_ref().filter(|_| method.is_cached()) {
            options.extend(["--tables".into(), path(tables)?]);
        }
        self.draw(&folder, &options)?;
        let text = std::fs::read(&stats).with_context(|| stats.display().to_string())?;
        let stats: serde_json::Value = serde_json::from_slice(&text)?;
        let images = self.read(&folder)?;
        let mut flicker = Flicker::default();
        let mut measured = Vec::with_capacity(images.len());
        for ((&number, image), (first, second)) in
            self.frames.iter().zip(&images).zip(references[0].iter().zip(&references[1]))
        {
            let truth = Truth::two(first, second)?;
            let figures = truth.compare(image)?;
            measured.push(Frame { number, figures, flicker: flicker.add(number, image, &truth)? });
        }
        let count = |key: &str| stats[key].as_f64().unwrap_or_default();
        let spent = |key: &str| stats["seconds"][key].as_f64().unwrap_or_default();
        let drawn = self.frames.len() as f64;
        let spent = spent("fill") / count("path_frames").max(1.0)
            + (spent("shade") + spent("denoise") + spent("write")) / drawn;
        Ok(Measured {
            method,
            seconds,
            spent,
            spp: count("spp") as u32,
            tau: count("tau"),
            frames: measured,
            flicker: flicker.mean(),
            images,
        })
    }

    /// Runs `render walk` for the frames of the chart.
    fn draw(&self, folder: &Path, options: &[String]) -> Result<()> {
        walk::run(&mut self.line(folder, options)?.args).map(drop)
    }

    /// The command line of `render walk` for the frames of the chart.
    ///
    /// # Errors
    /// An option after `--` that it does not understand.
    pub fn line(&self, folder: &Path, options: &[String]) -> Result<WalkLine> {
        let Args { scene, path: camera, options: given, .. } = self.args;
        let frames: Vec<String> = self.frames.iter().map(u32::to_string).collect();
        let mut line = vec![path(scene)?, "--path".into(), path(camera)?, "--frames".into(), frames.join(",")];
        line.extend(["-o".into(), path(&folder.join("####.exr"))?]);
        line.extend(options.iter().chain(given).cloned());
        WalkLine::try_parse_from(&line).map_err(|e| {
            let text = e.to_string();
            anyhow::anyhow!("after --: {}", text.lines().next().unwrap_or_default().trim_start_matches("error: "))
        })
    }

    /// The frames that are in a folder.
    fn read(&self, folder: &Path) -> Result<Vec<Image>> {
        let files = render::walk::FrameFiles::new(&folder.join("####.exr")).map_err(anyhow::Error::msg)?;
        self.frames.iter().map(|frame| Ok(read(&files.of(*frame))?)).collect()
    }
}

/// A path as an argument.
fn path(path: &Path) -> Result<String> {
    let text = path.to_str().map(str::to_owned);
    ensure!(text.is_some(), "{}: a chart needs names in UTF-8", path.display());
    Ok(text.unwrap_or_default())
}
