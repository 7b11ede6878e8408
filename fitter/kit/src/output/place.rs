//! What is at a place, links followed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// What is at a place.
pub(super) enum Place {
    /// A file, or nothing yet; links resolved.
    File { path: PathBuf, old: Option<fs::Metadata> },
    /// A device or pipe.
    Special { pipe: bool },
}

/// Most links from one to the next, as in Linux.
const MAX_LINKS: usize = 40;

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether a name stands for a file that the process was given open.
fn is_stream(path: &Path) -> bool {
    ["/dev/stdout", "/dev/stderr"].map(Path::new).contains(&path)
        || ["/dev/fd", "/proc/self/fd"].iter().any(|folder| path.starts_with(folder))
}

impl Place {
    /// Looks there.
    pub(super) fn of(path: &Path) -> Result<Self, String> {
        const FOLDER: &str = "is a directory, not a file";
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(FOLDER.into()),
            // What standard output leads to may be a file: it belongs to whoever opened it, and is not replaced.
            Ok(found) if !found.is_file() || is_stream(path) => {
                #[cfg(unix)]
                let pipe = std::os::unix::fs::FileTypeExt::is_fifo(&found.file_type());
                #[cfg(not(unix))]
                let pipe = false;
                Ok(Self::Special { pipe })
            }
            Ok(found) => Ok(Self::File { path: fs::canonicalize(path).map_err(|e| e.to_string())?, old: Some(found) }),
            Err(e) if e.kind() == ErrorKind::NotFound || e.kind() == ErrorKind::NotADirectory => {
                if path.as_os_str().is_empty() {
                    return Err("the name of a file is needed".into());
                }
                let is_folder =
                    path.as_os_str().as_encoded_bytes().last().is_some_and(|c| std::path::is_separator(*c as char));
                let mut target = path.to_path_buf();
                for _ in 0..MAX_LINKS {
                    let Ok(next) = fs::read_link(&target) else { break };
                    target = folder_of(&target).join(next);
                }
                let (Some(name), false) = (target.file_name(), is_folder) else { return Err(FOLDER.into()) };
                let folder = folder_of(&target);
                match fs::canonicalize(folder).ok().filter(|folder| folder.is_dir()) {
                    Some(folder) => Ok(Self::File { path: folder.join(name), old: None }),
                    None => Err(format!("there is no directory {}", folder.display())),
                }
            }
            Err(e) => Err(e.to_string()),
        }
    }
}
