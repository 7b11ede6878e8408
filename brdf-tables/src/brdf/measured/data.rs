//! The values of a measured material: as a file has them, and as a look-up wants them.

use super::lattice::Shape;
use crate::real::{Cell, Constant, Real};
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, PoisonError};

/// Longest name, bytes.
const LONGEST_NAME: usize = 64;
/// Octaves between the smallest and the largest value: what lies lower is taken as the smallest.
pub const OCTAVES: f64 = 40.0;

/// What keeps 1 within the last cell, in single precision too.
pub const INSIDE: f64 = 1.0 - 1.0 / (1u32 << 22) as f64;

/// What a file has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stored {
    /// What it is called.
    pub name: String,
    /// Nodes along the coordinates of [`super::coordinates::unit`].
    pub lattice: [u16; 3],
    /// Binary logarithms of f_r in sr⁻¹ that 0 and 65535 stand for.
    pub range: [f64; 2],
    /// Values, the last coordinate the fastest.
    pub values: Vec<u16>,
    /// Nodes of the colours; none where everything is grey.
    pub tint_lattice: Option<[u16; 3]>,
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
    /// The corners of the cells: with one reading for eight values. Pairs of neighbours along the last coordinate, the first in
    /// the low half, at a node of the second and at the next, then the same at the next node of the first.
    cells: Vec<Cell>,
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
        let lattice = shape(stored.lattice)?;
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
        let tint = match stored.tint_lattice {
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
        let [rows, columns, depth] = lattice.nodes();
        let pair_at = |i: usize| pair(&stored.values[i..i + 2]);
        let mut cells = Vec::with_capacity((rows - 1) * (columns - 1) * (depth - 1));
        for (h, d) in (0..rows - 1).flat_map(|h| (0..columns - 1).map(move |d| (h, d))) {
            let corner = |up: usize, beside: usize, p: usize| pair_at(lattice.index([h + up, d + beside, p]));
            cells.extend((0..depth - 1).map(|p| [corner(0, 0, p), corner(0, 1, p), corner(1, 0, p), corner(1, 1, p)]));
        }
        let mut hasher = crc32fast::Hasher::new();
        for numbers in [&stored.values, &stored.tint] {
            hasher.update(bytemuck::cast_slice(numbers));
        }
        hasher.update(bytemuck::bytes_of(&[low, high, stored.alpha, stored.share]));
        let checksum = hasher.finalize();
        Ok(Self { stored, shape: lattice, cells, tint, checksum, checksum_text: format!("{checksum:08x}") })
    }

    /// Pairs of neighbours along the last coordinate, the first in the low half.
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
    cells: &'a [Cell],
    /// Cells along each axis, and what unit coordinates are multiplied by: a little less, so that 1 lies in the last cell.
    count: [Constant; 3],
    scale: [Constant; 3],
    /// The binary logarithm of a value that is kept as x is `low` + `step` x.
    low: Constant,
    step: Constant,
}

impl<'a> Lookup<'a> {
    #[inline(always)]
    pub fn new(data: &'a Data) -> Self {
        let nodes = data.shape.nodes();
        let [first, last] = data.stored.range;
        // They are fetched as 1 + n/65536.
        let step = (last - first) * (65536.0 / 65535.0);
        Self {
            cells: &data.cells,
            count: nodes.map(|n| Constant::from((n - 1) as f64)),
            scale: nodes.map(|n| Constant::from((n - 1) as f64 * INSIDE)),
            low: (first - step).into(),
            step: step.into(),
        }
    }

    /// f_r in sr⁻¹ at unit coordinates.
    #[inline(always)]
    pub fn value<T: Real>(&self, [h, d, p]: [T; 3]) -> T {
        let (columns, depth) = (h.constant(self.count[1]), h.constant(self.count[2]));
        let (h, fh) = place(h, self.scale[0]);
        let (d, fd) = place(d, self.scale[1]);
        let (p, fp) = place(p, self.scale[2]);
        let [a, b, c, d] = T::fetch_cell(h.mul_add(columns, d).mul_add(depth, p), self.cells);
        let (low, high) = (mix([mix(a, fp), mix(b, fp)], fd), mix([mix(c, fp), mix(d, fp)], fd));
        let value = mix([low, high], fh);
        value.mul_add(h.constant(self.step), h.constant(self.low)).exp2()
    }
}

// Functions that are told to be inlined, which closures cannot be: in lanes, what is not inlined calls a function per operation.

/// The node below a unit coordinate, and the way to the next.
#[inline(always)]
fn place<T: Real>(x: T, scale: Constant) -> (T, T) {
    let at = x * x.constant(scale);
    let low = at.floor();
    (low, at - low)
}

/// The value on the way from one to the other.
#[inline(always)]
fn mix<T: Real>([near, far]: [T; 2], way: T) -> T {
    (far - near).mul_add(way, near)
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
