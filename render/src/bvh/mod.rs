//! Triangles under an eight-wide bounding volume hierarchy.
//!
//! `binary` cuts the triangles from the top by the surface area heuristic (`bins`), obvhs mends that tree, `fold` chooses which of
//! its nodes become nodes of eight children above leaves of eight triangles, and `build` stores these lane by lane so that
//! `traverse` tests eight of either at once. Boxes keep full precision and the triangle test is watertight: a ray cannot slip
//! between two triangles that share an edge.

mod binary;
mod bins;
mod build;
mod fold;
mod stack;
#[cfg(test)]
mod tests;
mod traverse;
mod turns;

pub use build::TriangleBvh;
pub(crate) use stack::Lanes;
pub use stack::Stack;

/// Children of a node and triangles of a leaf: the lanes of one vector operation.
const WIDTH: usize = 8;

/// Marks a reference to a leaf; the other bits are the index.
const LEAF: u32 = 1 << 31;

/// Child boxes and references, lane by lane. A lane without child has an empty box.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
struct Node {
    /// min x, min y, min z, max x, max y, max z.
    bounds: [[f32; WIDTH]; 6],
    children: [u32; WIDTH],
}

/// Up to eight triangles. A lane without triangle has all vertices at the origin and is never hit.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
struct Leaf {
    /// By vertex, by axis.
    vertices: [[[f32; WIDTH]; 3]; 3],
    /// Number of the triangle in the builder's list.
    ids: [u32; WIDTH],
}
