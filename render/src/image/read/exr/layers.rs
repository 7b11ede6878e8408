//! Which channels of an OpenEXR file are the picture.
//!
//! A layer is what stands before the last dot of a channel's name, after the name of its part where there are several.
//! Taken is, in this order: a layer without a name; one with a name of the whole picture (`Combined`, `beauty`,
//! `rgba`, …); any other; last those named like data (`normal`, `depth`, `cryptomatte`, …). Of equals: red, green and
//! blue before grey, the default view before others, and then the first in the file, with a warning.

use exr::meta::header::Header;

/// Names of the whole picture, in lower case.
const WHOLE: [&str; 14] = [
    "rgba",
    "rgb",
    "combined",
    "beauty",
    "color",
    "colour",
    "image",
    "main",
    "master",
    "composite",
    "final",
    "default",
    "c",
    "ci",
];

/// Names, and parts of names, of what is no light.
const DATA: [&str; 10] = ["n", "p", "z", "uv", "st", "id", "pref", "nref", "vector", "zdepth"];
const DATA_WITHIN: [&str; 7] = ["normal", "crypto", "depth", "position", "motion", "velocity", "variance"];

/// Channels that make a colour, as indices into those of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Red, green, blue.
    Rgb([usize; 3]),
    /// Luminance and chroma: Y, RY, BY.
    Chroma([usize; 3]),
    /// One channel for all three.
    Grey(usize),
}

/// A layer with a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Index of the part.
    pub part: usize,
    /// Names of part and layer, joined by a dot; empty for the picture of a plain file.
    pub name: String,
    /// Its colour.
    pub colour: Colour,
    /// Its alpha.
    pub alpha: Option<usize>,
}

/// All layers with a colour, in the order of the file; parts of deep data have none.
pub fn layers(headers: &[Header]) -> Vec<Layer> {
    let only = headers.iter().map(|h| h.channels.list.len()).sum::<usize>() == 1;
    let mut layers = Vec::new();
    for (part, header) in headers.iter().enumerate().filter(|(_, h)| !h.deep) {
        let names: Vec<String> = header.channels.list.iter().map(|c| printable(&c.name.to_string())).collect();
        let split: Vec<(&str, &str)> = names.iter().map(|n| n.rsplit_once('.').unwrap_or(("", n))).collect();
        let mut prefixes: Vec<&str> = Vec::new();
        for (prefix, _) in &split {
            if !prefixes.contains(prefix) {
                prefixes.push(prefix);
            }
        }
        let of_part = header.own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1);
        let of_part = of_part.map(|n| printable(&n.to_string())).unwrap_or_default();
        for prefix in prefixes {
            let find = |names: &[&str]| {
                let named = |base: &str| names.iter().any(|n| n.eq_ignore_ascii_case(base));
                split.iter().position(|&(p, base)| p == prefix && named(base))
            };
            let alpha = find(&["A", "alpha"]);
            let others = split.iter().filter(|&&(p, _)| p == prefix).count() - usize::from(alpha.is_some());
            let rgb = [find(&["R", "red"]), find(&["G", "green"]), find(&["B", "blue"])];
            // The Y of a vector is no luminance.
            let y = find(&["Y"]).filter(|_| find(&["X"]).is_none() && find(&["Z"]).is_none());
            let single = find(&["R", "L", "V", "luminance", "gray", "grey"]).filter(|_| others == 1);
            let colour = match (rgb, y, find(&["RY"]), find(&["BY"])) {
                ([Some(r), Some(g), Some(b)], ..) => Colour::Rgb([r, g, b]),
                (_, Some(y), Some(ry), Some(by)) => Colour::Chroma([y, ry, by]),
                (_, Some(y), ..) => Colour::Grey(y),
                _ => match single.or(only.then_some(0)) {
                    Some(channel) => Colour::Grey(channel),
                    None => continue,
                },
            };
            layers.push(Layer { part, name: join(&of_part, prefix), colour, alpha });
        }
    }
    layers
}

/// The layer that is the picture, and a warning where another could be meant as well.
pub fn choose(headers: &[Header]) -> Result<(Layer, Option<String>), String> {
    let layers = layers(headers);
    let views = Views::new(headers);
    let key = |layer: &Layer| {
        let (rest, other_view) = views.split(layer, headers);
        (rank(&rest), matches!(layer.colour, Colour::Grey(_)), other_view)
    };
    let Some(best) = layers.iter().min_by_key(|l| key(l)) else { return Err(none(headers)) };
    let equals: Vec<_> = layers.iter().filter(|l| key(l) == key(best)).collect();
    let warning = (equals.len() > 1).then(|| {
        let others: Vec<_> = equals[1..].iter().take(3).map(|l| format!("`{}`", l.name)).collect();
        let more = if equals.len() > 4 { format!(" and {} more", equals.len() - 4) } else { String::new() };
        format!("it holds several pictures: the layer `{}` is taken, not {}{more}", best.name, others.join(", "))
    });
    Ok((best.clone(), warning))
}

/// Why there is none.
fn none(headers: &[Header]) -> String {
    if headers.iter().all(|h| h.deep) {
        return "it holds deep data only, which is not read".into();
    }
    let channels = headers.iter().flat_map(|h| h.channels.list.iter());
    let names: Vec<_> = channels.clone().take(12).map(|c| printable(&c.name.to_string())).collect();
    let more = if channels.count() > names.len() { ", …" } else { "" };
    format!("no layer with channels R, G, B or Y ({}{more})", names.join(", "))
}

/// Names come from the file and go into messages.
fn printable(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { '?' } else { c }).take(128).collect()
}

