use super::{MATERIAL, fitter, folder, output, path, refused, table};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};

const HEADER: &str = "theta_e,phi_e,omega,wo_x,wo_y,wo_z";

/// The answers to rows, as numbers.
fn numbers(arguments: &[&str], input: &str) -> Vec<Vec<f64>> {
    let output = fitter(arguments).write_stdin(input).assert().success().get_output().stdout.clone();
    let text = String::from_utf8(output).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

/// Caps of all sizes, whole and clipped, seen from near their mirror direction.
fn rows() -> String {
    let mut text = String::from(HEADER) + "\n";
    for i in 0..40 {
        let (theta, phi) = (0.04 * f64::from(i), 0.7 * f64::from(i));
        let omega = 1e-3 * 1.2f64.powi(i);
        let view = (theta + 0.05 * f64::from(i % 3) - 0.05).clamp(0.0, 1.5);
        let (x, y) = (-view.sin() * phi.cos(), -view.sin() * phi.sin());
        text += &format!("{theta},{phi},{omega},{x},{y},{}\n", view.cos());
    }
    text
}

/// The table against Monte Carlo, which shares no code with it: within four standard errors and the tolerance.
#[test]
fn query_agrees_with_integrate() {
    let table_rows = numbers(&["query", &table()], &rows());
    let truth = numbers(&["integrate", MATERIAL, "--samples", "16384"], &rows());
    assert_eq!((table_rows.len(), truth.len()), (40, 40));
    for (a, b) in table_rows.iter().zip(&truth) {
        assert_eq!((a.len(), b.len()), (9, 12));
        for c in 0..3 {
            let (value, exact, stderr) = (a[6 + c], b[6 + c], b[9 + c]);
            assert!((value - exact).abs() <= 4.0 * stderr + 0.01 * exact, "{value} for {exact} ± {stderr}: {a:?}");
        }
    }
}

/// ρ/π, exactly.
#[test]
fn lambert_is_exact() {
    let folder = folder();
    let file = path(&folder, "chalk.tbl");
    output(["fit", "lambert:reflectance=[0.5,0.25,1]", "-o", &file]);
    for row in numbers(&["query", &file], &rows())
        .iter()
        .chain(&numbers(&["integrate", "lambert:reflectance=[0.5,0.25,1]"], &rows()))
    {
        for (value, rho) in row[6..9].iter().zip([0.5, 0.25, 1.0]) {
            assert!((value * core::f64::consts::PI - rho).abs() < 1e-15);
        }
    }
}

#[test]
fn integrate_depends_on_the_seed_alone() {
    let run = |seed, threads| {
        numbers(&["integrate", MATERIAL, "--samples", "512", "--seed", seed, "--threads", threads], &rows())
    };
    assert_eq!(run("1", "1"), run("1", "2"));
    assert_ne!(run("1", "2"), run("2", "2"));
}

#[test]
fn a_bad_row_is_one_error_naming_its_line() {
    let table = table();
    for (row, part) in [
        ("0.5,0,0.1,0,0", "5 columns"),
        ("0.5,0,0.1,0,0,one", "wo_z"),
        ("0.5,0,NaN,0,0,1", "omega"),
        ("1.6,0,0.1,0,0,1", "theta_e"),
        ("0.5,0,7,0,0,1", "omega"),
        ("0.5,0,0.1,0,0,2", "length"),
        ("0.5,0,0.1,0.6,0,-0.8", "horizon"),
    ] {
        for command in [["query", &table], ["integrate", MATERIAL]] {
            let input = format!("{HEADER}\n0.5,0,0.1,0,0,1\n{row}\n0.5,0,0.1,0,0,1\n");
            let mut command = fitter(command);
            refused(command.write_stdin(input), &["line 3", part]);
            let output = command.assert().get_output().stdout.clone();
            assert_eq!(String::from_utf8(output).unwrap().lines().count(), 2, "the row before it is answered");
        }
    }
    refused(fitter(["query", &table]).write_stdin("0.5,0,0.1,0,0,1\n"), &["line 1", HEADER]);
    refused(fitter(["query", &table]).write_stdin(""), &["line 1", HEADER]);
    refused(fitter(["query", &table]).write_stdin(vec![b'7'; 1 << 20]), &["line 1"]);
    refused(fitter(["query", &table]).write_stdin(b"\xff\xfe\n".to_vec()), &["line 1", "UTF-8"]);
}

/// A folder of small files.
fn inputs(outcome: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/inputs").join(outcome).join("csv");
    super::names(&folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Files as spreadsheets and other programs write them hold the same two rows as the plain one, in `query` and `integrate`.
#[test]
fn files_of_other_programs() {
    let table = table();
    for command in [&["query", &table][..], &["integrate", MATERIAL, "--samples", "64"]] {
        let answers = |input: &[u8]| {
            let output = fitter(command).write_stdin(input).assert().success().get_output().stdout.clone();
            let mut reader = csv::Reader::from_reader(&output[..]);
            let width = reader.headers().unwrap().len();
            let new = if command[0] == "query" { 3 } else { 6 };
            reader
                .records()
                .map(|row| row.unwrap().iter().skip(width - new).map(str::to_owned).collect())
                .collect::<Vec<Vec<_>>>()
        };
        let files = inputs("valid");
        let (_, plain) = files.iter().find(|(name, _)| name == "plain.csv").unwrap();
        let plain = answers(plain);
        assert_eq!(plain.len(), 2);
        for (name, input) in &files {
            assert_eq!(answers(input), plain, "{name}");
        }
    }
}

#[test]
fn files_that_are_wrong() {
    let messages = [
        ("answers.csv", "line 1: a column r would be there twice"),
        ("infinite.csv", "line 3: omega is inf"),
        ("latin1.csv", "line 2: not UTF-8 text"),
        ("no_header.csv", "line 1: the header must be"),
        ("open_quote.csv", "line 3: wo_z is"),
        ("semicolons.csv", "line 1: the header must be"),
        ("short_row.csv", "line 4: 5 columns, 6 are needed"),
        ("twice.csv", "line 1: two columns are called \"omega\""),
        ("utf16.csv", "line 1: not UTF-8 text"),
    ];
    let files = inputs("invalid");
    assert!(files.iter().map(|(name, _)| name.as_str()).eq(messages.map(|(name, _)| name)));
    for ((_, input), (_, message)) in files.into_iter().zip(messages) {
        refused(fitter(["query", &table()]).write_stdin(input), &[message]);
    }
}

/// A program can talk to `query` row by row.
#[test]
fn answers_come_at_once() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_fitter"))
        .args(["query", &table()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap()).lines();
    writeln!(input, "{HEADER}\n0.5,0,0.1,0,0,1").unwrap();
    assert_eq!(output.next().unwrap().unwrap(), format!("{HEADER},r,g,b"));
    assert!(output.next().unwrap().unwrap().starts_with("0.5,0,0.1,0,0,1,"));
    writeln!(input, "0.25,0,0.1,0,0,1").unwrap();
    assert!(output.next().unwrap().unwrap().starts_with("0.25,"));
    drop(input);
    assert!(output.next().is_none() && child.wait().unwrap().success());
}

/// A reader that has seen enough ends the program, quietly.
#[test]
fn a_closed_pipe_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_fitter"))
        .args(["query", &table()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut input = child.stdin.take().unwrap();
    // The program may be gone before all is written.
    let _ = input.write_all((HEADER.to_string() + "\n" + &"0.5,0,0.1,0,0,1\n".repeat(20_000)).as_bytes());
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}
