//! Numbers of frames, and the names of their files.

use core::str::FromStr;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Largest number of a frame.
pub const LAST_FRAME: u32 = 9_999_999;
/// Most frames of a command.
pub const MAX_FRAMES: usize = 100_000;

/// Numbers of frames in the order in which they were asked for, each once and none above [`LAST_FRAME`]; as typed: `1-60`, `1,5,9`, or both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameNumbers(Vec<u32>);

impl FrameNumbers {
    /// In their order.
    pub fn as_slice(&self) -> &[u32] {
        &self.0
    }
}

impl FromStr for FrameNumbers {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| match text.trim().parse::<u32>() {
            Ok(n) if n <= LAST_FRAME => Ok(n),
            _ => Err(format!("expected frames as 1-60 or 1,5,9, with numbers from 0 to {LAST_FRAME}")),
        };
        let mut frames = Vec::new();
        for part in text.split(',') {
            let (first, last) = match part.split_once('-') {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(part)?, number(part)?),
            };
            if last < first {
                return Err(format!("{first}-{last}: the last frame comes before the first"));
            }
            if frames.len() + (last - first) as usize >= MAX_FRAMES {
                return Err(format!("more than {MAX_FRAMES} frames"));
            }
            frames.extend(first..=last);
        }
        let mut sorted = frames.clone();
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(format!("frame {} is there twice", pair[0])),
            None => Ok(Self(frames)),
        }
    }
}

/// Names of files with one run of `#` where the number of a frame stands, with zeros in front up to its length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameFiles {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl FrameFiles {
    /// From a path whose last part has the `#`.
    ///
    /// # Errors
    /// None, or several runs; one line without the path.
    pub fn new(path: &Path) -> Result<Self, String> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let run = |from: usize| name[from..].bytes().take_while(|b| *b == b'#').count();
        let Some(start) = name.find('#') else {
            return Err("the name of the file needs #### where the number of a frame goes".into());
        };
        let digits = run(start);
        let after = &name[start + digits..];
        if after.contains('#') {
            return Err("the name has two places for the number of a frame".into());
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(Self { folder, before: name[..start].into(), digits, after: after.into() })
    }

    /// The file of a frame.
    pub fn of(&self, frame: u32) -> PathBuf {
        let Self { folder, before, digits, after } = self;
        folder.join(OsString::from(format!("{before}{frame:0digits$}{after}")))
    }

    /// Their names as `printf` and ffmpeg have them.
    pub fn printf(&self) -> String {
        let Self { folder, before, digits, after } = self;
        let quoted = |text: &str| text.replace('%', "%%");
        let name = format!("{}%0{digits}d{}", quoted(before), quoted(after));
        folder.join(name).display().to_string()
    }

    /// Where all of them are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_lists_and_ranges() {
        let parse = |text: &str| text.parse::<FrameNumbers>().map(|f| f.0);
        assert_eq!(parse("1-4"), Ok(vec![1, 2, 3, 4]));
        assert_eq!(parse("9,5, 1"), Ok(vec![9, 5, 1]));
        assert_eq!(parse("0-1,7"), Ok(vec![0, 1, 7]));
        assert_eq!(parse("3-3"), Ok(vec![3]));
        for bad in ["", "a", "1-", "-3", "1,,2", "4-1", "1,1", "1-5,3", "0-4000000000", "0-9999999", "1-2-3", "1.5"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn files_are_numbered() {
        let files = FrameFiles::new(Path::new("out/a.####.exr")).unwrap();
        assert_eq!(files.of(7), Path::new("out/a.0007.exr"));
        assert_eq!(files.of(123_456), Path::new("out/a.123456.exr"));
        assert_eq!(files.printf(), "out/a.%04d.exr");
        assert_eq!(FrameFiles::new(Path::new("#.png")).unwrap().of(12), Path::new("12.png"));
        for bad in ["out.exr", "#/a.exr", "##a##.exr", "", "/"] {
            assert!(FrameFiles::new(Path::new(bad)).is_err(), "{bad}");
        }
    }
}
