//! How scenes are read: options of every command that reads one.

use anyhow::{Result, ensure};
use clap::builder::{OsStringValueParser, TypedValueParser};
use kit::number::number;
use render::scene::load::{LightUnits, Options, Sky, SkySource};
use std::ffi::OsString;
use std::path::Path;

/// Frames per second where nothing says otherwise: Blender's default.
const FPS: f64 = 24.0;

/// Options of reading.
#[derive(Debug, clap::Args)]
pub struct Reading {
    /// Set a parameter of a Mitsuba scene.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = parse_define)]
    define: Vec<(String, String)>,
    /// Draw what is there where mesh or texture files are missing.
    #[arg(long)]
    skip_missing: bool,
    /// Light from infinity for a scene without a sky: radiance R,G,B, or a latitude-longitude picture (EXR, HDR; PNG and
    /// JPEG as sRGB).
    ///
    /// A picture lies as Blender's world does after the export to glTF, y up: its top is +y, its middle +x, and the
    /// middle of its right half +z.
    #[arg(long, value_name = "FILE|R,G,B", value_parser = OsStringValueParser::new().try_map(parse_sky))]
    env: Option<SkySource>,
    /// Factor on the radiance of --env [default: 1].
    #[arg(long, value_name = "FACTOR", requires = "env", value_parser = number(0.0..=f32::MAX, "a number ≥ 0"))]
    env_scale: Option<f32>,
    /// Turn the picture of --env about the vertical axis, counter-clockwise as seen from above [default: 0].
    #[arg(long, value_name = "DEGREES", requires = "env", allow_negative_numbers = true,
        value_parser = number(-36000.0..=36000.0f32, "degrees from -36000 to 36000"))]
    env_turn: Option<f32>,
    /// Draw a frame of a glTF file's animations; frame 0 is at their start.
    #[arg(long, value_name = "N", conflicts_with = "time_of_animation", value_parser = number(0.0..=1e9f64, "a number ≥ 0"))]
    frame: Option<f64>,
    /// Frames per second of --frame [default: 24, as in Blender].
    #[arg(long, value_name = "N", requires = "frame", value_parser = number(1e-3..=1e6f64, "a number > 0"))]
    fps: Option<f64>,
    /// Draw a moment of a glTF file's animations.
    #[arg(long, value_name = "SECONDS", value_parser = number(0.0..=1e9f32, "a number ≥ 0"))]
    time_of_animation: Option<f32>,
    /// In which units the lamps of a glTF file are [default: standard, unless those of a file by Blender are round numbers
    /// in another one].
    #[arg(long, value_enum)]
    light_units: Option<Units>,
    /// The camera that takes the picture: the name of the camera or of its node, the id of a Mitsuba sensor, or a number
    /// counted from 0 [default: the first].
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// The scene of a glTF file: its name, or a number counted from 0 [default: the one that the file names].
    #[arg(long = "scene", id = "scene_of_file", value_name = "NAME|INDEX")]
    scene: Option<String>,
}

/// The lighting modes of Blender's exporter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Units {
    /// Candela and lux, at 683 lm/W.
    #[value(alias = "spec")]
    Standard,
    /// W/sr and W/m².
    #[value(alias = "compat")]
    Unitless,
    /// The numbers typed in Blender: W, and W/m² of suns.
    Raw,
}

impl From<Units> for LightUnits {
    fn from(units: Units) -> Self {
        match units {
            Units::Standard => Self::Standard,
            Units::Unitless => Self::Unitless,
            Units::Raw => Self::Raw,
        }
    }
}

impl Reading {
    /// As the loader takes them.
    ///
    /// # Errors
    /// Options that do not go together.
    pub fn options(&self) -> Result<Options> {
        ensure!(
            self.env_turn.is_none() || !matches!(self.env, Some(SkySource::Color(_))),
            "--env-turn needs a picture as --env: a colour is the same on all sides"
        );
        let sky = |source: &SkySource| Sky {
            source: source.clone(),
            scale: self.env_scale.unwrap_or(1.0),
            turn: self.env_turn.unwrap_or(0.0).to_radians(),
        };
        Ok(Options {
            defines: self.define.clone(),
            skip_missing: self.skip_missing,
            environment: self.env.as_ref().map(sky),
            light_units: self.light_units.map(Into::into),
            camera: self.camera.clone(),
            scene: self.scene.clone(),
            animation_time: self.animation_time(),
            track: None,
        })
    }

    /// Seconds from the start of the animations; keys are stored in the same precision.
    fn animation_time(&self) -> Option<f32> {
        self.frame.map(|frame| (frame / self.fps.unwrap_or(FPS)) as f32).or(self.time_of_animation)
    }

    /// Files that are read beside the scene.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.env.iter().filter_map(|source| match source {
            SkySource::Picture(path) => Some(path.as_path()),
            SkySource::Color(_) => None,
        })
    }
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_owned(), value.to_owned()))
}

/// Three numbers are a colour; what is no number is the name of a file.
fn parse_sky(text: OsString) -> Result<SkySource, String> {
    let numbers: Option<Vec<f32>> =
        text.to_str().and_then(|text| text.split(',').map(|n| n.trim().parse().ok()).collect());
    match numbers.as_deref() {
        None if text.is_empty() => Err("expected a file, or R,G,B".into()),
        None => Ok(SkySource::Picture(text.into())),
        Some(&[r, g, b]) if [r, g, b].iter().all(|c| c.is_finite() && *c >= 0.0) => Ok(SkySource::Color([r, g, b])),
        Some(_) => Err("expected a file, or R,G,B: three finite numbers ≥ 0".into()),
    }
}
