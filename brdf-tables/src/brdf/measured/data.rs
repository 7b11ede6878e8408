//! The values of a measured material: as a file has them, and as a look-up wants them.

use super::lattice::Shape;
use crate::real::Real;
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Longest name, bytes.
const LONGEST_NAME: usize = 64;
/// Octaves between the smallest and the largest value: what lies lower is taken as the smallest.
pub const OCTAVES: f64 = 40.0;

/// What a file has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stored {
    /// What it is called.
    pub name: String,
    /// Nodes along √θh, θd, φd.
    pub nodes: [u16; 3],
    /// Binary logarithms of f_r in sr⁻¹ that 0 and 65535 stand for.
    pub range: [f64; 2],
    /// Values, φd the fastest.
    pub values: Vec<u16>,
    /// Nodes of the colours; none where everything is grey.
    pub tint_nodes: Option<[u16; 3]>,
    /// Three a node: channels over the grey value, of which 65535 is three.
    pub tint: Vec<u16>,
    /// Roughness of the GGX normals of the sampler.
    pub alpha: f64,
    /// Probability of the sampler's cosine.
    pub share: f64,
}

/// What a look-up wants.
pub struct Data {
    pub stored: Stored,
    pub shape: Shape,
    /// Pairs of neighbours along φd, the first in the low half.
    pairs: Vec<u32>,
    pub tint: Option<(Shape, Vec<[f32; 3]>)>,
    pub checksum: u32,
    pub checksum_text: String,
}

impl Data {
    /// From what a file has.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn new(stored: Stored) -> Result<Self, &'static str> {
        let shape =
            |nodes: [u16; 3]| Shape::new(nodes.map(usize::from)).ok_or("a lattice of measured values out of range");
        let lattice = shape(stored.nodes)?;
        if stored.name.len() > LONGEST_NAME || !stored.name.chars().all(|c| c.is_alphanumeric() || "._- ".contains(c)) {
            return Err(
                "the name of a measured material is too long, or has other signs than letters, digits, . _ and -",
            );
        }
        if stored.values.len() != lattice.len() {
            return Err("the lattice of measured values is not filled");
        }
        let [low, high] = stored.range;
        // Bounds that keep every value a normal number in single precision.
        if !(low >= -100.0 && low <= high && high <= 60.0 && high - low <= OCTAVES + 1e-9) {
            return Err("the range of measured values is none");
        }
        if !(1e-3..=1.0).contains(&stored.alpha) || !(0.0..=0.99).contains(&stored.share) {
            return Err("the sampler of a measured material is out of range");
        }
        let tint = match stored.tint_nodes {
            None if stored.tint.is_empty() => None,
            None => return Err("colours without their lattice"),
            Some(nodes) => {
                let shape = shape(nodes)?;
                if stored.tint.len() != 3 * shape.len() {
                    return Err("the lattice of colours is not filled");
                }
                let (colors, _) = stored.tint.as_chunks::<3>();
                let channel = |t: u16| f32::from(t) * (3.0 / 65535.0);
                Some((shape, colors.iter().map(|c| c.map(channel)).collect()))
            }
        };
        let [_, _, columns] = lattice.nodes();
        let pair = |w: &[u16]| u32::from(w[0]) | u32::from(w[1]) << 16;
        let pairs = stored.values.chunks_exact(columns).flat_map(|row| row.windows(2).map(pair)).collect();
        let mut hasher = crc32fast::Hasher::new();
        for numbers in [&stored.values, &stored.tint] {
            hasher.update(bytemuck::cast_slice(numbers));
        }
        hasher.update(bytemuck::bytes_of(&[low, high, stored.alpha, stored.share]));
        let checksum = hasher.finalize();
        Ok(Self { stored, shape: lattice, pairs, tint, checksum, checksum_text: format!("{checksum:08x}") })
    }

    /// Pairs of neighbours along φd, the first in the low half.
    #[cfg(feature = "wgsl")]
    pub fn pairs(&self) -> &[u32] {
        &self.pairs
    }

    /// f_r in sr⁻¹ at unit coordinates.
    #[inline(always)]
    pub fn value<T: Real>(&self, x: [T; 3]) -> T {
        let [rows, columns, depth] = self.shape.nodes();
        let ((h, fh), (d, fd), (p, fp)) = (place(x[0], rows), place(x[1], columns), place(x[2], depth));
        let row = depth - 1;
        let index = (h * h.lit(columns as f64) + d) * h.lit(row as f64) + p;
        let pairs = &self.pairs[..];
        let (near, beside) = (between(index, fp, pairs), between(index, fp, &pairs[row..]));
        let (above, across) =
            (between(index, fp, &pairs[columns * row..]), between(index, fp, &pairs[(columns + 1) * row..]));
        let low = (beside - near).mul_add(fd, near);
        let high = (across - above).mul_add(fd, above);
        let [first, last] = self.stored.range;
        let step = x[0].lit((last - first) / 65535.0);
        (high - low).mul_add(fh, low).mul_add(step, x[0].lit(first)).exp2()
    }
}

// Functions that are told to be inlined, which closures cannot be: in lanes, what is not inlined calls a function per operation.

/// The node below a unit coordinate, and the way to the next.
#[inline(always)]
fn place<T: Real>(x: T, nodes: usize) -> (T, T) {
    let at = x * x.lit((nodes - 1) as f64);
    let low = at.min(x.lit((nodes - 2) as f64)).max(x.lit(0.0)).floor();
    (low, at - low)
}

/// The value on the way `by` between the pair at an index.
#[inline(always)]
fn between<T: Real>(index: T, by: T, pairs: &[u32]) -> T {
    let (a, b) = T::fetch_pair(index, pairs);
    (b - a).mul_add(by, a)
}

/// Keeps values for the life of the process: the ones that are there already, where they are the same.
pub fn keep(data: Data) -> &'static Data {
    static KEPT: Mutex<Vec<&'static Data>> = Mutex::new(Vec::new());
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(same) = kept.iter().find(|k| k.checksum == data.checksum && k.stored == data.stored) {
        return same;
    }
    let data: &'static Data = Box::leak(Box::new(data));
    kept.push(data);
    data
}
