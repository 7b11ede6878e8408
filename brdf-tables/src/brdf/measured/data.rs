//! The values of a measured material: as a file has them, and as a look-up wants them.

use super::lattice::Shape;
use crate::real::{Constant, Real};
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
    /// Pairs of neighbours along φd, the first in the low half, at a node of θd and at the next: with one reading for four values.
    quads: Vec<[u32; 2]>,
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
        let [_, columns, depth] = lattice.nodes();
        let mut quads = Vec::with_capacity(lattice.len());
        for plane in stored.values.chunks_exact(columns * depth) {
            let rows: Vec<&[u16]> = plane.chunks_exact(depth).collect();
            for beside in rows.windows(2) {
                quads.extend(beside[0].windows(2).zip(beside[1].windows(2)).map(|(a, b)| [pair(a), pair(b)]));
            }
        }
        let mut hasher = crc32fast::Hasher::new();
        for numbers in [&stored.values, &stored.tint] {
            hasher.update(bytemuck::cast_slice(numbers));
        }
        hasher.update(bytemuck::bytes_of(&[low, high, stored.alpha, stored.share]));
        let checksum = hasher.finalize();
        Ok(Self { stored, shape: lattice, quads, tint, checksum, checksum_text: format!("{checksum:08x}") })
    }

    /// Pairs of neighbours along φd, the first in the low half.
    #[cfg(feature = "wgsl")]
    pub fn pairs(&self) -> Vec<u32> {
        let [_, _, depth] = self.shape.nodes();
        self.stored.values.chunks_exact(depth).flat_map(|row| row.windows(2).map(pair)).collect()
    }

    /// f_r in sr⁻¹ at unit coordinates.
    pub fn value(&self, x: [f64; 3]) -> f64 {
        Lookup::new(self).value(x)
    }
}

/// The values with the constants of their look-up, which are made once for many directions.
pub struct Lookup<'a> {
    quads: &'a [[u32; 2]],
    /// Quads of a plane of θh.
    plane: usize,
    /// Last node of each axis, and the last but one.
    last: [Constant; 3],
    before: [Constant; 3],
    /// Quads of a row of φd, and rows of a plane.
    row: Constant,
    rows: Constant,
    /// Binary logarithm of the smallest value, and of the factor from one to the next.
    low: Constant,
    step: Constant,
}

impl<'a> Lookup<'a> {
    #[inline(always)]
    pub fn new(data: &'a Data) -> Self {
        let nodes = data.shape.nodes();
        let [_, columns, depth] = nodes;
        let constant = |n: usize| Constant::from(n as f64);
        let [first, last] = data.stored.range;
        Self {
            quads: &data.quads,
            plane: (columns - 1) * (depth - 1),
            last: nodes.map(|n| constant(n - 1)),
            before: nodes.map(|n| constant(n - 2)),
            row: constant(depth - 1),
            rows: constant(columns - 1),
            low: first.into(),
            step: ((last - first) / 65535.0).into(),
        }
    }

    /// f_r in sr⁻¹ at unit coordinates.
    #[inline(always)]
    pub fn value<T: Real>(&self, [h, d, p]: [T; 3]) -> T {
        let (h, fh) = place(h, self.last[0], self.before[0]);
        let (d, fd) = place(d, self.last[1], self.before[1]);
        let (p, fp) = place(p, self.last[2], self.before[2]);
        let index = (h * h.constant(self.rows) + d) * h.constant(self.row) + p;
        let low = across(index, (fd, fp), self.quads);
        let high = across(index, (fd, fp), &self.quads[self.plane..]);
        (high - low).mul_add(fh, low).mul_add(h.constant(self.step), h.constant(self.low)).exp2()
    }
}

// Functions that are told to be inlined, which closures cannot be: in lanes, what is not inlined calls a function per operation.

/// The node below a unit coordinate, and the way to the next.
#[inline(always)]
fn place<T: Real>(x: T, last: Constant, before: Constant) -> (T, T) {
    let at = x * x.constant(last);
    let low = at.min(x.constant(before)).max(x.lit(0.0)).floor();
    (low, at - low)
}

/// The value between the four of an index, on the ways along θd and φd.
#[inline(always)]
fn across<T: Real>(index: T, (fd, fp): (T, T), quads: &[[u32; 2]]) -> T {
    let [a, b, c, d] = T::fetch_quad(index, quads);
    let (near, beside) = ((b - a).mul_add(fp, a), (d - c).mul_add(fp, c));
    (beside - near).mul_add(fd, near)
}

/// Two neighbours, the first in the low half.
fn pair(w: &[u16]) -> u32 {
    u32::from(w[0]) | u32::from(w[1]) << 16
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
