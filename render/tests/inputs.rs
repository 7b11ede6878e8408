//! Inputs as strangers write them: every file under `tests/inputs`, against the value or the message that stands beside it.
//! The format of `expected.toml` is described in `tests/inputs/README.md`.

use assert_cmd::Command;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// What stands in `expected.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    case: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    scene: Option<String>,
    run: Option<Vec<String>>,
    #[serde(default)]
    args: Vec<String>,
    mean: Option<Value>,
    #[serde(default = "default_tolerance")]
    tolerance: f64,
    #[serde(default)]
    pixels: Vec<Pixel>,
    #[serde(default)]
    warns: Vec<String>,
    #[serde(default)]
    prints: Vec<String>,
    #[serde(default)]
    message: Vec<String>,
    right: Option<String>,
    /// For `tests/peers/mitsuba_inputs.py` alone.
    #[serde(rename = "peer")]
    _peer: Option<String>,
}

/// A colour, or one number for its three channels.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Value {
    Grey(f64),
    Rgb([f64; 3]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Pixel {
    at: [usize; 2],
    value: Value,
}

fn default_tolerance() -> f64 {
    0.002
}

impl Value {
    fn rgb(self) -> [f64; 3] {
        match self {
            Self::Grey(v) => [v; 3],
            Self::Rgb(rgb) => rgb,
        }
    }
}

/// Exit code and standard output and error of `render` in a folder.
fn run(folder: &Path, args: &[String]) -> (Option<i32>, String, String) {
    let output = Command::cargo_bin("render").unwrap().current_dir(folder).args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

impl Case {
    fn name(&self) -> String {
        self.scene.clone().or_else(|| self.run.as_ref().map(|r| r.join(" "))).unwrap_or_default()
    }

    /// The arguments of `render`; a scene is drawn to `out`.
    fn arguments(&self, out: &Path) -> Result<Vec<String>, String> {
        match (&self.scene, &self.run) {
            (Some(scene), None) => {
                let image = ["image", scene, "-o", &out.display().to_string()].map(String::from);
                Ok(image.into_iter().chain(self.args.iter().cloned()).collect())
            }
            (None, Some(run)) if self.args.is_empty() => Ok(run.clone()),
            _ => Err("either `scene` (with `args`) or `run` is needed".into()),
        }
    }

    fn valid(&self, folder: &Path, out: &Path) -> Result<(), String> {
        if self.right.is_none() && self.mean.is_some() {
            return Err("`right` must say where the value comes from".into());
        }
        if self.mean.is_none() && self.pixels.is_empty() && self.prints.is_empty() {
            return Err("nothing is expected of it".into());
        }
        let (code, stdout, stderr) = run(folder, &self.arguments(out)?);
        if code != Some(0) {
            return Err(format!("exit code {code:?}: {stderr}"));
        }
        let warnings: Vec<_> = stderr.lines().filter(|l| l.starts_with("render: warning: ")).collect();
        let expected = |line: &str| self.warns.iter().any(|w| line.contains(w));
        if let Some(line) = warnings.iter().find(|line| !expected(line)) {
            return Err(format!("not expected: {line}"));
        }
        if let Some(missing) = self.warns.iter().find(|w| !warnings.iter().any(|line| line.contains(*w))) {
            return Err(format!("no warning with `{missing}` in: {stderr}"));
        }
        if let Some(missing) = self.prints.iter().find(|p| !stdout.contains(*p)) {
            return Err(format!("`{missing}` is not in: {stdout}"));
        }
        if self.mean.is_none() && self.pixels.is_empty() {
            return Ok(());
        }
        let image = render::image::read(out).map_err(|e| e.to_string())?;
        let near = |what: String, found: [f64; 3], value: Value| {
            let far = found.iter().zip(value.rgb()).any(|(a, b)| (a - b).abs() > self.tolerance);
            if far { Err(format!("{what} is {found:.4?}, right is {:.4?}", value.rgb())) } else { Ok(()) }
        };
        if let Some(mean) = self.mean {
            let sum = |c: usize| image.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
            near("the mean".into(), [0, 1, 2].map(|c| sum(c) / image.pixels.len() as f64), mean)?;
        }
        for Pixel { at: [x, y], value } in &self.pixels {
            let pixel = image.pixels.get(y * image.width as usize + x).filter(|_| *x < image.width as usize);
            let pixel = pixel.ok_or_else(|| format!("no pixel ({x}, {y})"))?;
            near(format!("pixel ({x}, {y})"), pixel.map(f64::from), *value)?;
        }
        Ok(())
    }

    fn invalid(&self, folder: &Path, out: &Path) -> Result<(), String> {
        let (code, _, stderr) = run(folder, &self.arguments(out)?);
        if code != Some(2) {
            return Err(format!("exit code {code:?}: {stderr}"));
        }
        if self.message.is_empty() {
            return Err("no message is expected".into());
        }
        let errors: Vec<_> = stderr.lines().filter(|l| !l.starts_with("render: warning: ")).collect();
        let &[line] = &errors[..] else { return Err(format!("one line is needed: {stderr}")) };
        if line.len() > 600 {
            return Err(format!("a line of {} bytes", line.len()));
        }
        match self.message.iter().find(|m| !line.contains(*m)) {
            Some(missing) => Err(format!("`{missing}` is not in: {line}")),
            None => Ok(()),
        }
    }
}

/// Runs every case of the folders in `tests/inputs/OUTCOME`.
fn all(outcome: &str, judge: fn(&Case, &Path, &Path) -> Result<(), String>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/inputs").join(outcome);
    let mut kinds: Vec<PathBuf> = std::fs::read_dir(&root).unwrap().map(|e| e.unwrap().path()).collect();
    kinds.sort();
    let out = tempfile::tempdir().unwrap();
    let (mut wrong, mut count) = (Vec::new(), 0);
    for kind in kinds.iter().filter(|k| k.is_dir()) {
        // Cases of the command `fitter` are its own tests'.
        let Ok(text) = std::fs::read_to_string(kind.join("expected.toml")) else { continue };
        let expected: Expected = toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", kind.display()));
        for (i, case) in expected.case.iter().enumerate() {
            count += 1;
            if let Err(what) = judge(case, kind, &out.path().join(format!("{i}.exr"))) {
                let kind = kind.file_name().unwrap_or_default().to_string_lossy();
                wrong.push(format!("{kind}/{}: {what}", case.name()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {count} wrong:\n{}", wrong.len(), wrong.join("\n"));
    assert!(count > 0, "no cases in {}", root.display());
}

#[test]
fn valid_inputs_have_their_values() {
    all("valid", Case::valid);
}

#[test]
fn invalid_inputs_have_their_messages() {
    all("invalid", Case::invalid);
}
