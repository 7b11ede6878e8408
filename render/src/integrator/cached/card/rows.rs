//! Numbers as shaders have them: rows of four words, a vector and a fourth.

use glam::Vec3A;

/// A vector and a word, or four numbers.
pub type Row = [u32; 4];

/// A vector and a number.
pub fn number(v: Vec3A, x: f32) -> Row {
    word(v, x.to_bits())
}

/// A vector and a word.
pub fn word(v: Vec3A, x: u32) -> Row {
    let [a, b, c] = v.to_array().map(f32::to_bits);
    [a, b, c, x]
}

/// The vector and the number of a row.
pub fn back(row: Row) -> (Vec3A, f32) {
    let [a, b, c, d] = row.map(f32::from_bits);
    (Vec3A::new(a, b, c), d)
}
