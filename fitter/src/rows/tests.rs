use super::*;

const HEADER: &str = "theta_e,phi_e,omega,wo_x,wo_y,wo_z\n";

/// Output and error for the rows under a good header.
fn answers(rows: &str) -> (String, Option<String>) {
    let mut output = Vec::new();
    let input = format!("{HEADER}{rows}");
    let result = answer(input.as_bytes(), &mut output, ["index", "z"], |i, _, wo| [i as f64, wo.z]);
    (String::from_utf8(output).unwrap(), result.err().map(|e| format!("{e:#}")))
}

#[test]
fn rows_come_back_with_their_answers() {
    let (output, error) = answers("0.5, 0, 1, 0, 0, 1\r\n\n0.5,0,1,0.6,0,0.8");
    let expected =
        "theta_e,phi_e,omega,wo_x,wo_y,wo_z,index,z\n0.5, 0, 1, 0, 0, 1,0.0,1.0\n0.5,0,1,0.6,0,0.8,1.0,0.8\n";
    assert_eq!((output.as_str(), error), (expected, None));
}

#[test]
fn a_bad_row_is_one_error_with_its_line() {
    let bad = [
        ("1,0,1,0,0", "5 columns"),
        ("1,0,1,0,0,1,2", "7 columns"),
        ("1,0,x,0,0,1", "omega is \"x\""),
        ("1,0,nan,0,0,1", "omega is NaN"),
        ("1,0,inf,0,0,1", "omega is inf"),
        ("2,0,1,0,0,1", "theta_e = 2"),
        ("1,0,0,0,0,1", "omega = 0"),
        ("1,0,1,0,0,1.1", "length"),
        ("1,0,1,0,0,-1", "horizon"),
        ("1,0,1,1,0,0", "horizon"),
    ];
    for (row, what) in bad {
        let (output, error) = answers(&format!("1,0,1,0,0,1\n{row}\n1,0,1,0,0,1\n"));
        let error = error.unwrap();
        assert!(error.starts_with("standard input, line 3: ") && error.contains(what), "{row}: {error}");
        assert_eq!(output.lines().count(), 2, "the row before it is answered");
    }
}

#[test]
fn a_line_without_end_is_refused() {
    let (_, error) = answers(&"1".repeat(100_000));
    assert!(error.unwrap().contains("line 2: longer than 4096"));
    let result = answer(&b"theta,phi\n"[..], Vec::new(), ["x"], |_, _, _| [0.0]);
    assert!(format!("{:#}", result.unwrap_err()).contains("line 1: the header must be"));
}

/// What spreadsheets and other programs write: quotes, a byte order mark, any end of line, empty rows, more columns in
/// another order.
#[test]
fn csv_as_others_write_it() {
    let run = |text: &str| {
        let mut output = Vec::new();
        let result = answer(text.as_bytes(), &mut output, ["index", "z"], |i, _, wo| [i as f64, wo.z]);
        (String::from_utf8(output).unwrap(), result.err().map(|e| format!("{e:#}")))
    };
    let rows = "0.5,0,1,0,0,1\n0.5,0,1,0.6,0,0.8\n";
    let plain = run(&format!("{HEADER}{rows}"));
    assert_eq!(plain.1, None);
    for text in [
        format!("\u{feff}{HEADER}{rows}"),
        format!("\u{feff}{}", format!("{HEADER}{rows}").replace('\n', "\r\n")),
        format!("{HEADER}{rows}").replace('\n', "\r"),
        format!("{HEADER}\n{rows}\n   \n,,,,,\n\r\n"),
        format!("\"theta_e\",\"phi_e\",omega,wo_x,wo_y,\"wo_z\"\n{}", rows.replace("0.5", "\"0.5\"")),
    ] {
        assert_eq!(run(&text), plain, "{text:?}");
    }
    let (output, error) = run("name,wo_z,wo_y,wo_x,omega,phi_e,theta_e\n\"a \"\"b\"\", c\nd\",1,0,0,1,0,0.5\n");
    assert_eq!(error, None);
    let row = "\"a \"\"b\"\", c\nd\",1,0,0,1,0,0.5,0.0,1.0\n";
    assert_eq!(output, format!("name,wo_z,wo_y,wo_x,omega,phi_e,theta_e,index,z\n{row}"));
    for (text, parts) in [
        ("theta_e,phi_e,omega,wo_x,wo_y\n", "line 1: the header must be theta_e,phi_e,omega,wo_x,wo_y,wo_z; wo_z"),
        ("theta_e;phi_e;omega;wo_x;wo_y;wo_z\n", "line 1: the header must be"),
        ("theta_e,phi_e,omega,wo_x,wo_y,wo_z,z\n", "line 1: a column z would be there twice"),
        ("theta_e,phi_e,omega,wo_x,wo_y,wo_z,omega\n", "line 1: two columns are called \"omega\""),
        (
            "theta_e,phi_e,omega,wo_x,wo_y,wo_z\r\n\r\n0.5,0,1,0,0,1\r\n0.5,0,1,0,0,\"one\"\r\n",
            "line 4: wo_z is \"one\"",
        ),
        ("theta_e,phi_e,omega,wo_x,wo_y,wo_z\r0.5,0,1,0,0,x", "line 2: wo_z is \"x\""),
    ] {
        let (_, error) = run(text);
        assert!(error.as_ref().is_some_and(|e| e.contains(parts)), "{text:?}: {error:?}");
    }
}
