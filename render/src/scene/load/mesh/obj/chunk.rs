//! A piece of an OBJ file, read without the others: indices stay as written, for how much came before is not known yet.

use super::super::text::{Lines, argument, integer, number, quote, words};
use glam::{Vec2, Vec3};

/// Numbers of positions, texture coordinates and normals.
pub(super) type Counts = [usize; 3];

/// Indices of a corner (position, texture coordinate, normal) as written: from 1, or negative from the last one given
/// before; [`ABSENT`] where there is none.
pub(super) type Corner = [i32; 3];

/// No index is this low.
pub(super) const ABSENT: i32 = i32::MIN;

/// What an index is of, in the order of [`Corner`].
pub(super) const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// A face.
pub(super) struct Face {
    /// Line in the piece, counted from 1.
    pub line: usize,
    /// One past its last corner.
    pub end: usize,
}

/// Why a piece ends.
pub(super) enum Wrong {
    /// Whatever came before it.
    Anyway(String),
    /// An index that no file reaches.
    Index { kind: usize, written: i64 },
    /// The position of a vertex.
    Position(Vec3),
}

/// What a piece holds, in the order of the file.
#[derive(Default)]
pub(super) struct Chunk {
    pub positions: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub faces: Vec<Face>,
    pub corners: Vec<Corner>,
    /// From which face on so much of the piece is given.
    pub given: Vec<(usize, Counts)>,
    /// From which face on which material holds.
    pub begins: Vec<(usize, String)>,
    /// Files of materials.
    pub files: Vec<String>,
    pub ignored: Ignored,
    /// Whether a line begins with a word of the format; `None` without words.
    pub is_obj: Option<bool>,
    /// Number of lines.
    pub lines: usize,
    /// The line that ended it.
    pub wrong: Option<(usize, Wrong)>,
}

impl Chunk {
    /// Reads whole lines.
    pub fn read(bytes: &[u8], keep_v: bool) -> Self {
        let mut this = Self::default();
        let mut lines = Lines::new(bytes);
        for (number, line) in lines.by_ref() {
            if let Err(wrong) = this.line(number, &line, keep_v) {
                this.wrong = Some((number, wrong));
                break;
            }
        }
        this.lines = lines.read();
        this
    }

    fn counts(&self) -> Counts {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    fn line(&mut self, number: usize, line: &[u8], keep_v: bool) -> Result<(), Wrong> {
        let mut words = words(line);
        let Some(word) = words.next().filter(|w| !w.starts_with(b"#")) else { return Ok(()) };
        match word {
            b"v" => {
                // Behind it there may be a weight or a colour.
                let position = Vec3::from(floats(words, 3)?);
                if !position.is_finite() {
                    return Err(Wrong::Position(position));
                }
                self.positions.push(position);
            }
            b"vn" => self.normals.push(Vec3::from(floats(words, 3)?)),
            b"vt" => {
                let [u, v] = floats(words, 1)?;
                self.uvs.push(Vec2::new(u, if keep_v { v } else { 1.0 - v }));
            }
            b"f" => {
                let counts = self.counts();
                if self.given.last().is_none_or(|(_, last)| *last != counts) {
                    self.given.push((self.faces.len(), counts));
                }
                for word in words.take_while(|w| !w.starts_with(b"#")) {
                    self.corners.push(corner(word)?);
                }
                self.faces.push(Face { line: number, end: self.corners.len() });
            }
            b"usemtl" => self.begins.push((self.faces.len(), argument(line))),
            b"mtllib" => self.files.push(argument(line)),
            other if self.ignored.count(other) => {}
            _ => {
                self.is_obj.get_or_insert(false);
                return Ok(());
            }
        }
        self.is_obj = Some(true);
        Ok(())
    }
}

/// Parses `p`, `p/t`, `p//n` or `p/t/n`.
#[inline]
fn corner(word: &[u8]) -> Result<Corner, Wrong> {
    let mut corner = [ABSENT; 3];
    for (kind, field) in word.split(|&b| b == b'/').take(3).enumerate() {
        if kind > 0 && field.is_empty() {
            continue;
        }
        let written = integer(field).ok_or_else(|| Wrong::Anyway(format!("{} is not an index", quote(field))))?;
        let fits = i32::try_from(written).ok().filter(|i| *i != ABSENT);
        corner[kind] = fits.ok_or(Wrong::Index { kind, written })?;
    }
    Ok(corner)
}

/// The first `N` numbers of a line, of which `needed` must be there; the others are 0 where they are not.
fn floats<'a, const N: usize>(mut words: impl Iterator<Item = &'a [u8]>, needed: usize) -> Result<[f32; N], Wrong> {
    let mut out = [0.0; N];
    for (i, value) in out.iter_mut().enumerate() {
        let Some(word) = words.next().filter(|w| i < needed || !w.starts_with(b"#")) else {
            if i < needed {
                return Err(Wrong::Anyway(format!("expected {needed} numbers, found {i}")));
            }
            break;
        };
        *value = number(word).ok_or_else(|| Wrong::Anyway(format!("{} is not a number", quote(word))))?;
    }
    Ok(out)
}

/// Statements of the format that are not drawn.
#[derive(Default)]
pub(super) struct Ignored {
    elements: Vec<(&'static str, usize)>,
}

impl Ignored {
    /// Whether the word is of the format; elements that would be seen are counted.
    fn count(&mut self, word: &[u8]) -> bool {
        const ELEMENTS: [&str; 5] = ["l", "p", "curv", "curv2", "surf"];
        const OTHERS: [&[u8]; 4] = [b"g", b"o", b"s", b"vp"];
        let Some(name) = ELEMENTS.iter().find(|name| name.as_bytes() == word) else { return OTHERS.contains(&word) };
        self.add(name, 1);
        true
    }

    fn add(&mut self, name: &'static str, more: usize) {
        match self.elements.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += more,
            None => self.elements.push((name, more)),
        }
    }

    /// Those of a later piece too.
    pub fn append(&mut self, later: Self) {
        later.elements.into_iter().for_each(|(name, count)| self.add(name, count));
    }

    pub fn warning(&self) -> Option<String> {
        let list: Vec<_> = self.elements.iter().map(|(name, count)| format!("{count} `{name}`")).collect();
        (!list.is_empty()).then(|| format!("lines, points and free-form surfaces are not drawn: {}", list.join(", ")))
    }
}
