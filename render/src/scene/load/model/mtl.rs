//! MTL, the materials of OBJ: `Kd`, `Ks`, `Ns`, `Ke`, `d` or `Tr`, `Ni`, `illum`, and `map_Kd`.

use crate::scene::load::error::FileError;
use crate::scene::load::mesh::text::{Lines, argument, number, quote, skip_mark, words};
use std::collections::BTreeSet;
use std::path::Path;

/// A material as it stands in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub name: String,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
    /// Exponent of the specular lobe.
    pub exponent: f32,
    pub emitted: [f32; 3],
    /// 1 where the surface is there, 0 where it is not.
    pub opacity: f32,
    pub ior: f32,
    /// Number of the illumination model.
    pub model: i64,
    /// File of `map_Kd`.
    pub diffuse_map: Option<String>,
}

impl Entry {
    fn new(name: String) -> Self {
        let (diffuse, specular, emitted) = ([0.8; 3], [0.0; 3], [0.0; 3]);
        Self { name, diffuse, specular, exponent: 0.0, emitted, opacity: 1.0, ior: 1.0, model: 2, diffuse_map: None }
    }
}

/// Parses a file; also returns the maps that it names and that are not drawn.
///
/// # Errors
/// Numbers that are none, negative or not finite, naming the line.
pub fn parse(bytes: &[u8], path: &Path) -> Result<(Vec<Entry>, BTreeSet<String>), FileError> {
    let (mut entries, mut ignored) = (Vec::new(), BTreeSet::new());
    for (line_number, line) in Lines::new(skip_mark(bytes, path)?) {
        let mut rest = words(&line);
        let Some(word) = rest.next().filter(|w| !w.starts_with(b"#")) else { continue };
        let error = |what: String| FileError::at(path, line_number, what);
        if word == b"newmtl" {
            entries.push(Entry::new(argument(&line)));
            continue;
        }
        let Some(entry) = entries.last_mut() else { continue };
        let mut numbers = Vec::new();
        let mut value = || -> Result<f32, FileError> {
            let word = rest.next().unwrap_or_default();
            let value = number::<f32>(word).filter(|x| x.is_finite() && *x >= 0.0);
            value.ok_or_else(|| error(format!("{} is no number ≥ 0", quote(word))))
        };
        match word {
            b"Kd" | b"Ks" | b"Ke" if !words(&line).nth(1).is_some_and(|w| w == b"spectral" || w == b"xyz") => {
                let given = words(&line).skip(1).take_while(|w| !w.starts_with(b"#")).count();
                // One number stands for all three.
                for _ in 0..if given == 1 { 1 } else { 3 } {
                    numbers.push(value()?);
                }
                let color = [0, 1, 2].map(|i| numbers[i.min(numbers.len() - 1)]);
                match word {
                    b"Kd" => entry.diffuse = color,
                    b"Ks" => entry.specular = color,
                    _ => entry.emitted = color,
                }
            }
            b"Ns" => entry.exponent = value()?,
            b"Ni" => entry.ior = value()?,
            b"d" => entry.opacity = value()?.min(1.0),
            b"Tr" => entry.opacity = 1.0 - value()?.min(1.0),
            b"illum" => entry.model = value()? as i64,
            b"map_Kd" => entry.diffuse_map = Some(file_of_map(&argument(&line))),
            other if other.starts_with(b"map_") || [&b"bump"[..], b"disp", b"norm", b"refl"].contains(&other) => {
                ignored.insert(String::from_utf8_lossy(other).into_owned());
            }
            _ => {}
        }
    }
    Ok((entries, ignored))
}

/// The file of a map, behind its options.
fn file_of_map(text: &str) -> String {
    let mut words = text.split_whitespace().peekable();
    let mut rest = text;
    while let Some(option) = words.next_if(|w| w.starts_with('-')) {
        let values = match option {
            "-s" | "-o" | "-t" => 3,
            "-mm" => 2,
            _ => 1,
        };
        let mut passed = vec![option];
        // Of three numbers the last two may be left out.
        for _ in 0..values {
            let next = words.next_if(|w| values < 3 || w.parse::<f32>().is_ok());
            passed.extend(next);
        }
        for word in passed {
            rest = rest.trim_start().strip_prefix(word).unwrap_or(rest);
        }
    }
    rest.trim().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_programs_write_it() {
        let text = b"# x\nKd 1 1 1\nnewmtl a b \r\nKd 0.5\nKs 0.1 0.2 0.3 # y\nNs 20\nKe 1 2 3\nTr 0.25\nillum 2\n\
            map_Kd -s 2 2 -clamp on my wood.png\nmap_Bump -bm 0.5 b.png\nKa spectral a\nnewmtl c\nd 0.5\nNi 1.5\nKd xyz 1 1 1\n";
        let (entries, ignored) = parse(text, Path::new("f")).unwrap();
        let expected = Entry {
            diffuse: [0.5; 3],
            specular: [0.1, 0.2, 0.3],
            exponent: 20.0,
            emitted: [1.0, 2.0, 3.0],
            opacity: 0.75,
            diffuse_map: Some("my wood.png".into()),
            ..Entry::new("a b".into())
        };
        assert_eq!(entries, [expected, Entry { opacity: 0.5, ior: 1.5, ..Entry::new("c".into()) }]);
        assert_eq!(ignored.into_iter().collect::<Vec<_>>(), ["map_Bump"]);
        for (bad, what) in
            [("Kd 1 1", "`` is no number ≥ 0"), ("Ns nan", "`nan` is"), ("d -1", "`-1` is"), ("Kd", "`` is")]
        {
            let e = parse(format!("newmtl a\n{bad}").as_bytes(), Path::new("f")).unwrap_err().to_string();
            assert!(e.starts_with("f:2: ") && e.contains(what), "{e}");
        }
    }
}
