use super::{fitter, folder, names, path, refused, table};
use brdf_tables::errors::Errors;

/// Text of all elements of an SVG file, which must be well-formed.
pub fn texts(file: &str) -> String {
    let svg = std::fs::read_to_string(file).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    assert_eq!(document.root_element().tag_name().name(), "svg");
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    document.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect::<Vec<_>>().join(" ")
}

#[test]
fn cuts_of_the_paper() {
    let folder = folder();
    let figure = path(&folder, "fig.svg");
    fitter(["plot", &table(), "-o", &figure]).assert().success();
    let text = texts(&figure);
    for part in ["π/10", "π/30", "phong:exponent=40", "zonal"].into_iter().chain(Errors::NAMES) {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    assert_eq!(names(folder.path()), ["fig.svg"], "no temporary file is left");
}

#[test]
fn solid_angles_and_zenith_as_asked_for() {
    let folder = folder();
    let figure = path(&folder, "fig.svg");
    let flags = ["--theta-deg", "80", "--omega", "pi/4", "--omega", "0.02", "--omega", "2pi"];
    fitter(["plot", &table(), &table(), "-o", &figure]).args(flags).assert().success();
    let text = texts(&figure);
    for part in ["Ω = π/4 sr", "Ω = 0.02 sr", "Ω = 2π sr"] {
        assert_eq!(text.matches(part).count(), 2, "{part} once per table");
    }
    refused(&mut fitter(["plot", &table(), "-o", &figure, "--theta-deg", "91"]), &["--theta-deg", "from 0 to 90"]);
    refused(
        &mut fitter(["plot", &table(), "-o", &figure, "--theta-deg", "nan"]),
        &["--theta-deg", "not a finite number"],
    );
}
