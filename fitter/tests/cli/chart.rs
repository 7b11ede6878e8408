use super::{fitter, folder, names, path, plot::texts};

/// One figure and one CSV file, with every method that the material allows and positive finite numbers.
#[test]
fn figure_and_csv() {
    let folder = folder();
    let figure = path(&folder, "chart.svg");
    let flags = ["--points", "2", "--lobes", "1", "--solvers", "lm"];
    fitter(["chart", "phong:exponent=20", "-o", &figure]).args(flags).assert().success();
    assert_eq!(names(folder.path()), ["chart.csv", "chart.svg"]);
    let text = texts(&figure);
    let csv = std::fs::read_to_string(path(&folder, "chart.csv")).unwrap();
    let rules = ["disc rules (no table)", "product rules (no table)"];
    for method in
        ["zonal", "cubature table", "lobes lm", "paper", "exact quadrature", "Monte Carlo"].into_iter().chain(rules)
    {
        assert!(text.contains(method) && csv.contains(&format!("\",{method},")), "{method}");
    }
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    assert_eq!((&header[..5], header.len()), (&["material", "method", "setting", "nanoseconds", "bytes"][..], 20));
    for line in csv.lines().skip(1) {
        let fields: Vec<&str> = line.split("\",").nth(1).unwrap().split(',').collect();
        assert_eq!(fields.len(), 19, "{line}");
        assert!(fields[2].parse::<f64>().unwrap() > 0.0, "{line}");
        assert!(fields[4..].iter().all(|x| x.parse::<f64>().unwrap() >= 0.0), "{line}");
    }
}
