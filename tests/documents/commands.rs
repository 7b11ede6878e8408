//! Commands of the manuals. Those of every block are parsed by the programs; those of blocks below [`MARK`], which are short, are
//! run in a copy of the scenes and tables.

use super::{PAGES, page, root};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A program as this build made it, beside the tests. `cargo test` of the whole workspace builds both.
fn program(name: &str) -> PathBuf {
    let folder = std::env::current_exe().unwrap().ancestors().nth(2).unwrap().to_owned();
    let path = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.exists(), "{}: build the programs first, with the profile of the tests: cargo build", path.display());
    path
}

/// What stands on the line above a block that is run.
const MARK: &str = "<!-- run by the tests -->\n";

/// Fenced blocks of shell, and whether they are marked.
fn blocks(text: &str) -> impl Iterator<Item = (bool, &str)> {
    let parts: Vec<&str> = text.split("```").collect();
    let pairs = (1..parts.len()).step_by(2).map(move |i| (parts[i - 1].ends_with(MARK), parts[i]));
    pairs.filter_map(|(marked, block)| Some((marked, block.strip_prefix("sh\n")?)))
}

/// Lines of shell: those of blocks, and indented ones elsewhere, without comments and with continued lines joined.
fn lines(text: &str) -> Vec<String> {
    let fenced = blocks(text).map(|(_, inside)| inside.to_owned());
    let indented = text.split("```").step_by(2).flat_map(str::lines).filter(|line| line.starts_with("    "));
    let all = fenced.chain([indented.collect::<Vec<_>>().join("\n")]).collect::<Vec<_>>().join("\n");
    let joined = all.replace("\\\n", " ");
    let bare = joined.lines().map(|line| line.split(" #").next().unwrap_or_default());
    let spaced = bare.map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "));
    spaced.filter(|line| !line.is_empty()).collect()
}

/// The calls of our programs in a line of shell, as words: each part of a list or pipe up to where it is redirected.
fn calls(line: &str) -> Vec<Vec<&str>> {
    let parts = line.split(['&', '|', ';', '(', ')']).map(|part| part.split(['<', '>']).next().unwrap_or_default());
    let words = parts.map(|part| part.trim().trim_start_matches("/usr/bin/time -v").split_whitespace().collect());
    words.filter(|words: &Vec<&str>| matches!(words.first(), Some(&("render" | "fitter")))).collect()
}

/// Whether a program understands options and values: arguments are parsed in their order, so that what is wrong is told
/// before the help that the last one asks for. Nothing is opened or run.
fn parsed(call: &[&str]) -> Output {
    // What comes after `--` is for another command.
    let ours = call[1..].iter().take_while(|word| **word != "--");
    Command::new(program(call[0])).args(ours).arg("--help").output().unwrap()
}

#[test]
fn commands_of_manuals_are_understood() {
    let (mut found, mut wrong) = (0, Vec::new());
    for name in PAGES {
        for line in lines(&page(name)) {
            for call in calls(&line) {
                found += 1;
                let output = parsed(&call);
                if !output.status.success() {
                    wrong.push(format!("{name}: {}: {}", call.join(" "), String::from_utf8_lossy(&output.stderr)));
                }
                let ours = |word: &&&str| word.starts_with("tests/") || word.starts_with("tables/");
                let absent = call.iter().filter(ours).filter(|path| !root().join(path).exists());
                wrong.extend(absent.map(|path| format!("{name}: {path} is not there")));
            }
        }
    }
    assert!(wrong.is_empty(), "commands that do not work: {wrong:#?}");
    assert!(found > 40, "only {found} commands were found: are the pages still written this way?");
}

/// The check itself: what it must find.
#[test]
fn mistakes_in_commands_are_found() {
    assert_eq!(
        calls("a && /usr/bin/time -v render info b | fitter query c < d; cargo run -p burnish-render"),
        [vec!["render", "info", "b"], vec!["fitter", "query", "c"],]
    );
    let text = "```sh\nfitter info a  # b\n```\nrender this\n\n    render image a \\\n        -o b\n";
    assert_eq!(lines(text), ["fitter info a", "render image a -o b"]);
    for good in [&["render", "image", "a.xml", "--method", "auto"][..], &["fitter", "fit", "phong:exponent=1"]] {
        assert!(parsed(good).status.success(), "{good:?}");
    }
    for bad in [
        &["render", "picture"][..],
        &["render", "image", "a.xml", "--no-such-option"],
        &["render", "image", "a.xml", "--method", "none-such"],
        &["render", "image", "a.xml", "--spp", "many"],
        &["fitter", "fit", "phong", "--no-such-option"],
    ] {
        assert_eq!(parsed(bad).status.code(), Some(2), "{bad:?}");
    }
}

/// Copies a folder with all it holds.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[cfg(unix)]
#[test]
fn short_commands_of_manuals_run() {
    let folder = program("render").parent().unwrap().to_owned();
    program("fitter");
    let path = std::env::join_paths(
        [folder].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let path = path.unwrap();
    let mut found = 0;
    for name in PAGES {
        let text = page(name);
        for (_, block) in blocks(&text).filter(|(marked, _)| *marked) {
            found += 1;
            let place = tempfile::tempdir().unwrap();
            for part in ["tests/scenes", "tests/inputs/valid/measured", "tables"] {
                copy(&root().join(part), &place.path().join(part));
            }
            let script = format!("set -euo pipefail\n{block}");
            let output =
                Command::new("bash").args(["-c", &script]).env("PATH", &path).current_dir(&place).output().unwrap();
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{name}: a block ends with {}:\n{block}\n{error}", output.status);
        }
    }
    assert!(found >= 3, "only {found} blocks are marked");
}
