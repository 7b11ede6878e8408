//! One of several things in a file, by name or by number.

use super::error::brief;

/// The place in `names` that `wanted` means: a name, or else a number counted from 0. A thing may have several names.
///
/// # Errors
/// No such thing, or several of that name: with what there is.
pub fn choose(kind: &str, wanted: &str, names: &[Vec<impl AsRef<str>>]) -> Result<usize, String> {
    let mut of_name =
        names.iter().enumerate().filter(|(_, own)| own.iter().any(|name| name.as_ref() == wanted)).map(|(i, _)| i);
    match (of_name.next(), of_name.next()) {
        (Some(only), None) => return Ok(only),
        (Some(_), Some(_)) => return Err(format!("several {kind}s are called `{wanted}`: {}", list(names))),
        (None, _) => {}
    }
    match wanted.parse::<usize>() {
        Ok(i) if i < names.len() => Ok(i),
        _ if names.is_empty() => Err(format!("no {kind} `{wanted}`: there is none at all")),
        _ => Err(format!("no {kind} `{wanted}`: there are {}", list(names))),
    }
}

/// `0 (front), 1 (back)`: as many as fit into a line.
pub fn list(names: &[Vec<impl AsRef<str>>]) -> String {
    const MOST: usize = 12;
    let more = if names.len() > MOST { ", …" } else { "" };
    let first = names.iter().enumerate().take(MOST).map(|(i, own)| match own.first() {
        Some(name) => format!("{i} ({})", brief(name.as_ref())),
        None => i.to_string(),
    });
    first.collect::<Vec<_>>().join(", ") + more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_win_over_numbers() {
        let names = [vec!["front", "Camera"], vec!["0"], vec![], vec!["side", "Camera"]];
        let choose = |wanted| choose("camera", wanted, &names);
        assert_eq!(["front", "0", "1", "2", "side"].map(choose), [Ok(0), Ok(1), Ok(1), Ok(2), Ok(3)]);
        let all = "0 (front), 1 (0), 2, 3 (side)";
        assert_eq!(choose("Camera").unwrap_err(), format!("several cameras are called `Camera`: {all}"));
        for missing in ["4", "-1", "", "Front"] {
            assert_eq!(choose(missing).unwrap_err(), format!("no camera `{missing}`: there are {all}"));
        }
        assert_eq!(super::choose("scene", "a", &[] as &[Vec<&str>]).unwrap_err(), "no scene `a`: there is none at all");
    }
}
