//! A folder with a scene in which tests run `render`.

use assert_cmd::Command;
use std::path::PathBuf;

/// Holds `scene.xml`; gone with the value.
pub struct Folder {
    pub folder: tempfile::TempDir,
    first: Vec<String>,
}

impl Folder {
    /// With this scene, and arguments that come before those of every run.
    pub fn with(scene: &str, first: &[&str]) -> Self {
        let first = first.iter().map(|arg| (*arg).to_owned()).collect();
        let folder = Self { folder: tempfile::tempdir().unwrap(), first };
        std::fs::write(folder.path("scene.xml"), scene).unwrap();
        folder
    }

    /// A file of the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `render` in the folder with arguments divided by spaces; returns exit code, output and errors.
    pub fn run(&self, args: &str) -> (i32, String, String) {
        let mut command = Command::cargo_bin("render").unwrap();
        let output =
            command.current_dir(self.folder.path()).args(&self.first).args(args.split_whitespace()).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
    }

    /// Runs what must succeed; returns output and errors.
    pub fn ok(&self, args: &str) -> (String, String) {
        let (code, out, err) = self.run(args);
        assert_eq!(code, 0, "{args}: {err}");
        (out, err)
    }

    /// Bad input: exit code 2, and a line that names what is wrong; returns what was said.
    pub fn bad(&self, args: &str, mention: &str) -> String {
        let (code, _, err) = self.run(args);
        assert_eq!(code, 2, "{args}: {err}");
        assert!(err.contains(mention) && !err.contains("panicked"), "{args}: {err}");
        err
    }
}
