//! The files of frames: their names, what they say of themselves, and whether they are whole.

use super::Args;
use anyhow::{Result, ensure};
use kit::output::Outputs;
use render::image::{read_note, read_pixels};
use render::picture::Budget;
use render::scene::Camera;
use render::scene::checksum::Hash;
use render::walk::FrameFiles;
use std::path::{Path, PathBuf};

/// Formats that can say what a frame was drawn with.
const EXTENSIONS: [&str; 2] = ["exr", "png"];

/// The files of frames.
pub(super) struct Files(Vec<FrameFiles>);

impl Files {
    /// By the names of the command line.
    pub fn new(args: &Args) -> Result<Self> {
        let files = |path: &PathBuf| FrameFiles::new(path).map_err(|e| anyhow::anyhow!("{}: {e}", path.display()));
        let files = Self(args.image.output.iter().map(files).collect::<Result<_>>()?);
        files.check(args, &[])?;
        Ok(files)
    }

    /// Refuses places that cannot be written, and files that are read; makes the folders of frames.
    pub fn check(&self, args: &Args, read: &[PathBuf]) -> Result<()> {
        let named = [args.image.scene.as_path(), &args.path].into_iter().chain(args.image.reading.files());
        let mut outputs = Outputs::beside(named.chain(read.iter().map(PathBuf::as_path)));
        for files in &self.0 {
            let folder = files.folder();
            if !folder.as_os_str().is_empty() {
                kit::output::check_folder(folder)?;
                std::fs::create_dir_all(folder).map_err(|e| anyhow::anyhow!("{}: {e}", folder.display()))?;
            }
            // One stands for all.
            outputs.file_of(&files.of(0), &EXTENSIONS)?;
        }
        let frames = args.frames.iter().flat_map(|frames| frames.as_slice());
        let taken = frames.flat_map(|frame| self.of(*frame)).find(|path| read.contains(path));
        ensure!(taken.is_none(), "{}: is read by this command too", taken.unwrap_or_default().display());
        for path in args.image.cache.iter().filter(|_| !args.frames_only).chain(&args.image.stats) {
            outputs.file(path)?;
        }
        args.image.looking.check(&args.image.output, false)
    }

    /// Those of a frame.
    pub fn of(&self, frame: u32) -> impl Iterator<Item = PathBuf> {
        self.0.iter().map(move |files| files.of(frame))
    }

    /// What the files of a frame say of themselves: checksum of all that they depend on. `made` stands for scene, materials and
    /// records.
    pub fn note(&self, args: &Args, frame: u32, camera: &Camera, budget: Budget, made: &str) -> String {
        let image = &args.image;
        let mut hash = Hash::default();
        hash.encoded(&(frame, camera));
        hash.text(&format!(
            "{} {made} {budget:?} {} {} {:?} {:?} {}",
            env!("CARGO_PKG_VERSION"),
            image.seed,
            image.indirect_only,
            image.max_depth,
            image.looking.look(),
            image.soft_terminator
        ));
        format!("burnish walk, frame {frame}, {:016x}", hash.finish())
    }
}

/// Whether a file is there, can be read to its end, and has the size and note of a frame.
pub(super) fn is_whole(path: &Path, note: &str, camera: &Camera) -> bool {
    let window = camera.film.window();
    path.exists()
        && read_note(path).is_ok_and(|found| found.as_deref() == Some(note))
        && read_pixels(path).is_ok_and(|pixels| {
            let image = render::image::Image::from(pixels);
            (image.width, image.height) == (window.width, window.height)
        })
}
