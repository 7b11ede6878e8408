//! A video of the frames, by ffmpeg where that is installed.

use anyhow::{Context, Result, ensure};
use kit::output::Outputs;
use render::walk::FrameFiles;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Formats of a video.
const EXTENSIONS: [&str; 4] = ["mp4", "mkv", "mov", "webm"];

/// A video to be made of frames.
#[derive(Debug)]
pub(super) struct Video {
    path: PathBuf,
    /// The frames as PNG.
    frames: FrameFiles,
    /// Frames per second.
    fps: f64,
}

impl Video {
    /// A video of the first of these files that is PNG.
    ///
    /// # Errors
    /// No PNG among them, a place that cannot be written.
    pub fn new(path: &Path, fps: f64, outputs: &[PathBuf]) -> Result<Self> {
        Outputs::default().file_of(path, &EXTENSIONS)?;
        let png = outputs.iter().find(|o| o.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")));
        let png = png.context("--video needs frames as PNG: -o out/####.png")?;
        let frames = FrameFiles::new(png).map_err(anyhow::Error::msg).with_context(|| png.display().to_string())?;
        Ok(Self { path: path.into(), frames, fps })
    }

    /// Refuses frames with gaps.
    pub fn check(frames: &[u32]) -> Result<()> {
        let ends = frames.iter().min().zip(frames.iter().max());
        let follow = ends.is_some_and(|(first, last)| (last - first) as usize + 1 == frames.len());
        ensure!(follow, "--video needs frames that follow each other");
        Ok(())
    }

    /// Makes it of frames that follow each other; where ffmpeg is not installed, says what to run.
    ///
    /// # Errors
    /// An ffmpeg that fails.
    pub fn make(&self, frames: &[u32]) -> Result<()> {
        let first = frames.iter().min().copied().unwrap_or_default();
        // Written beside its name and renamed, as all outputs are; the ending tells the format.
        let name = self.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let part = self.path.with_file_name(format!(".part-{}-{name}", std::process::id()));
        let arguments = |to: &Path| -> Vec<String> {
            // H.264 for all players: even sizes, colours at half resolution.
            let start = first.to_string();
            let fps = self.fps.to_string();
            let before = ["-y", "-loglevel", "error", "-framerate", &fps, "-start_number", &start, "-i"];
            let count = frames.len().to_string();
            let after = ["-frames:v", &count, "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"];
            let all = before.iter().map(ToString::to_string).chain([self.frames.printf()]);
            all.chain(after.iter().map(ToString::to_string)).chain([to.display().to_string()]).collect()
        };
        let run = Command::new("ffmpeg").args(arguments(&part)).stdin(Stdio::null()).output();
        match run {
            Ok(done) if done.status.success() => {
                std::fs::rename(&part, &self.path).with_context(|| self.path.display().to_string())
            }
            Ok(done) => {
                let _ = std::fs::remove_file(&part);
                let said = String::from_utf8_lossy(&done.stderr).into_owned();
                anyhow::bail!("{}: ffmpeg: {}", self.path.display(), said.lines().last().unwrap_or("failed"))
            }
            Err(_) => {
                eprintln!(
                    "render: ffmpeg is not installed; the video is made by\n  ffmpeg {}",
                    arguments(&self.path).join(" ")
                );
                Ok(())
            }
        }
    }
}
