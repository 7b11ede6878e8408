use super::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn places_are_looked_at_first() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("file"), "x").unwrap();
    fs::create_dir(at("inner")).unwrap();
    let check = |path: &Path| Outputs::default().file(path).map_err(|e| e.what);
    for (name, what) in [
        ("inner", "is a directory, not a file"),
        ("new/", "is a directory, not a file"),
        ("inner/..", "is a directory, not a file"),
        ("no/x", "there is no directory"),
        ("file/x", "there is no directory"),
        (&"n".repeat(300), "name too long"),
    ] {
        let found = check(&at(name)).unwrap_err();
        assert!(found.to_lowercase().contains(what), "{name}: {found}");
    }
    assert!(check(Path::new("")).is_err());
    for name in ["new", "file", "inner/new", "inner/../new"] {
        assert_eq!(check(&at(name)), Ok(()), "{name}");
    }
    assert_eq!(names(folder.path()), ["file", "inner"], "nothing is left behind");
    assert!(check_folder(&at("a/b/c")).is_ok() && check_folder(folder.path()).is_ok());
    assert_eq!(check_folder(&at("file")).unwrap_err().what, "is a file, not a directory");
    assert!(check_folder(&at("file/a")).unwrap_err().what.ends_with("is a file, not a directory"));
}

#[test]
fn a_file_is_written_once_and_is_no_input() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("scene"), "x").unwrap();
    fs::create_dir(at("inner")).unwrap();
    let scene = at("scene");
    let mut outputs = Outputs::beside([scene.as_path()]);
    outputs.file_of(&at("a.PNG"), &["exr", "png"]).unwrap();
    let message = |error: OutputError| error.to_string();
    let twice = message(outputs.file(&at("inner/../a.PNG")).unwrap_err());
    assert!(twice.contains("is written twice by this command, as ") && !twice.contains('\n'), "{twice}");
    assert!(message(outputs.file(&at("inner/../scene")).unwrap_err()).contains("is read by this command too"));
    let named = message(outputs.file_of(&at("a.gif"), &["exr", "png"]).unwrap_err());
    assert!(named.ends_with("a.gif: the name must end in .exr or .png"), "{named}");
}

#[test]
fn files_are_whole_and_leave_nothing_beside_them() {
    let folder = folder();
    let path = folder.path().join("a");
    write(&path, b"one").unwrap();
    write(&path, b"two").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"two");
    assert!(write(&folder.path().join("no/a"), b"x").unwrap_err().to_string().contains("there is no directory"));
    assert_eq!(names(folder.path()), ["a"]);
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    /// New files have the permissions of any new file; a file that is replaced keeps its own.
    #[test]
    fn permissions() {
        let folder = folder();
        let (made, other) = (folder.path().join("made"), folder.path().join("other"));
        write(&made, b"x").unwrap();
        fs::write(&other, "x").unwrap();
        assert_eq!(mode(&made), mode(&other));
        fs::set_permissions(&made, fs::Permissions::from_mode(0o640)).unwrap();
        write(&made, b"y").unwrap();
        assert_eq!((mode(&made), fs::read(&made).unwrap()), (0o640, b"y".to_vec()));
    }

    #[test]
    fn links_are_followed() {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("inner")).unwrap();
        for (link, target) in [("old", "inner/old"), ("new", "inner/new"), ("chain", "new"), ("loop", "loop")] {
            symlink(target, at(link)).unwrap();
        }
        fs::write(at("inner/old"), "x").unwrap();
        write(&at("old"), b"1").unwrap();
        write(&at("chain"), b"2").unwrap();
        assert_eq!(fs::read(at("inner/old")).unwrap(), b"1");
        assert_eq!(fs::read(at("inner/new")).unwrap(), b"2");
        assert!(fs::symlink_metadata(at("old")).unwrap().is_symlink());
        assert!(Outputs::default().file(&at("loop")).is_err());
        let mut outputs = Outputs::default();
        outputs.file(&at("chain")).unwrap();
        assert!(outputs.file(&at("inner/new")).is_err(), "the same file");
    }

    #[test]
    fn devices_are_written_to() {
        let mut outputs = Outputs::default();
        let null = Path::new("/dev/null");
        outputs.file_of(null, &["png"]).unwrap();
        outputs.file(null).unwrap();
        write(null, b"x").unwrap();
        assert!(!fs::metadata(null).unwrap().is_file());
        if Path::new("/dev/full").exists() {
            let error = write(Path::new("/dev/full"), b"x").unwrap_err().to_string();
            assert!(error.starts_with("/dev/full: No space left on device"), "{error}");
        }
    }
}