/// The name of a part and that of a layer in it, which may begin with that of the part.
fn join(part: &str, layer: &str) -> String {
    match layer.strip_prefix(part) {
        _ if layer.is_empty() => part.into(),
        _ if part.is_empty() => layer.into(),
        Some(rest) if rest.is_empty() || rest.starts_with('.') => layer.into(),
        _ => format!("{part}.{layer}"),
    }
}

/// Where a layer stands among those taken; `words` are its name in lower case.
fn rank(words: &[String]) -> u8 {
    let data = |w: &String| DATA.contains(&w.as_str()) || DATA_WITHIN.iter().any(|d| w.contains(d));
    match words.last() {
        None => 0,
        _ if words.iter().any(data) => 3,
        Some(last) if WHOLE.contains(&last.as_str()) => 1,
        Some(_) => 2,
    }
}

/// The views of a stereo file, in lower case, the default one first.
struct Views(Vec<String>);

impl Views {
    fn new(headers: &[Header]) -> Self {
        let of_part = |h: &Header| h.own_attributes.view_name.as_ref().map(|v| v.to_string().to_lowercase());
        let listed = headers.iter().find_map(|h| h.own_attributes.multi_view_names.as_ref());
        let mut views: Vec<String> = match listed {
            Some(names) => names.iter().map(|n| n.to_string().to_lowercase()).collect(),
            None => headers.iter().filter_map(of_part).collect(),
        };
        views.extend(["left".into(), "right".into()]);
        Self(views)
    }

    /// The words of a layer's name without those of views, and whether it belongs to another than the default view.
    fn split(&self, layer: &Layer, headers: &[Header]) -> (Vec<String>, bool) {
        let (views, words): (Vec<_>, Vec<_>) = layer
            .name
            .split('.')
            .filter(|w| !w.is_empty())
            .map(str::to_lowercase)
            .partition(|word| self.0.contains(word));
        let of_part = headers[layer.part].own_attributes.view_name.as_ref().map(|v| v.to_string().to_lowercase());
        (words, views.iter().chain(&of_part).any(|v| *v != self.0[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Compression, SampleType, SmallVec, Text, attribute::ChannelDescription};

    /// A file of parts: name and channels.
    fn file(parts: &[(&str, &[&str])]) -> Vec<Header> {
        let part = |(name, channels): &(&str, &[&str])| {
            let channel = |n: &&str| ChannelDescription::new(*n, SampleType::F16, false);
            let channels: SmallVec<[ChannelDescription; 5]> = channels.iter().map(channel).collect();
            let mut header = Header::new(Text::from(*name), (4, 2), channels);
            header.compression = Compression::Uncompressed;
            header
        };
        parts.iter().map(part).collect()
    }

    fn taken(parts: &[(&str, &[&str])]) -> (String, Colour, bool) {
        let (layer, warning) = choose(&file(parts)).unwrap();
        (layer.name, layer.colour, warning.is_some())
    }

    #[test]
    fn the_picture_is_found_by_name() {
        let rgb = Colour::Rgb([2, 1, 0]);
        for (parts, name, colour) in [
            (&[("", &["A", "B", "G", "R"][..])][..], "", Colour::Rgb([3, 2, 1])),
            (&[("", &["b", "g", "r"])], "", rgb),
            (&[("", &["blue", "green", "red"])], "", rgb),
            (&[("", &["Image.B", "Image.G", "Image.R", "Normal.X", "Normal.Y", "Normal.Z"])], "Image", rgb),
            (&[("N", &["X", "Y", "Z"]), ("rgba", &["B", "G", "R"])], "rgba", rgb),
            (&[("depth", &["Z"]), ("beauty", &["beauty.B", "beauty.G", "beauty.R"])], "beauty", rgb),
            (&[("diffuse", &["B", "G", "R"]), ("beauty", &["B", "G", "R"])], "beauty", rgb),
            (&[("N", &["blue", "green", "red"]), ("direct", &["B", "G", "R"])], "direct", rgb),
            (&[("", &["A", "Y"])], "", Colour::Grey(1)),
            (&[("", &["BY", "RY", "Y"])], "", Colour::Chroma([2, 1, 0])),
            (&[("", &["R"])], "", Colour::Grey(0)),
            (&[("", &["mask"])], "", Colour::Grey(0)),
            (&[("", &["left.B", "left.G", "left.R", "right.B", "right.G", "right.R"])], "left", rgb),
            (&[("", &["B", "G", "R", "right.B", "right.G", "right.R"])], "", rgb),
            (&[("", &["B", "G", "R", "direct.B", "direct.G", "direct.R", "normal.X", "normal.Y"])], "", rgb),
        ] {
            assert_eq!(taken(parts), (name.into(), colour, false), "{parts:?}");
        }
        let blender = ["V.Combined.B", "V.Combined.G", "V.Combined.R", "V.DiffCol.B", "V.DiffCol.G", "V.DiffCol.R"];
        assert_eq!(taken(&[("", &blender)]), ("V.Combined".into(), rgb, false));
    }

    #[test]
    fn a_choice_is_told() {
        let parts: &[(&str, &[&str])] = &[("", &["direct.B", "direct.G", "direct.R", "glow.B", "glow.G", "glow.R"])];
        let (layer, warning) = choose(&file(parts)).unwrap();
        assert_eq!(layer.name, "direct");
        assert!(warning.unwrap().contains("`direct` is taken, not `glow`"));
    }

    #[test]
    fn vectors_are_no_colours() {
        for channels in [&["X", "Y", "Z"][..], &["N.X", "N.Y", "N.Z"], &["U", "V"], &["A", "Z"], &["G", "R"]] {
            let e = choose(&file(&[("", channels)])).unwrap_err();
            assert!(e.contains(&channels.join(", ")), "{e}");
        }
    }
}
